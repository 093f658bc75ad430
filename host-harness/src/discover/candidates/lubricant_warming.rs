//! Lubricant that warms: viscous friction that falls after fast motion, and comes back. The
//! reference is the record's own mean-square speed.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;

/// Time constants that are tried, as shares of the record.
const LAGS: [f64; 3] = [0.1, 0.35, 1.5];

pub(super) const CARD: EffectCard = EffectCard {
    words: "viscous friction that falls as the lubricant warms",
    residual: Residual::Torque,
    axis: Axis::Time,
    experiment: "run at one constant speed until the current no longer falls, let the joint cool, and \
         repeat: a lubricant starts high again, drag with speed does not",
    reference: Some("reference_speed_rad_per_s"),
    rules: Rules::NONE,
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    for (mass, place) in scene.masses() {
        if scene.friction(mass).sigma2_nm_s_per_rad <= 0.0
            || scene.has(Kind::LubricantWarming, place)
        {
            continue;
        }
        let speed = scene.typical_speed(mass).max(1e-9);
        all.extend(LAGS.map(|share| share * scene.duration()).map(|lag| {
            Hypothesis {
                start: EffectParameters::new(Kind::LubricantWarming, place)
                    .with("time_constant_s", lag)
                    .with("reference_speed_rad_per_s", speed),
                free: vec![
                    Free::Value { value: 0, scale: 0.05, sigma: 20.0 },
                    Free::Value { value: 1, scale: 0.2 * lag, sigma: 10.0 },
                ],
            }
        }));
    }
    all
}

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let warming = EffectParameters::new(Kind::LubricantWarming, Location::Motor)
        .with("relative_fall", 0.5 * joint.size)
        .with("time_constant_s", 0.3 * joint.duration_s)
        .with("reference_speed_rad_per_s", 0.3 * joint.speed_rad_per_s);
    Some(warming)
}
