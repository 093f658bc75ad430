//! A winding that heats: its resistance follows the square of the current, late. The reference is
//! the record's own mean-square current, so that the rise is what the record tends to.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::joint::Drive;
use joint_core::params::Location;

use super::super::hypothesis::{Free, Hypothesis};
use super::Scene;

/// Time constants that are tried, as shares of the record.
const LAGS: [f64; 3] = [0.1, 0.35, 1.5];

pub(super) fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    if scene.record.drive == Drive::Current || scene.has(Kind::WindingHeating, Location::Motor) {
        return Vec::new();
    }
    let current = scene.typical_current().max(1e-9);
    LAGS.map(|share| share * scene.duration())
        .map(|lag| Hypothesis {
            start: EffectParameters::new(Kind::WindingHeating, Location::Motor)
                .with("time_constant_s", lag)
                .with("reference_current_a", current),
            free: vec![
                Free::Value { value: 0, scale: 0.02, sigma: 30.0 },
                Free::Value { value: 1, scale: 0.2 * lag, sigma: 10.0 },
            ],
        })
        .to_vec()
}
