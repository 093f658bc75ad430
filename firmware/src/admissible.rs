//! Whether coefficients are such that the equations can take them.
//!
//! A checksum says that a block is what its writer wrote, not that the writer was right. The host
//! validates SI parameters and names the key; the chip sees coefficients, and refuses those with
//! which the step would divide by zero, gain energy or never end. The check walks whatever is
//! serialisable, so a coefficient that is added later is looked at without being told of.

mod walk;

use joint_core::joint::{IMPLICIT, MAX_MICRO_STEPS};
use serde::Serialize;

use walk::{Refused, Walk};

/// What a coefficient of this name must be, beside finite and not beyond [`LARGEST`].
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rule {
    Finite,
    NotNegative,
    Positive,
    Between(f32, f32),
    Whole(u64, u64),
}

/// No coefficient is larger: the step multiplies three of them.
const LARGEST: f32 = 1e12;

/// The rules by the name of the structure, any where none stands, and of the field; what is not named
/// must be finite.
const RULES: &[(&str, &str, Rule)] = &[
    // Of the splitting or of the implicit method: the other's are none.
    ("Joint", "micro_steps", Rule::Whole(if IMPLICIT { 0 } else { 1 }, MAX_MICRO_STEPS as u64)),
    ("Implicit", "micro_steps", Rule::Whole(0, if IMPLICIT { MAX_MICRO_STEPS as u64 } else { 0 })),
    ("", "half_drift", Rule::Positive),
    ("", "half_turn", Rule::Positive),
    ("", "turns", Rule::Positive),
    ("", "per_stribeck_velocity", Rule::NotNegative),
    ("", "beta", Rule::Between(-1.0 + 1e-7, LARGEST)),
    ("", "kappa", Rule::NotNegative),
    ("Friction", "level", Rule::NotNegative),
    ("Friction", "stiffness", Rule::NotNegative),
    ("", "standing", Rule::NotNegative),
    ("", "per_reach", Rule::NotNegative),
    ("", "sigma1", Rule::NotNegative),
    ("", "sigma2", Rule::NotNegative),
    ("", "rotor_gamma", Rule::NotNegative),
    ("", "gamma", Rule::NotNegative),
    ("", "mobility", Rule::Positive),
    ("Implicit", "followed", Rule::Between(0.0, 1.0)),
    ("RotorKick", "per_torque", Rule::Positive),
    ("RotorKick", "induced", Rule::Between(0.0, 2.0)),
    ("RotorKick", "decay", Rule::Between(0.0, 1.0)),
    ("RotorKick", "approach", Rule::Between(0.0, 1.0)),
    ("Spring", "linear", Rule::NotNegative),
    ("Spring", "cubic", Rule::NotNegative),
    ("Units", "current", Rule::Positive),
    ("Units", "speed", Rule::Positive),
    ("Units", "torque", Rule::Positive),
    ("Units", "angle", Rule::Positive),
    ("", "sample_time_s", Rule::Between(1e-6, 0.1)),
    ("", "motor_counts_per_turn", Rule::Whole(1, 1 << 24)),
    ("", "output_counts_per_turn", Rule::Whole(0, 1 << 24)),
    ("", "pole_pairs", Rule::Whole(1, 1 << 10)),
    ("", "largest_voltage_v", Rule::Positive),
    ("", "largest_current_a", Rule::Positive),
    ("", "largest_move_counts", Rule::Whole(1, 1 << 24)),
    ("", "per_sigma", Rule::NotNegative),
    ("Whiten", "gate", Rule::NotNegative),
    ("", "leak", Rule::Between(-1.0, 1.0)),
    ("", "smoothing", Rule::Between(0.0, 1.0)),
    ("", "settle", Rule::Between(0.0, 1.0)),
    ("", "alarm_rate", Rule::Between(0.0, 1.0)),
    ("", "most_load", Rule::NotNegative),
    ("", "most_bias", Rule::NotNegative),
    ("", "most_ohm", Rule::NotNegative),
    ("", "most_flux", Rule::NotNegative),
    ("", "most_level", Rule::NotNegative),
    ("", "outlier", Rule::NotNegative),
    ("", "missing", Rule::NotNegative),
    ("", "mean_deceleration", Rule::Between(0.0, 1.0)),
    ("", "winding", Rule::Between(0.0, 1.0)),
    ("", "most_current", Rule::Positive),
    ("", "most_drive", Rule::Positive),
    ("", "most_speed", Rule::Positive),
];

/// Checks every number in there.
///
/// # Errors
/// The name of the first that is not admissible.
pub fn check(value: &impl Serialize) -> Result<(), &'static str> {
    let rule = Rule::Finite;
    match value.serialize(Walk { owner: "", name: "value", rule }) {
        Ok(()) => Ok(()),
        Err(Refused(name)) => Err(name),
    }
}

#[cfg(test)]
mod tests {
    use joint_core::effect::{EffectParameters, Kind};
    use joint_core::joint::{Drive, Settings};
    use joint_core::observer::{
        CHANNELS, Column, Design, Gains, Level, Observer, Regime, SETS, Spread,
    };
    use joint_core::params::{Friction, Load, Location, Motor, Stage};
    use serde_json::Value;

