//! The demonstration: a joint with something hidden in it, and a user who knows a nominal model.
//!
//! The joint is a small robot actuator of our own choosing. Its log is made by the reference
//! integrator, which shares nothing with the fitter's step, with noise, counts and a friction law
//! that is not quite the model's; the nominal is wrong in every parameter. Which effect is hidden,
//! and how large it is, follows from the seed.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::{Friction, Load, Location, Motor, Stage};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::log::Log;
use crate::model::{Model, Sensor};
use crate::reference::ReferenceError;
use crate::synthetic::{Experiment, perturbed, record};

/// A log with something hidden in it.
#[derive(Clone, Debug)]
pub struct Riddle {
    /// What the user knows.
    pub nominal: Model,
    /// What was measured.
    pub log: Log,
    /// What was hidden.
    pub hidden: EffectParameters,
}

/// Makes the riddle of a seed.
///
/// # Errors
/// The reference cannot simulate it.
pub fn riddle(seed: u64) -> Result<Riddle, ReferenceError> {
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x6a6f_696e_7400);
    let mut truth = perturbed(&actuator(), seed);
    let nominal = perturbed(&truth, seed.wrapping_add(1));
    let hidden = hide(Kind::ALL[random.random_range(0..Kind::ALL.len())], &truth, &mut random);
    truth.effects.push(hidden);
    let exponent = random.random_range(1.7..2.0);
    let experiment =
        Experiment { duration_s: 2.0, stribeck_exponent: exponent, ..Experiment::default() };
    let log = record(&truth, &experiment, seed)?;
    Ok(Riddle { nominal, log, hidden })
}

/// The joint of the demonstration: a 9:1 actuator with an encoder on each side of its gear.
pub fn actuator() -> Model {
    Model {
        name: "demo".to_owned(),
        motor: Motor {
            phase_resistance_ohm: 0.42,
            phase_inductance_h: 0.21e-3,
            torque_constant_nm_per_a: 0.085,
            pole_pairs: 7,
            rotor_inertia_kg_m2: 4.1e-5,
            friction: Friction {
                sigma0_nm_per_rad: 14.0,
                sigma1_nm_s_per_rad: 0.012,
                sigma2_nm_s_per_rad: 9e-5,
                coulomb_nm: 0.014,
                stribeck_nm: 0.006,
                stribeck_velocity_rad_per_s: 3.0,
            },
            ..Motor::default()
        },
        stages: vec![Stage {
            reduction: 9.0,
            inertia_kg_m2: 0.0042,
            stiffness_nm_per_rad: 260.0,
            damping_nm_s_per_rad: 0.04,
            friction: Friction {
                sigma0_nm_per_rad: 500.0,
                sigma1_nm_s_per_rad: 1.1,
                sigma2_nm_s_per_rad: 0.025,
                coulomb_nm: 0.12,
                stribeck_nm: 0.06,
                stribeck_velocity_rad_per_s: 0.3,
            },
            ..Stage::default()
        }],
        load: Load::default(),
        sensor: Sensor {
            sample_time_s: 2e-4,
            motor_encoder_counts_per_rev: 16384.0,
            output_encoder_counts_per_rev: 65536.0,
            current_noise_a: 0.02,
        },
        effects: Vec::new(),
    }
}

/// An effect of a kind, of a size that a user of this joint would care about.
fn hide(kind: Kind, joint: &Model, random: &mut ChaCha8Rng) -> EffectParameters {
    let breakaway = joint.motor.friction.breakaway_nm();
    let stage = &joint.stages[0];
    let size = random.random_range(0.7..1.5);
    let phase = random.random_range(-3.0..3.0);
    let sign = if random.random::<bool>() { 1.0 } else { -1.0 };
    let at = |location| EffectParameters::new(kind, location);
    match kind {
        Kind::AsymmetricFriction => at(Location::Motor).with("asymmetry", sign * 0.25 * size),
        Kind::Backlash => at(Location::Stage(1)).with("width_rad", 4e-3 * size),
        Kind::Cogging => {
            let order = f64::from(joint.motor.pole_pairs * [2, 6, 12][random.random_range(0..3)]);
            at(Location::Motor)
                .with("order", order)
                .with("amplitude_nm", 0.7 * size * breakaway)
                .with("phase_rad", phase)
        }
        Kind::CurrentOffset => at(Location::CurrentSensor).with("offset_a", sign * 0.15 * size),
        Kind::DeadTime => at(Location::Inverter)
            .with("voltage_v", 0.7 * size)
            .with("softening_a", 2.0 * joint.sensor.current_noise_a),
        Kind::Gravity => at(Location::Output)
            .with("amplitude_nm", 3.0 * size * stage.friction.breakaway_nm())
            .with("phase_rad", phase),
        _ => EffectParameters::new(Kind::LoadDependentFriction, Location::Stage(1))
            .with("coefficient", 0.1 * size),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_seed_makes_the_same_riddle_and_another_seed_another() {
        let (one, again, other) = (riddle(3).unwrap(), riddle(3).unwrap(), riddle(4).unwrap());
        assert_eq!(one.hidden, again.hidden);
        assert_eq!(one.log, again.log);
        assert_ne!(one.log, other.log);
        assert!(one.nominal.effects.is_empty());
    }

    #[test]
    fn some_seed_hides_each_kind() {
        let hidden = |seed| {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            Kind::ALL[random.random_range(0..Kind::ALL.len())]
        };
        let found: std::collections::HashSet<Kind> = (0..200).map(hidden).collect();
        assert_eq!(found.len(), Kind::ALL.len());
    }
}
