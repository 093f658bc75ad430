//! A winding that heats: its resistance follows the square of the current, late. The reference is
//! the record's own mean-square current, so that the rise is what the record tends to.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::joint::Drive;
use joint_core::params::Location;

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::channels::{currents, digit, span};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;
use crate::discover::bounds::TEMPERATURE_SHARE;
use crate::estimate::record::Record;
use crate::model::Model;

/// Rise of copper's resistance per kelvin.
const COPPER: f64 = 3.93e-3;
/// Time constants that are tried, as shares of the record.
const LAGS: [f64; 3] = [0.1, 0.35, 1.5];

pub(super) const CARD: EffectCard = EffectCard {
    words: "a winding whose resistance rises as it warms",
    residual: Residual::Voltage,
    axis: Axis::Time,
    experiment: "hold the rotor at a constant current until the voltage no longer rises, let it cool, and \
         repeat: a winding follows the square of the current late, a supply at once",
    reference: Some("reference_current_a"),
    rules: Rules { contradiction, ..Rules::NONE },
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
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

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let heating = EffectParameters::new(Kind::WindingHeating, Location::Motor)
        .with("relative_rise", 0.2 * joint.size)
        .with("time_constant_s", 0.3 * joint.duration_s)
        .with("reference_current_a", 0.3 * joint.current_a());
    Some(heating)
}

/// A heating that a thermometer in the housing does not show.
fn contradiction(effect: &EffectParameters, model: &Model, record: &Record) -> Option<String> {
    let temperature = record.temperature_c.as_deref()?;
    let reference = effect.values[2];
    let squares: Vec<f64> =
        currents(model, record).map(|current| (current / reference).powi(2)).collect();
    let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    let duration = record.time_s.last()? - record.time_s.first()?;
    let reached = 1.0 - (-duration / effect.values[1].max(1e-9)).exp();
    let predicted = effect.values[0] * mean * reached / COPPER;
    let shown = span(temperature)? + digit(temperature);
    (shown < TEMPERATURE_SHARE * predicted).then(|| {
        format!(
            "a heating winding would rise by {predicted:.0} K; temperature_c moves by {shown:.1} K"
        )
    })
}
