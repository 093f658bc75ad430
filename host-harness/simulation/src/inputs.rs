//! From what a log holds to what drives a model.

use std::ops::Range;

use joint_core::joint::Drive;

use crate::grid::GAP;
use crate::log::Log;
use crate::plant::Inputs;

/// Where the input of a log is missing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Missing {
    /// Single samples, filled with the value before.
    pub held: usize,
    /// Stretches of more than twenty samples: the drive has let go.
    pub free: Vec<Range<usize>>,
}

impl Missing {
    /// What is done about it, a sentence each.
    pub fn told(&self, time_s: &[f64]) -> Vec<String> {
        let mut all = Vec::new();
        if self.held > 0 {
            all.push(format!("{} samples without an input hold the value before", self.held));
        }
        if let Some(first) = self.free.first() {
            let last = |range: &Range<usize>| time_s[range.end.min(time_s.len() - 1)];
            let long: f64 = self.free.iter().map(|range| last(range) - time_s[range.start]).sum();
            all.push(format!(
                "no input for {long:.3} s in {} stretches, first from t_s = {}: the winding is open and the \
                 joint swings freely there",
                self.free.len(),
                time_s[first.start]
            ));
        }
        all
    }
}

impl Inputs {
    /// The voltage where the log has one, else the current, and the known load; a missing value
    /// holds the last one, and is zero before the first.
    pub fn from_log(log: &Log) -> Self {
        let (drive, values) = match (&log.voltage_v, &log.current_a) {
            (Some(voltage), _) => (Drive::Voltage, Some(voltage)),
            (None, current) => (Drive::Current, current.as_ref()),
        };
        let samples = log.len();
        Self {
            time_s: log.time_s.clone(),
            drive,
            drive_values: held(values, samples),
            load_nm: held(log.load_torque_nm.as_ref(), samples),
        }
    }
}

impl Inputs {
    /// The same, but where the input is missing for more than twenty samples the drive has let go, which is
    /// no value ([`Inputs::drive_values`]).
    pub fn swinging(log: &Log) -> (Self, Missing) {
        let mut inputs = Self::from_log(log);
        let own = log.voltage_v.as_ref().or(log.current_a.as_ref());
        let mut missing = Missing::default();
        let mut begun = None;
        for k in 0..=log.len() {
            let absent =
                own.is_some_and(|values| values.get(k).is_some_and(|value| value.is_nan()));
            if absent {
                begun.get_or_insert(k);
            } else if let Some(start) = begun.take() {
                let stretch: Range<usize> = start..k;
                if stretch.len() > GAP as usize {
                    inputs.drive_values[stretch.clone()].fill(f64::NAN);
                    missing.free.push(stretch);
                } else {
                    missing.held += stretch.len();
                }
            }
        }
        (inputs, missing)
    }
}

fn held(values: Option<&Vec<f64>>, samples: usize) -> Vec<f64> {
    let Some(values) = values else { return vec![0.0; samples] };
    let mut last = 0.0;
    values
        .iter()
        .map(|value| {
            if !value.is_nan() {
                last = *value;
            }
            last
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_input_holds_the_last_value_and_starts_at_zero() {
        let log = Log {
            time_s: vec![0.0, 1.0, 2.0, 3.0],
            voltage_v: Some(vec![f64::NAN, 2.0, f64::NAN, 3.0]),
            current_a: Some(vec![9.0; 4]),
            motor_angle_rad: vec![0.0; 4],
            ..Log::default()
        };
        let inputs = Inputs::from_log(&log);
        assert_eq!(inputs.drive, Drive::Voltage);
        assert_eq!(inputs.drive_values, [0.0, 2.0, 2.0, 3.0]);
        assert_eq!(inputs.load_nm, [0.0; 4]);
    }

    #[test]
    fn a_long_stretch_without_an_input_is_free_and_a_short_one_is_held() {
        let mut voltage = vec![2.0; 100];
        voltage[10..12].fill(f64::NAN);
        voltage[50..80].fill(f64::NAN);
        let log = Log {
            time_s: (0..100).map(f64::from).collect(),
            voltage_v: Some(voltage),
            motor_angle_rad: vec![0.0; 100],
            ..Log::default()
        };
        let (inputs, missing) = Inputs::swinging(&log);
        assert_eq!(
            (missing.held, missing.free.as_slice()),
            (2, [Range { start: 50, end: 80 }].as_slice())
        );
        assert_eq!(inputs.drive_values[11], 2.0);
        assert!(
            (50..80).all(|k| inputs.drive_values[k].is_nan()) && inputs.drive_values[80] == 2.0
        );
        assert!(missing.told(&log.time_s)[1].starts_with("no input for 30.000 s in 1 stretches"));
    }

    #[test]
    fn without_a_voltage_the_current_is_the_input() {
        let log = Log {
            time_s: vec![0.0, 1.0],
            current_a: Some(vec![1.0, f64::NAN]),
            motor_angle_rad: vec![0.0; 2],
            ..Log::default()
        };
        let inputs = Inputs::from_log(&log);
        assert_eq!((inputs.drive, inputs.drive_values), (Drive::Current, vec![1.0, 1.0]));
    }
}
