//! Effects to hide: of every kind, at a place and of a size that a user of the joint would care
//! about.
//!
//! Sizes follow from the joint itself: its breakaway torque, the wind-up under it, the voltage that
//! excites it.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;
use joint_core::per_unit::Bases;
use rand::{Rng, RngExt};

use super::{amplitude_v, breakaway_nm};
use crate::model::Model;

/// Kinds that can be hidden: all but a current gain, which is a symmetry of the model.
pub fn kinds() -> impl Iterator<Item = Kind> {
    Kind::ALL.iter().copied().filter(|kind| *kind != Kind::CurrentGain)
}

/// An effect of this kind, `size` times what is typical, for a log of `duration_s`; `None` where the
/// joint has no place for it.
pub fn hidden(
    kind: Kind,
    model: &Model,
    size: f64,
    duration_s: f64,
    random: &mut impl Rng,
) -> Option<EffectParameters> {
    let stages = model.stages.len();
    let bases = Bases::si(&model.motor, &model.stages);
    let last = u8::try_from(stages).ok()?;
    let behind = if stages == 0 { Location::Motor } else { Location::Stage(last) };
    let gear = (stages > 0).then_some(Location::Stage(last));
    let at_motor = breakaway_nm(model);
    let at_output = at_motor / bases.shaft(stages).abs();
    let stiffness = model.stages.last().map_or(f64::INFINITY, |s| s.stiffness_nm_per_rad);
    let windup = at_output / stiffness;
    let volts = amplitude_v(model);
    let amperes = volts / bases.resistance;
    let speed = volts / model.motor.torque_constant_nm_per_a;
    let phase = random.random_range(-3.0..3.0);
    let sign = if random.random::<bool>() { 1.0 } else { -1.0 };
    let share = |value: f64| (value * size).min(0.9);
    let electrical = f64::from(model.motor.pole_pairs.max(1));
    let at = |location| EffectParameters::new(kind, location);
    Some(match kind {
        Kind::AsymmetricFriction => at(Location::Motor).with("asymmetry", sign * share(0.25)),
        Kind::Backlash => at(gear?).with("width_rad", 3.0 * size * windup),
        Kind::Coating => {
            gear?;
            at(Location::Output)
                .with("stiffness_nm_per_rad", 0.6 * size * at_output)
                .with("hysteresis_nm", 0.5 * size * at_output)
        }
        Kind::Cogging => at(Location::Motor)
            .with("order", electrical * [2.0, 6.0, 12.0][random.random_range(0..3)])
            .with("amplitude_nm", 0.3 * size * at_motor)
            .with("phase_rad", phase),
        Kind::CurrentOffset => {
            at(Location::CurrentSensor).with("offset_a", sign * 0.03 * size * amperes)
        }
        Kind::DeadTime => at(Location::Inverter)
            .with("voltage_v", 0.05 * size * volts)
            .with("softening_a", 2.0 * model.sensor.current_noise_a),
        Kind::EncoderEccentricity => {
            at(Location::Encoder).with("amplitude_rad", 0.015 * size).with("phase_rad", phase)
        }
        Kind::Gravity => at(if stages == 0 { Location::Motor } else { Location::Output })
            .with("amplitude_nm", 1.5 * size * at_output)
            .with("phase_rad", phase),
        Kind::HardeningStiffness => {
            let cubic = 0.5 * size * stiffness / (2.0 * windup).powi(2);
            at(gear?).with("cubic_stiffness_nm_per_rad3", cubic)
        }
        Kind::LoadDependentFriction => at(gear?).with("coefficient", 0.1 * size),
        Kind::LubricantWarming => at(Location::Motor)
            .with("relative_fall", 0.5 * size)
            .with("time_constant_s", 0.3 * duration_s)
            .with("reference_speed_rad_per_s", 0.3 * speed),
        Kind::PositionDependentFriction => at(behind)
            .with("relative_amplitude", share(0.45))
            .with("order", [6.0, 12.0, 24.0][random.random_range(0..3)])
            .with("phase_rad", phase),
        Kind::QuadraticDrag => {
            let coefficient = 0.6 * size * at_motor / (0.5 * speed).powi(2);
            at(Location::Motor).with("coefficient_nm_s2", coefficient)
        }
        Kind::SensorDelay => {
            let samples = (3.0 * size).round().max(1.0);
            at(Location::Encoder).with("delay_s", samples * model.sensor.sample_time_s)
        }
        Kind::StructuralHysteresis => {
            at(gear?).with("amplitude_nm", 0.5 * size * at_output).with("width_rad", windup)
        }
        Kind::SupplySag => at(Location::Inverter)
            .with("bus_voltage_v", 1.3 * volts)
            .with("source_resistance_ohm", 0.2 * size * bases.resistance),
        Kind::TorqueRipple => at(Location::Motor)
            .with("relative_amplitude", share(0.05))
            .with("order", 6.0 * electrical)
            .with("phase_rad", phase),
        Kind::TorqueSaturation => at(Location::Motor).with("current_a", 2.5 * amperes / size),
        Kind::TransmissionError => at(gear?)
            .with("amplitude_rad", size * windup)
            .with("order", [1.0, 3.0, 5.0][random.random_range(0..3)])
            .with("phase_rad", phase),
        Kind::WindingHeating => at(Location::Motor)
            .with("relative_rise", 0.2 * size)
            .with("time_constant_s", 0.3 * duration_s)
            .with("reference_current_a", 0.3 * amperes),
        _ => return None,
    })
}
