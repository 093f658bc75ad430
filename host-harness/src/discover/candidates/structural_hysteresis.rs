//! Structural hysteresis: a stage whose wind-up loops, at any frequency. Its width is tried at
//! several shares of the wind-up.

use joint_core::effect::{EffectParameters, Kind};

use super::super::hypothesis::{Free, Hypothesis};
use super::Scene;

/// Widths tried, in typical wind-ups.
const WIDTHS: [f64; 4] = [0.1, 0.4, 1.5, 5.0];

pub(super) fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    for (mass, place) in scene.masses().skip(1) {
        if scene.has(Kind::StructuralHysteresis, place) {
            continue;
        }
        let windup = scene.typical_windup(mass - 1).max(1e-9);
        let scale = 0.1 * scene.torque_scale() / scene.shaft(mass).abs();
        all.extend(WIDTHS.map(|width| width * windup).map(|width| Hypothesis {
            start:
                EffectParameters::new(Kind::StructuralHysteresis, place).with("width_rad", width),
            free: vec![
                Free::Value { value: 0, scale, sigma: 100.0 },
                Free::Value { value: 1, scale: 0.2 * width, sigma: 10.0 },
            ],
        }));
    }
    all
}
