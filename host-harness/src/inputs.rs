//! From what a log holds to what drives a model.

use joint_core::joint::Drive;

use crate::log::Log;
use crate::plant::Inputs;

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
