//! Effects to hide: of every kind, at a place and of a size that a user of the joint would care
//! about.
//!
//! Sizes follow from the joint itself: its breakaway torque, the wind-up under it, the voltage that
//! excites it. How, each effect's card says.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::per_unit::Bases;
use rand::{Rng, RngExt};

use super::{Bench, Benchmark, card};
use crate::model::Model;
use crate::synthetic::{amplitude_v, breakaway_nm};

/// Kinds that can be hidden.
pub fn kinds() -> impl Iterator<Item = Kind> {
    let hidden = |kind: &Kind| matches!(card(*kind).benchmark, Benchmark::Hidden(_));
    Kind::ALL.iter().copied().filter(hidden)
}

/// The kinds that wide draws hide besides.
pub fn kinds_of_wide_draws() -> impl Iterator<Item = Kind> {
    let wide = |kind: &Kind| matches!(card(*kind).benchmark, Benchmark::Wide(_));
    Kind::ALL.iter().copied().filter(wide)
}

/// An effect of this kind, `size` times what is typical, for a log of `duration_s`; `None` where the
/// joint has no place for it, or the kind is not hidden.
pub fn hidden(
    kind: Kind,
    model: &Model,
    size: f64,
    duration_s: f64,
    random: &mut impl Rng,
) -> Option<EffectParameters> {
    let stages = model.stages.len();
    let bases = Bases::si(&model.motor, &model.stages);
    let motor_torque_nm = breakaway_nm(model);
    let voltage_v = amplitude_v(model);
    let phase_rad = random.random_range(-3.0..3.0);
    let sign = if random.random::<bool>() { 1.0 } else { -1.0 };
    let mut joint = Bench {
        stages,
        duration_s,
        size,
        phase_rad,
        sign,
        motor_torque_nm,
        output_torque_nm: motor_torque_nm / bases.shaft(stages).abs(),
        stiffness_nm_per_rad: model.stages.last().map_or(f64::INFINITY, |s| s.stiffness_nm_per_rad),
        voltage_v,
        resistance_ohm: bases.resistance,
        speed_rad_per_s: voltage_v / model.motor.torque_constant_nm_per_a,
        pole_pairs: f64::from(model.motor.pole_pairs.max(1)),
        current_noise_a: model.sensor.current_noise_a,
        sample_time_s: model.sensor.sample_time_s,
        random,
    };
    match card(kind).benchmark {
        Benchmark::Hidden(of) | Benchmark::Wide(of) => of(&mut joint),
        Benchmark::Left(_) => None,
    }
}
