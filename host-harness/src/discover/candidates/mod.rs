//! How each effect is spotted: its start values, scales and bounds, one file per effect.
//!
//! A candidate proposes hypotheses; whether one holds is decided elsewhere and the same way for
//! all. To add one: a file beside these and a row in [`ALL`].

mod asymmetric_friction;
mod backlash;
mod coating;
pub(super) mod cogging;
mod current_gain;
mod current_offset;
mod dead_time;
pub(super) mod encoder_eccentricity;
pub(super) mod gravity;
mod hardening_stiffness;
mod load_dependent_friction;
mod lubricant_warming;
mod position_dependent_friction;
mod quadratic_drag;
mod scene;
mod sensor_delay;
mod structural_hysteresis;
mod supply_sag;
mod torque_ripple;
mod torque_saturation;
mod transmission_error;
mod winding_heating;

pub(super) use cogging::listed;
pub use scene::Scene;

use joint_core::effect::Kind;
use rayon::prelude::*;

use super::hypothesis::Hypothesis;

/// Proposes hypotheses for one kind of effect.
pub type Candidate = fn(&Scene<'_>) -> Vec<Hypothesis>;

/// Every candidate.
pub const ALL: &[Candidate] = &[
    asymmetric_friction::propose,
    backlash::propose,
    coating::propose,
    cogging::propose,
    current_gain::propose,
    current_offset::propose,
    dead_time::propose,
    encoder_eccentricity::propose,
    gravity::propose,
    hardening_stiffness::propose,
    load_dependent_friction::propose,
    lubricant_warming::propose,
    position_dependent_friction::propose,
    quadratic_drag::propose,
    sensor_delay::propose,
    structural_hysteresis::propose,
    supply_sag::propose,
    torque_ripple::propose,
    torque_saturation::propose,
    transmission_error::propose,
    winding_heating::propose,
];

/// What all candidates propose, but for kinds that are withdrawn.
pub fn proposed(scene: &Scene<'_>, withdrawn: &[Kind]) -> Vec<Hypothesis> {
    let all = ALL.par_iter().flat_map_iter(|candidate| candidate(scene));
    all.filter(|hypothesis| !withdrawn.contains(&hypothesis.start.kind)).collect()
}
