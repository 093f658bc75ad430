//! Channels that no model predicts, but that a name must not contradict.
//!
//! A bus voltage or a temperature in the log is never fitted to. But a supply that is said to give way
//! by volts must be seen to do so where the bus is measured, and a winding that is said to heat must
//! leave some trace on a thermometer in the same housing. A term that fits is not yet the right name. What a kind
//! predicts of a channel, its card says.

use joint_core::effect::Kind;

use crate::discover::candidates::card;
use crate::estimate::record::Record;
use crate::model::Model;

/// How a model's last effect contradicts a channel that was not fitted to; `None` where it does not.
pub(crate) fn contradiction(model: &Model, record: &Record) -> Option<(Kind, String)> {
    let effect = model.effects.last()?;
    let against = (card(effect.kind).rules.contradiction)(effect, model, record)?;
    Some((effect.kind, against))
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
