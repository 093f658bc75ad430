//! Hardening stiffness: a stage that winds up less at large torques than its spring says.

use joint_core::effect::{EffectParameters, Kind};

use super::super::hypothesis::{Free, Hypothesis};
use super::Scene;

pub(super) fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let free = scene.masses().skip(1).filter(|(_, p)| !scene.has(Kind::HardeningStiffness, *p));
    free.map(|(mass, place)| {
        let windup = scene.typical_windup(mass - 1).max(1e-12);
        let stiffness = scene.model.stages[mass - 1].stiffness_nm_per_rad;
        let scale = 0.05 * stiffness / (windup * windup);
        Hypothesis {
            start: EffectParameters::new(Kind::HardeningStiffness, place),
            free: vec![Free::Value { value: 0, scale, sigma: 200.0 }],
        }
    })
    .collect()
}
