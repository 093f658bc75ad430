//! A control period of the assumed joint: what the emulated drive needs to count it.

use std::f64::consts::TAU;

use joint_core::joint::Drive;
use joint_core::telemetry::Sample;

use crate::export::DriveOptions;
use crate::export::block::block;
use crate::plant::{self, Inputs, ScalarKind};
use crate::scenario;
use crate::verb::Failure;

/// Control periods that are counted, of which the most costly stands in the table.
const SAMPLES: usize = 4_000;
pub(super) const PERIOD_S: f64 = 50e-6;
const BUS_V: f64 = 12.0;
/// Instructions a second of the STM32G431, were each one cycle.
const CLOCK_HZ: f64 = 170e6;

/// The drive's parameters, as a block.
pub(super) fn parameters() -> Result<Vec<u8>, Failure> {
    let options = DriveOptions {
        period_s: PERIOD_S,
        drive: Drive::Voltage,
        bus_v: BUS_V,
        current_limit_a: 5.0,
    };
    block(&scenario::paper(), &options).map_err(|error| Failure::check(error.to_string()))
}

/// What its sensors show: reversals, standstill, a load that comes and goes.
pub(super) fn samples() -> Result<Vec<u8>, Failure> {
    let model = scenario::paper();
    let voltage = |k: usize| [3.0, -4.5, 0.0, 0.4, 6.0][k / 400 % 5];
    let inputs = Inputs {
        time_s: (0..SAMPLES).map(|k| k as f64 * PERIOD_S).collect(),
        drive: Drive::Voltage,
        drive_values: (0..SAMPLES).map(voltage).collect(),
        load_nm: (0..SAMPLES).map(|k| if k / 1_000 % 2 == 1 { 0.004 } else { 0.0 }).collect(),
    };
    let states = plant::simulate(&model, &inputs, ScalarKind::F64, None, None)
        .map_err(|error| Failure::check(error.to_string()))?;
    let counts = |angle_rad: f64, per_turn: f64| (angle_rad / TAU * per_turn).floor() as i32;
    let sensor = &model.sensor;
    let per_turn = |counts: f64| if counts >= 1.0 { counts } else { 4096.0 };
    let samples = states.iter().enumerate().map(|(k, state)| Sample {
        voltage_v: voltage(k) as f32,
        current_a: state.measured_current_a as f32,
        motor_counts: counts(state.motor_angle_rad, per_turn(sensor.motor_encoder_counts_per_rev)),
        output_counts: state
            .stages
            .last()
            .map_or(0, |stage| counts(stage.angle_rad, sensor.output_encoder_counts_per_rev)),
    });
    Ok(samples.flat_map(|sample| sample.to_bytes()).collect())
}

/// Share of a control period at 170 MHz, a cycle an instruction.
pub(super) fn share(instructions: u64, period_s: f64) -> f64 {
    instructions as f64 / (CLOCK_HZ * period_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_control_period_has_8500_cycles() {
        assert!((share(8_500, PERIOD_S) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn every_period_has_a_sample_and_the_joint_moves() {
        let bytes = samples().unwrap();
        assert_eq!(bytes.len(), SAMPLES * 16);
        let counts =
            |k: usize| Sample::from_bytes(bytes[16 * k..][..16].try_into().unwrap()).motor_counts;
        assert!((0..SAMPLES).map(counts).any(|own| own > 1_000));
    }
}
