//! Even samples of a log that has uneven ones, where that is asked for.
//!
//! The fits take uneven sampling as it is, so nothing is resampled unasked. Measurements are
//! interpolated linearly and voltages hold, as they did on the machine; there is no filter, so a
//! rate below the recording's folds faster motion into slower.

use super::signal::Signal;

/// Times from the first to the last at a rate, both ends within.
pub(super) fn grid(time_s: &[f64], rate_hz: f64) -> Vec<f64> {
    let (Some(first), Some(last)) = (time_s.first(), time_s.last()) else { return Vec::new() };
    // The last one counts where rounding alone puts it past the end.
    let steps = ((last - first) * rate_hz * (1.0 + 1e-12)).floor() as u64;
    (0..=steps).map(|k| first + k as f64 / rate_hz).collect()
}

/// A signal at other times; missing where a neighbour that it needs is.
pub(super) fn at(times: &[f64], time_s: &[f64], values: &[f64], signal: Signal) -> Vec<f64> {
    let value = |time: f64| {
        let after = time_s.partition_point(|own| *own <= time);
        let before = after.saturating_sub(1);
        match (values.get(before), values.get(after)) {
            (Some(value), _) if time_s[before] == time || signal.is_held() => *value,
            (Some(value), Some(next)) => {
                let share = (time - time_s[before]) / (time_s[after] - time_s[before]);
                value + share * (next - value)
            }
            // Past the end by rounding.
            (Some(value), None) => *value,
            (None, _) => f64::NAN,
        }
    };
    times.iter().map(|time| value(*time)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_stays_one_and_a_voltage_holds() {
        let time = [0.0, 0.1, 0.25, 0.5];
        let even = grid(&time, 20.0);
        assert_eq!((even.len(), even[1], even[10]), (11, 0.05, 0.5));
        let line: Vec<f64> = time.iter().map(|t| 2.0 * t + 1.0).collect();
        for (t, value) in even.iter().zip(at(&even, &time, &line, Signal::Motor)) {
            // Three roundings of a number below 2.
            assert!((value - (2.0 * t + 1.0)).abs() < 1e-15, "{t}: {value}");
        }
        let held = at(&even, &time, &[1.0, 2.0, 3.0, 4.0], Signal::Voltage);
        assert_eq!(held, [1.0, 1.0, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0, 3.0, 3.0, 4.0]);
    }

    #[test]
    fn a_sample_on_the_grid_is_taken_as_it_is_and_a_gap_stays_one() {
        let time = [0.0, 0.1, 0.2, 0.3];
        let values = at(&time, &time, &[1.0, f64::NAN, 3.0, 4.0], Signal::Output);
        assert!(values[1].is_nan());
        assert_eq!([values[0], values[2], values[3]], [1.0, 3.0, 4.0]);
    }
}
