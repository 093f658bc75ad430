//! Structural hysteresis: a stage whose wind-up loops, at any frequency. Its width is tried at
//! several shares of the wind-up.

use joint_core::effect::{EffectParameters, Kind};

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;

/// Widths tried, in typical wind-ups.
const WIDTHS: [f64; 4] = [0.1, 0.4, 1.5, 5.0];

pub(super) const CARD: EffectCard = EffectCard {
    words: "a stage whose wind-up loops, however slowly it is loaded",
    residual: Residual::Windup,
    axis: Axis::OutputWindup,
    experiment: "swing the torque against a locked output at several amplitudes and several frequencies: \
         this loop's area grows with the amplitude and keeps at every frequency, that of viscous \
         damping grows with it",
    reference: None,
    rules: Rules::NONE,
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
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

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let hysteresis = EffectParameters::new(Kind::StructuralHysteresis, joint.gear()?)
        .with("amplitude_nm", 0.5 * joint.size * joint.output_torque_nm)
        .with("width_rad", joint.windup_rad());
    Some(hysteresis)
}
