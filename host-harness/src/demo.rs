//! The demonstration: a joint with something hidden in it, and a user who knows a nominal model.
//!
//! The joint is a small robot actuator of our own choosing. Its log is made by the reference
//! integrator, which shares nothing with the fitter's step, with noise, counts and a friction law
//! that is not quite the model's; the nominal is wrong in every parameter. Which effect is hidden,
//! and how large it is, follows from the seed.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::{Friction, Load, Motor, Stage};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::log::Log;
use crate::model::{Model, Sensor};
use crate::reference::ReferenceError;
use crate::synthetic::{Experiment, hidden, kinds, perturbed, record};

/// Length of the log, s.
const DURATION_S: f64 = 2.0;

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
    let kinds: Vec<Kind> = kinds().collect();
    let kind = kinds[random.random_range(0..kinds.len())];
    let size = random.random_range(0.7..1.5);
    let hidden = hidden(kind, &truth, size, DURATION_S, &mut random)
        .ok_or(ReferenceError::Inputs("the joint has no place for this effect"))?;
    truth.effects.push(hidden);
    let exponent = random.random_range(1.7..2.0);
    let experiment =
        Experiment { duration_s: DURATION_S, stribeck_exponent: exponent, ..Experiment::default() };
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
