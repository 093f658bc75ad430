//! Current limit: a voltage lost where voltage and back-EMF ask for more current than is seen to flow.
//! Where the current itself is the input, what is measured has been limited already.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::joint::Drive;
use joint_core::params::Location;

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;

/// Limits that are tried, in currents that hardly any sample exceeds.
const LIMITS: [f64; 3] = [1.1, 1.6, 3.0];
/// Share of the samples that exceed such a current: a limit is where many stop.
const BEYOND: f64 = 0.02;

pub(super) const CARD: EffectCard = EffectCard {
    words: "a drive that takes voltage off where the current would grow too large",
    residual: Residual::Voltage,
    axis: Axis::Current,
    experiment: "hold the rotor and raise the voltage step by step: the current stops following it at \
         the limit, in both directions and at any temperature",
    reference: None,
    rules: Rules::NONE,
    benchmark: Benchmark::Wide(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    if scene.record.drive == Drive::Current || scene.has(Kind::CurrentLimit, Location::Inverter) {
        return Vec::new();
    }
    let mut flowing: Vec<f64> = scene.current().iter().map(|i| i.abs()).collect();
    if flowing.is_empty() {
        return Vec::new();
    }
    let place = ((1.0 - BEYOND) * (flowing.len() - 1) as f64) as usize;
    let shown = flowing.select_nth_unstable_by(place, f64::total_cmp).1.max(1e-9);
    LIMITS
        .map(|limit| Hypothesis {
            start: EffectParameters::new(Kind::CurrentLimit, Location::Inverter)
                .with("limit_a", limit * shown),
            free: vec![Free::Value { value: 0, scale: 0.1 * limit * shown, sigma: 20.0 }],
        })
        .to_vec()
}

/// Half of what the voltage drives through the winding at rest.
fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let limit = 0.5 * joint.current_a() / joint.size;
    Some(EffectParameters::new(Kind::CurrentLimit, Location::Inverter).with("limit_a", limit))
}
