//! Supply sag: a voltage lost with duty and current together. Only the source's resistance over the
//! square of the bus voltage shows; the bus is taken a fifth above the largest voltage asked for.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::joint::Drive;
use joint_core::params::Location;

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::channels::{currents, digit, followed, quantile, span};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;
use crate::discover::bounds::BUS_SHARE;
use crate::estimate::record::Record;
use crate::model::Model;

/// Bus voltage over the largest voltage in the record.
const BUS: f64 = 1.2;

pub(super) const CARD: EffectCard = EffectCard {
    words: "a bus voltage that gives way under power",
    residual: Residual::Voltage,
    axis: Axis::Current,
    experiment: "log the bus voltage while the joint accelerates hard at high speed, and again with the \
         rotor held at the same current",
    reference: Some("bus_voltage_v"),
    rules: Rules { contradiction, ..Rules::NONE },
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    if scene.record.drive == Drive::Current || scene.has(Kind::SupplySag, Location::Inverter) {
        return Vec::new();
    }
    let scale = 0.02 * 2.0 * scene.model.motor.phase_resistance_ohm;
    vec![Hypothesis {
        start: EffectParameters::new(Kind::SupplySag, Location::Inverter)
            .with("bus_voltage_v", BUS * scene.largest_drive()),
        free: vec![Free::Value { value: 0, scale, sigma: 50.0 }],
    }]
}

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let sag = EffectParameters::new(Kind::SupplySag, Location::Inverter)
        .with("bus_voltage_v", 1.3 * joint.voltage_v)
        .with("source_resistance_ohm", 0.2 * joint.size * joint.resistance_ohm);
    Some(sag)
}

/// A sag that a measured bus does not show.
fn contradiction(effect: &EffectParameters, model: &Model, record: &Record) -> Option<String> {
    let bus = record.bus_v.as_deref()?;
    let level = quantile(bus, 0.5)?;
    let per_power = effect.values[0] / effect.values[1].powi(2);
    let drops = currents(model, record)
        .zip(&record.drive_values)
        .map(|(current, voltage)| level * per_power * voltage * current)
        .collect::<Vec<_>>();
    let predicted = span(&drops)?;
    let shown = (followed(&drops, bus) * predicted).max(0.0) + digit(bus);
    (shown < BUS_SHARE * predicted).then(|| {
        format!(
            "a supply sag would move the bus by {predicted:.2} V; bus_v goes along by {shown:.2} V"
        )
    })
}
