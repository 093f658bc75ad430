//! Channels that no model predicts, but that a name must not contradict.
//!
//! A bus voltage or a temperature in the log is never fitted to. But a supply that is said to give way
//! by volts must be seen to do so where the bus is measured, and a winding that is said to heat must
//! leave some trace on a thermometer in the same housing. A term that fits is not yet the right name.

use joint_core::effect::Kind;
use joint_core::joint::Drive;

use crate::discover::bounds::{BUS_SHARE, TEMPERATURE_SHARE};
use crate::estimate::record::{Channel, Record};
use crate::model::Model;

/// Rise of copper's resistance per kelvin.
const COPPER: f64 = 3.93e-3;
/// Samples over which a speed is taken.
const SPAN: usize = 5;
/// Share of the samples on either side that a channel's span leaves out.
const TAIL: f64 = 0.02;

/// How a model's last effect contradicts a channel that was not fitted to; `None` where it does not.
pub(crate) fn contradiction(model: &Model, record: &Record) -> Option<(Kind, String)> {
    let effect = model.effects.last()?;
    let against = match effect.kind {
        Kind::SupplySag => {
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
        Kind::WindingHeating => {
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
        _ => None,
    };
    Some((effect.kind, against?))
}

/// Current by sample, A: measured, imposed, or what voltage and speed leave for the resistance.
fn currents<'a>(model: &'a Model, record: &'a Record) -> impl Iterator<Item = f64> + 'a {
    let motor = &model.motor;
    let resistance = 2.0 * motor.phase_resistance_ohm;
    let samples = record.len();
    (0..samples).map(move |k| {
        let measured = record.measured[k][Channel::Current as usize];
        if record.drive == Drive::Current {
            return record.drive_values[k];
        }
        if measured.is_finite() {
            return measured;
        }
        let (from, to) = (k.saturating_sub(SPAN), (k + SPAN).min(samples - 1));
        let [a, b] = [from, to].map(|at| record.measured[at][Channel::Motor as usize]);
        let speed = (b - a) / (record.time_s[to] - record.time_s[from]);
        let emf = motor.torque_constant_nm_per_a * speed;
        (record.drive_values[k] - if emf.is_finite() { emf } else { 0.0 }) / resistance
    })
}

/// How much a bus falls for every volt that it is to drop, by least squares: what moves it for other
/// reasons does not count.
fn followed(drops: &[f64], bus: &[f64]) -> f64 {
    let pairs = || drops.iter().zip(bus).filter(|(drop, bus)| drop.is_finite() && bus.is_finite());
    let count = pairs().count().max(1) as f64;
    let (drops, levels) = pairs().fold((0.0, 0.0), |(d, b), (drop, bus)| (d + drop, b + bus));
    let (drops, levels) = (drops / count, levels / count);
    let (mut along, mut square) = (0.0, 0.0);
    for (drop, bus) in pairs() {
        along -= (drop - drops) * (bus - levels);
        square += (drop - drops).powi(2);
    }
    if square > 0.0 { along / square } else { 0.0 }
}

/// How far most of the values lie apart.
fn span(values: &[f64]) -> Option<f64> {
    Some(quantile(values, 1.0 - TAIL)? - quantile(values, TAIL)?)
}

/// Smallest change that a channel shows; zero where it never moves.
fn digit(values: &[f64]) -> f64 {
    let steps = values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let smallest = steps.filter(|step| *step > 1e-12).fold(f64::INFINITY, f64::min);
    if smallest.is_finite() { smallest } else { 0.0 }
}

fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let place = (share * sorted.len().saturating_sub(1) as f64).round() as usize;
    sorted.get(place).copied()
}

#[cfg(test)]
mod tests {
    use joint_core::effect::EffectParameters;
    use joint_core::params::Location;

    use super::*;
    use crate::demo::actuator;
    use crate::log::Log;

    /// A supply of 1 Ω behind a bus of 24 V, asked for 12 V and 4 A half of the time: 2 V.
    fn sagging(bus_v: impl Fn(bool) -> f64) -> Option<String> {
        let loaded = |k: usize| k / 50 % 2 == 1;
        let column = |on: f64| (0..1000).map(|k| if loaded(k) { on } else { 0.0 }).collect();
        let log = Log {
            time_s: (0..1000).map(|k| f64::from(k) * 1e-3).collect(),
            voltage_v: Some(column(12.0)),
            current_a: Some(column(4.0)),
            motor_angle_rad: vec![0.0; 1000],
            bus_v: Some((0..1000).map(|k| bus_v(loaded(k)) + 0.01 * (k % 2) as f64).collect()),
            ..Log::default()
        };
        let mut model = actuator();
        model.effects.push(
            EffectParameters::new(Kind::SupplySag, Location::Inverter)
                .with("source_resistance_ohm", 1.0)
                .with("bus_voltage_v", 24.0),
        );
        Some(contradiction(&model, &Record::new(&log, None))?.1)
    }

    #[test]
    fn a_sag_must_be_seen_on_the_bus() {
        assert_eq!(sagging(|loaded| if loaded { 22.0 } else { 24.0 }), None);
        assert_eq!(sagging(|_| f64::NAN), None);
        let against = sagging(|loaded| if loaded { 23.8 } else { 24.0 }).unwrap();
        assert!(against.contains("2.00 V") && against.contains("0.21"), "{against}");
        assert!(sagging(|_| 24.0).is_some());
    }

    #[test]
    fn a_bus_that_moves_for_another_reason_follows_nothing() {
        let drops: Vec<f64> = (0..1000).map(|k| f64::from(k / 50 % 2) * 2.0).collect();
        let battery: Vec<f64> = (0..1000).map(|k| 12.0 - 2e-3 * f64::from(k)).collect();
        assert!(followed(&drops, &battery).abs() < 0.1);
        let sagging: Vec<f64> = drops.iter().map(|drop| 12.0 - 0.8 * drop).collect();
        assert!((followed(&drops, &sagging) - 0.8).abs() < 1e-9);
    }

    #[test]
    fn a_hot_winding_must_be_felt_in_the_housing() {
        let heated = |rise: f64| {
            let log = Log {
                time_s: (0..1000).map(|k| f64::from(k) * 0.1).collect(),
                voltage_v: Some(vec![12.0; 1000]),
                current_a: Some(vec![2.0; 1000]),
                motor_angle_rad: vec![0.0; 1000],
                temperature_c: Some((0..1000).map(|k| 25.0 + rise * f64::from(k) * 1e-3).collect()),
                ..Log::default()
            };
            let mut model = actuator();
            model.effects.push(
                EffectParameters::new(Kind::WindingHeating, Location::Motor)
                    .with("relative_rise", 0.393)
                    .with("time_constant_s", 20.0)
                    .with("reference_current_a", 2.0),
            );
            Some(contradiction(&model, &Record::new(&log, None))?.1)
        };
        assert_eq!(heated(30.0), None);
        assert!(heated(2.0).unwrap().contains("99 K"), "{:?}", heated(2.0));
    }
}
