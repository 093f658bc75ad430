//! The parameter block that a drive's flash page holds.

use std::f64::consts::TAU;

use firmware::block::{BlockError, PAGE_BYTES, encode};
use firmware::parameters::{DriveJoint, Parameters, Sensing};
use firmware::{admissible, session};
use joint_core::observer::{Design, Gains, Observer};
use joint_core::params::Stage;

use super::{DriveOptions, ExportError};
use crate::model::Model;
use crate::observe::design::{Tuning, design};
use crate::observe::rating::Rating;
use crate::observe::run::settings;

/// The block's bytes.
///
/// # Errors
/// The joint cannot run in the firmware with these options.
pub fn block(model: &Model, options: &DriveOptions) -> Result<Vec<u8>, ExportError> {
    match model.stages.len() {
        0 => encoded::<0>(model, options),
        1 => encoded::<1>(model, options),
        2 => encoded::<2>(model, options),
        3 => encoded::<3>(model, options),
        more => Err(ExportError::Stages(more)),
    }
}

fn encoded<const N: usize>(model: &Model, options: &DriveOptions) -> Result<Vec<u8>, ExportError> {
    let stages: &[Stage; N] =
        model.stages.as_slice().try_into().map_err(|_| ExportError::Stages(N))?;
    let settings = settings(model, options.drive, options.period_s);
    let design = designed::<N>(model, options)?;
    let joint = DriveJoint::<N>::new(&model.motor, stages, &model.load, &settings)
        .map_err(|error| ExportError::Parameter(error.to_string()))?;
    let gains = Gains::new(&design, &model.motor, stages, options.drive, options.period_s);
    let parameters =
        Parameters { observer: Observer { joint, gains }, sensing: sensing(model, options) };
    admissible::check(&parameters).map_err(ExportError::Inadmissible)?;
    let mut bytes = vec![0; PAGE_BYTES];
    let length = encode(&parameters, N as u8, &mut bytes).map_err(|_| ExportError::Room)?;
    bytes.truncate(length);
    Ok(bytes)
}

/// The observer's design for a drive with these options.
pub(super) fn designed<const N: usize>(
    model: &Model,
    options: &DriveOptions,
) -> Result<Design<N>, ExportError> {
    let mut rating = Rating::of(model, options.drive);
    rating.current_a = options.current_limit_a;
    let mut model = model.clone();
    model.sensor.motor_encoder_counts_per_rev =
        f64::from(sensing(&model, options).motor_counts_per_turn);
    design(&model, options.drive, options.period_s, &rating, &Tuning::default())
        .map_err(|error| ExportError::Parameter(error.to_string()))
}

/// What the drive must know of its sensors. An unknown encoder gets the firmware's default.
pub(super) fn sensing(model: &Model, options: &DriveOptions) -> Sensing {
    let default = Sensing::default();
    let counts = |per_turn: f64, default: u32| {
        if per_turn >= 1.0 { per_turn.round() as u32 } else { default }
    };
    let motor_counts =
        counts(model.sensor.motor_encoder_counts_per_rev, default.motor_counts_per_turn);
    // Twice the idle speed, and at least two counts for the encoder's own noise.
    let constant = model.motor.torque_constant_nm_per_a;
    let fastest_rad_per_s = 2.0 * options.bus_v / constant;
    let moved = fastest_rad_per_s * options.period_s / TAU * f64::from(motor_counts);
    Sensing {
        sample_time_s: options.period_s as f32,
        motor_counts_per_turn: motor_counts,
        output_counts_per_turn: counts(model.sensor.output_encoder_counts_per_rev, 0),
        pole_pairs: model.motor.pole_pairs,
        largest_voltage_v: (1.25 * options.bus_v) as f32,
        largest_current_a: options.current_limit_a as f32,
        largest_move_counts: (moved.ceil() + 2.0).min(1e7) as u32,
    }
}

/// Whether the firmware accepts the block, by the firmware's own code.
///
/// # Errors
/// What it would refuse it with.
pub fn accepted(bytes: &[u8]) -> Result<(), BlockError> {
    session::Session::new().start(bytes)?.map_or(Ok(()), Err)
}
