//! Whether a log can tell anything at all.
//!
//! A joint that stands still fits every model of it. That is no adequate model but a log without an
//! answer, and the reader should hear what it lacks.

use crate::discover::bounds::COUNTS;
use crate::estimate::record::{Channel, Record};

/// What a record lacks to tell anything, a sentence each; nothing where it can.
pub(crate) fn cannot_tell(record: &Record) -> Vec<String> {
    let angles: Vec<f64> = record
        .measured
        .iter()
        .map(|row| row[Channel::Motor as usize])
        .filter(|angle| angle.is_finite())
        .collect();
    let [low, high] = ends(&angles);
    let steps = angles.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let count = steps.filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
    if high <= low {
        return vec![
            "motor_angle_rad never changes: a joint at rest fits every model of it; drive it \
             through reversals, at several speeds"
                .to_owned(),
        ];
    }
    if high - low < COUNTS * count {
        return vec![format!(
            "motor_angle_rad moves by {:.0} of its counts in all: that is its rounding, not a \
             motion; drive the joint through reversals, at several speeds",
            (high - low) / count
        )];
    }
    Vec::new()
}

fn ends(values: &[f64]) -> [f64; 2] {
    let all = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = values.iter().fold(all, |(low, high), x| (low.min(*x), high.max(*x)));
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Log;

    fn record(angle: impl Fn(usize) -> f64) -> Record {
        let log = Log {
            time_s: (0..500).map(|k| k as f64 * 1e-3).collect(),
            voltage_v: Some(vec![1.0; 500]),
            motor_angle_rad: (0..500).map(angle).collect(),
            ..Log::default()
        };
        Record::new(&log, None)
    }

    #[test]
    fn rest_and_rounding_tell_nothing_and_a_motion_does() {
        assert!(cannot_tell(&record(|_| 0.3))[0].contains("never changes"));
        assert!(cannot_tell(&record(|k| 1e-3 * (k / 7 % 2) as f64))[0].contains("1 of its counts"));
        assert!(cannot_tell(&record(|k| 1e-3 * k as f64)).is_empty());
        // Wherever the encoder was zeroed; six counts are a motion.
        let swings = |counts: usize| move |k: usize| 5.0 + 0.125 * (k % (counts + 1)) as f64;
        assert!(cannot_tell(&record(swings(5)))[0].contains("5 of its counts"));
        assert!(cannot_tell(&record(swings(6))).is_empty());
    }
}
