//! Angles that begin anew after a turn, or after as many counts as their counter holds.
//!
//! Undone by the shortest way from sample to sample, which is right as long as nothing moves half a
//! period between two samples; how near it came to that is told.

/// What undoing has found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Unwrapped {
    /// How many times the angle began anew.
    pub times: usize,
    /// The longest step between two samples afterwards, in periods.
    pub longest: f64,
}

/// Share of a period from which on a step may as well be one the other way.
pub(super) const DOUBTFUL: f64 = 0.35;

/// Makes an angle go on where it begins anew; missing values are passed over.
pub(super) fn unwrap(values: &mut [f64], period: f64) -> Unwrapped {
    let mut found = Unwrapped { times: 0, longest: 0.0 };
    let (mut turns, mut last) = (0.0, f64::NAN);
    for value in values.iter_mut().filter(|value| !value.is_nan()) {
        if !last.is_nan() {
            // Whole periods alone are added, so that what does not wrap stays as it was.
            let jump = ((*value + turns * period - last) / period).round();
            turns -= jump;
            found.times += usize::from(jump != 0.0);
            found.longest = found.longest.max((*value + turns * period - last).abs() / period);
        }
        if turns != 0.0 {
            *value += turns * period;
        }
        last = *value;
    }
    found
}

/// Makes a clock go on that begins anew: it runs forward alone, however long it stood.
pub(super) fn forward(values: &mut [f64], period: f64) {
    let (mut turns, mut last) = (0.0, f64::NEG_INFINITY);
    for value in values.iter_mut().filter(|value| !value.is_nan()) {
        turns += if *value < last { 1.0 } else { 0.0 };
        last = *value;
        *value += turns * period;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_angle_goes_on_through_both_ends_and_through_gaps() {
        let mut values = [350.0, 355.0, f64::NAN, 5.0, 10.0, 350.0, 175.0];
        let found = unwrap(&mut values, 360.0);
        let bits: Vec<f64> = values.iter().copied().filter(|value| !value.is_nan()).collect();
        assert_eq!(bits, [350.0, 355.0, 365.0, 370.0, 350.0, 175.0]);
        assert_eq!((found.times, found.longest), (2, 175.0 / 360.0));
    }

    #[test]
    fn a_counter_of_two_bytes_goes_on() {
        let truth: Vec<f64> = (0..400).map(|k| f64::from(k * 1000 - 3)).collect();
        let mut values: Vec<f64> = truth.iter().map(|value| value.rem_euclid(65536.0)).collect();
        let first = values[0];
        let found = unwrap(&mut values, 65536.0);
        assert!(
            values.iter().zip(&truth).all(|(own, truth)| own - first == truth - truth.min(-3.0))
        );
        assert_eq!(found.times, 7);
    }

    #[test]
    fn a_clock_of_two_bytes_runs_forward_through_its_end() {
        let mut values = [0.0, 65000.0, 100.0, 100.0, 50.0];
        forward(&mut values, 65536.0);
        assert_eq!(values, [0.0, 65000.0, 65636.0, 65636.0, 131_122.0]);
    }

    #[test]
    fn an_angle_that_does_not_wrap_stays_the_same_to_the_bit() {
        let truth: Vec<f64> = (0..300).map(|k| 0.1 * f64::from(k)).collect();
        let mut values = truth.clone();
        assert_eq!(unwrap(&mut values, std::f64::consts::TAU).times, 0);
        assert_eq!(values, truth);
    }
}
