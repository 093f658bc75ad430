//! The joint that counts and examples are of: a 6 mm brushless micromotor with a 1024:1 planetary gear
//! in two stages. The paper prints no parameters; these are assumed within what such datasheets say,
//! with stiffness from the paper's wind-up.

use joint_core::params::{Friction, Motor, Stage};

/// Bristle stiffness, damping and viscous coefficient; Coulomb level, Stribeck excess and velocity.
pub const fn friction(sigma: [f64; 3], level: [f64; 3]) -> Friction {
    Friction {
        sigma0_nm_per_rad: sigma[0],
        sigma1_nm_s_per_rad: sigma[1],
        sigma2_nm_s_per_rad: sigma[2],
        coulomb_nm: level[0],
        stribeck_nm: level[1],
        stribeck_velocity_rad_per_s: level[2],
    }
}

/// A stage without damper or worm: reduction, inertia, linear and cubic stiffness.
pub const fn stage(reduction: f64, inertia: f64, springs: [f64; 2], friction: Friction) -> Stage {
    Stage {
        reduction,
        inertia_kg_m2: inertia,
        stiffness_nm_per_rad: springs[0],
        cubic_stiffness_nm_per_rad3: springs[1],
        damping_nm_s_per_rad: 0.0,
        worm_lead_angle_rad: 0.0,
        worm_friction_coefficient: 0.0,
        friction,
    }
}

/// The motor.
pub const MOTOR: Motor = Motor {
    phase_resistance_ohm: 4.55,
    phase_inductance_h: 13e-6,
    torque_constant_nm_per_a: 1.38e-3,
    phase_back_emf_constant_v_s_per_rad: None,
    pole_pairs: 1,
    rotor_inertia_kg_m2: 9.5e-10,
    friction: friction([0.05, 4e-7, 1e-9], [9e-6, 4e-6, 20.0]),
};

/// Its gear, the second stage with the link.
pub const STAGES: [Stage; 2] = [
    stage(32.0, 2e-9, [0.35, 0.0], friction([1.5, 6e-6, 2e-8], [8e-5, 4e-5, 0.6])),
    stage(32.0, 8e-7, [15.0, 1.5e6], friction([60.0, 2e-3, 2e-5], [1e-3, 5e-4, 0.02])),
];