    use super::*;
    use crate::parameters::{Parameters, Sensing};

    fn parameters() -> Parameters<2> {
        let friction = Friction {
            sigma0_nm_per_rad: 10.0,
            sigma1_nm_s_per_rad: 0.01,
            coulomb_nm: 0.01,
            ..Friction::default()
        };
        let motor = Motor {
            phase_resistance_ohm: 0.5,
            phase_inductance_h: 1e-4,
            torque_constant_nm_per_a: 0.1,
            rotor_inertia_kg_m2: 1e-5,
            friction,
            ..Motor::default()
        };
        let stage = Stage {
            reduction: 10.0,
            inertia_kg_m2: 1e-3,
            stiffness_nm_per_rad: 300.0,
            friction,
            ..Stage::default()
        };
        let cogging = EffectParameters::new(Kind::Cogging, Location::Motor)
            .with("order", 6.0)
            .with("amplitude_nm", 1e-3);
        let settings = Settings { effects: &[cogging], ..Settings::new(Drive::Voltage, 50e-6) };
        let joint = crate::parameters::DriveJoint::<2>::new(
            &motor,
            &[stage; 2],
            &Load::default(),
            &settings,
        )
        .unwrap();
        let design = Design {
            sets: [[Column::filled(0.1); CHANNELS]; SETS],
            hardened: 0.01,
            sigma: [0.01; CHANNELS],
            gate: 8.0,
            leak: [0.9; Regime::COUNT],
            projection: [[0.5; CHANNELS]; 2],
            smoothing: 0.1,
            alarm: 3.0,
            hold: 10,
            alarm_rate: 0.01,
            varying: (0.2, 100),
            settled: 100,
            inconsistent: 10.0,
            most_load_nm: 5.0,
            most_bias: 2.0,
            most_ohm: 0.5,
            most_flux: 0.1,
            ohm: 0.0,
            flux: 0.0,
            level: Level::NONE,
            outlier: 1e3,
            push: 0.0,
            confirmed: u16::MAX / 2,
            most_current_a: 10.0,
            spread: [Spread::filled(0.1); SETS],
            turning: [0.0; 2],
        };
        let gains = Gains::new(&design, &motor, &[stage; 2], Drive::Voltage, 50e-6);
        Parameters { observer: Observer { joint, gains }, sensing: Sensing::default() }
    }

    /// Every number below a key, set in turn; `owner` is the key of the structure that has it, any
    /// where it is empty.
    fn set(value: &Value, owner: &str, key: &str, wrong: &Value, here: (bool, bool)) -> Vec<Value> {
        let (owned, inside) = here;
        match value {
            Value::Object(fields) => fields
                .iter()
                .flat_map(|(name, own)| {
                    let here = (owner.is_empty() || name == owner, owned && name == key);
                    let changed = set(own, owner, key, wrong, here);
                    changed.into_iter().map(move |own| {
                        let mut all = fields.clone();
                        all.insert(name.clone(), own);
                        Value::Object(all)
                    })
                })
                .collect(),
            Value::Array(items) => (0..items.len())
                .flat_map(|k| {
                    let changed = set(&items[k], owner, key, wrong, here);
                    changed.into_iter().map(move |own| {
                        let mut all = items.clone();
                        all[k] = own;
                        Value::Array(all)
                    })
                })
                .collect(),
            Value::Number(_) if inside => vec![wrong.clone()],
            _ => vec![],
        }
    }

    #[test]
    fn a_joint_that_the_host_built_is_admissible() {
        assert_eq!(check(&parameters()), Ok(()));
    }

    #[test]
    fn every_rule_has_coefficients_and_refuses_each_of_them_by_name() {
        let good = serde_json::to_value(parameters()).unwrap();
        for (owner, key, rule) in RULES {
            // Structures by the keys that hold them.
            let owner = match *owner {
                "Units" => "units",
                "Friction" => "friction",
                "Spring" => "spring",
                "RotorKick" => "middle",
                "Whiten" => "whiten",
                "Implicit" => "implicit",
                "Joint" => "joint",
                _ => "",
            };
            let wrong = match rule {
                Rule::Finite => continue,
                Rule::NotNegative | Rule::Between(..) => Value::from(-3.0),
                Rule::Positive => Value::from(0.0),
                Rule::Whole(_, high) => Value::from(high + 1),
            };
            let all = set(&good, owner, key, &wrong, (owner.is_empty(), false));
            assert!(!all.is_empty(), "{key} is the name of nothing");
            for bad in all {
                let bad: Parameters<2> = serde_json::from_value(bad).unwrap();
                assert_eq!(check(&bad), Err(*key));
            }
        }
    }

    #[test]
    fn what_is_no_number_is_refused_wherever_it_stands() {
        for bad in [f32::NAN, f32::INFINITY, -f32::INFINITY, 1e30] {
            assert_eq!(check(&[0.0, bad]), Err("value"));
            assert!(check(&Some((1_u8, [bad]))).is_err());
            assert!(check(&f64::from(bad)).is_err() != bad.is_finite());
        }
    }
}
