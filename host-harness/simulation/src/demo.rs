//! The joint of the demonstration: a small robot actuator of our own choosing.

use joint_core::params::{Friction, Load, Motor, Stage};

use crate::model::{Model, Sensor};

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
            ..Sensor::default()
        },
        effects: Vec::new(),
        friction_levels: Vec::new(),
    }
}
