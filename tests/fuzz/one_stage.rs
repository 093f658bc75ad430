//! The joint that the FMU's calls are tried on.

use joint_core::params::{Friction, Load, Motor, Stage};
use joint_fmu::{Input, Joint};

/// A joint with one stage, in periods of so many seconds.
pub(crate) fn one_stage(period_s: f64) -> Joint {
    let friction = Friction {
        sigma0_nm_per_rad: 0.05,
        sigma1_nm_s_per_rad: 5e-7,
        sigma2_nm_s_per_rad: 5e-9,
        coulomb_nm: 9e-6,
        stribeck_nm: 2e-6,
        stribeck_velocity_rad_per_s: 50.0,
    };
    let motor = Motor {
        phase_resistance_ohm: 4.55,
        phase_inductance_h: 13e-6,
        torque_constant_nm_per_a: 1.38e-3,
        rotor_inertia_kg_m2: 9.5e-10,
        friction,
        ..Motor::default()
    };
    let stage = Stage {
        reduction: 32.0,
        inertia_kg_m2: 8e-7,
        stiffness_nm_per_rad: 15.0,
        friction,
        ..Stage::default()
    };
    Joint {
        name: "one_stage".to_owned(),
        input: Input::Voltage,
        period_s,
        motor,
        stage: vec![stage],
        load: Load { inertia_kg_m2: 1e-7, ..Load::default() },
        effect: Vec::new(),
    }
}
