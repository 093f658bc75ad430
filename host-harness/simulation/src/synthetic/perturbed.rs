//! The numbers that a user has of a joint: close, and all of them wrong.

use joint_core::params::Friction;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::model::Model;

/// The model with every parameter wrong by 3 to 8 %, and what datasheets do not say, friction,
/// cubic stiffness and damping, by 10 to 20 %, up or down. Reductions and sensors stay, k_t = 2 k_e
/// stays, and effects are left out: they are what a nominal does not know.
pub fn perturbed(model: &Model, seed: u64) -> Model {
    perturbed_within(model, seed, [0.03, 0.08], [0.1, 0.2])
}

/// The same with these bounds of the errors, as shares: of what a datasheet or a scale gives, and
/// of what it does not.
pub fn perturbed_within(model: &Model, seed: u64, given: [f64; 2], guessed: [f64; 2]) -> Model {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut wrong = |value: &mut f64, [from, to]: [f64; 2]| {
        let share = random.random_range(from..to);
        *value *= if random.random::<bool>() { 1.0 + share } else { 1.0 - share };
    };
    let mut model = Model { effects: Vec::new(), ..model.clone() };
    let motor = &mut model.motor;
    for value in [
        &mut motor.phase_resistance_ohm,
        &mut motor.phase_inductance_h,
        &mut motor.torque_constant_nm_per_a,
        &mut motor.rotor_inertia_kg_m2,
        &mut model.load.inertia_kg_m2,
        &mut model.load.gravity_nm,
    ] {
        wrong(value, given);
    }
    let constant = motor.torque_constant_nm_per_a;
    motor.phase_back_emf_constant_v_s_per_rad =
        motor.phase_back_emf_constant_v_s_per_rad.map(|_| 0.5 * constant);
    for value in parts(&mut motor.friction) {
        wrong(value, guessed);
    }
    for stage in &mut model.stages {
        for value in [&mut stage.inertia_kg_m2, &mut stage.stiffness_nm_per_rad] {
            wrong(value, given);
        }
        wrong(&mut stage.cubic_stiffness_nm_per_rad3, guessed);
        wrong(&mut stage.damping_nm_s_per_rad, guessed);
        for value in parts(&mut stage.friction) {
            wrong(value, guessed);
        }
    }
    model
}

fn parts(friction: &mut Friction) -> [&mut f64; 6] {
    [
        &mut friction.sigma0_nm_per_rad,
        &mut friction.sigma1_nm_s_per_rad,
        &mut friction.sigma2_nm_s_per_rad,
        &mut friction.coulomb_nm,
        &mut friction.stribeck_nm,
        &mut friction.stribeck_velocity_rad_per_s,
    ]
}
