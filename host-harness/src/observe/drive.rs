//! The drive's own control period over a log: parameters from its block, angles as counts.
//!
//! What the chip will say can then be known before it is flashed, bit for bit: this is the code that
//! runs in its control interrupt, and the log's values are what its converter and timers would show.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use firmware::any_control::AnyControl;
use firmware::block::{Block, BlockError};
use firmware::parameters::Sensing;
use joint_core::observer;
use joint_core::telemetry::{MAX_STAGES, Quantities, Report, Sample, Status};

use crate::log::Log;

/// Why a block does not go with a log.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DriveError {
    /// The chip would refuse the block.
    #[error("{0}")]
    Block(#[from] BlockError),
    /// The log was sampled at another period than the block is for.
    #[error(
        "the log has a sample every {log_us} µs, the block is for {block_us} µs: export it with --period-us {log_us}"
    )]
    Period {
        /// Of the log, µs.
        log_us: f64,
        /// Of the block, µs.
        block_us: f64,
    },
    /// A sample stands a fraction of a period, or many periods, after the one before.
    #[error("sample {0} does not stand one control period after the one before it")]
    Gap(usize),
}

/// A drive with the block's parameters.
///
/// # Errors
/// The block is refused.
pub fn control(block: &[u8]) -> Result<AnyControl, DriveError> {
    let mut control = AnyControl::NotStarted;
    control.read(&Block::check(block)?, Status::default())?;
    Ok(control)
}

/// What the drive's sensors would show. An angle that is missing is the one before it; a missing
/// voltage or current is no number, as from a converter that has failed.
///
/// # Errors
/// The log is not sampled once a control period.
pub fn samples(log: &Log, sensing: &Sensing) -> Result<Vec<Sample>, DriveError> {
    evenly(&log.time_s, f64::from(sensing.sample_time_s))?;
    let at = |column: &Option<Vec<f64>>, k: usize, missing: f64| {
        column.as_ref().and_then(|values| values.get(k)).copied().unwrap_or(missing)
    };
    let counts = |angle_rad: f64, per_turn: u32, last: i32| match angle_rad.is_finite() {
        true => (angle_rad / TAU * f64::from(per_turn)).round() as i32,
        false => last,
    };
    let mut last = Sample::default();
    let rows = log.motor_angle_rad.iter().enumerate().map(|(k, motor)| {
        last = Sample {
            voltage_v: at(&log.voltage_v, k, f64::NAN) as f32,
            current_a: at(&log.current_a, k, f64::NAN) as f32,
            motor_counts: counts(*motor, sensing.motor_counts_per_turn, last.motor_counts),
            output_counts: counts(
                at(&log.output_angle_rad, k, 0.0),
                sensing.output_counts_per_turn,
                last.output_counts,
            ),
        };
        last
    });
    Ok(rows.collect())
}

fn evenly(time_s: &[f64], period_s: f64) -> Result<(), DriveError> {
    let Some(mean) = time_s.last().zip(time_s.first()).map(|(last, first)| last - first) else {
        return Ok(());
    };
    let own = mean / (time_s.len().max(2) - 1) as f64;
    if (own / period_s - 1.0).abs() > 0.02 {
        let us = |seconds: f64| (seconds * 1e9).round() / 1e3;
        return Err(DriveError::Period { log_us: us(own), block_us: us(period_s) });
    }
    let late = |pair: &[f64]| (pair[1] - pair[0] - period_s).abs() > 0.5 * period_s;
    match time_s.windows(2).position(late) {
        Some(k) => Err(DriveError::Gap(k + 1)),
        None => Ok(()),
    }
}

/// The reports as a file: the columns that a drive knows, under their names.
pub fn table(time_s: &[f64], reports: &[Report]) -> String {
    let stages = reports.first().map_or(0, |report| usize::from(report.stages).min(MAX_STAGES));
    let mut text = String::from("t_s");
    for end in ["", "_std"] {
        let _ = write!(text, ",motor_velocity_rad_per_s{end},total_friction_at_motor_nm{end}");
        for stage in 1..=stages {
            let _ = write!(text, ",stage{stage}_windup_rad{end}");
        }
        let _ = write!(
            text,
            ",output_angle_rad{end},output_velocity_rad_per_s{end},load_torque_nm{end}"
        );
    }
    text.push_str(",status\n");
    for (time, report) in time_s.iter().zip(reports) {
        let _ = write!(text, "{time}");
        for own in [&report.estimates, &report.deviations] {
            row(&mut text, own, stages);
        }
        let _ = writeln!(text, ",{}", status(report));
    }
    text
}

fn row(text: &mut String, own: &Quantities, stages: usize) {
    let first = [own.motor_velocity_rad_per_s, own.total_friction_at_motor_nm];
    let last = [own.output_angle_rad, own.output_velocity_rad_per_s, own.load_torque_nm];
    for value in first.iter().chain(own.windup_rad.iter().take(stages)).chain(&last) {
        let _ = write!(text, ",{value:.9e}");
    }
}

/// The observer's flags, and the drive's own beside them.
fn status(report: &Report) -> String {
    let health =
        observer::Status::NAMES.iter().filter(|(flag, _)| report.health & flag.bits() != 0);
    let own = Status::NAMES.iter().filter(|(flag, _)| report.status.meets(*flag));
    let names: Vec<&str> =
        health.map(|(_, name)| *name).chain(own.map(|(_, name)| *name)).collect();
    if names.is_empty() { "ok".to_owned() } else { names.join("+") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_of_another_period_or_with_a_gap_is_refused() {
        let evenly_at = |times: &[f64]| evenly(times, 1e-4);
        assert_eq!(evenly_at(&[0.0, 1e-4, 2e-4]), Ok(()));
        let other = evenly_at(&[0.0, 2e-4, 4e-4]).unwrap_err();
        assert_eq!(other, DriveError::Period { log_us: 200.0, block_us: 100.0 });
        assert!(other.to_string().contains("--period-us 200"), "{other}");
        let mut times: Vec<f64> = (0..500).map(|k| f64::from(k) * 1e-4).collect();
        times.iter_mut().skip(40).for_each(|time| *time += 1e-4);
        assert_eq!(evenly_at(&times), Err(DriveError::Gap(40)));
    }

    #[test]
    fn counts_are_those_that_the_log_was_made_of() {
        let sensing = Sensing { output_counts_per_turn: 65_536, ..Sensing::DEFAULT };
        let counts = [0, 1, -1, 4095, 4096, 3_000_001];
        let angle = |per_turn: f64| move |count: &i32| f64::from(*count) / per_turn * TAU;
        let log = Log {
            time_s: (0..counts.len()).map(|k| k as f64 * 50e-6).collect(),
            motor_angle_rad: counts.iter().map(angle(4096.0)).collect(),
            output_angle_rad: Some(counts.iter().map(angle(65_536.0)).collect()),
            ..Log::default()
        };
        for (sample, count) in samples(&log, &sensing).unwrap().iter().zip(counts) {
            assert_eq!((sample.motor_counts, sample.output_counts), (count, count));
            assert!(sample.voltage_v.is_nan() && sample.current_a.is_nan());
        }
    }
}
