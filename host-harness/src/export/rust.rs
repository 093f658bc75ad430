//! The parameters as a Rust source file, for firmware that is built with its joint.

use std::fmt::Write;

use firmware::block::Block;
use joint_core::joint::Drive;
use joint_core::params::{Friction, Motor, Stage};

use super::{DriveOptions, ExportError, block, identifier};
use crate::model::Model;

/// A module with the block's bytes, and the SI parameters that they were made from.
///
/// # Errors
/// The joint cannot run in the firmware with these options.
pub fn source(model: &Model, options: &DriveOptions) -> Result<String, ExportError> {
    let bytes = block::block(model, options)?;
    let crc = Block::check(&bytes).map_or(0, |block| block.crc);
    let mut text = String::new();
    let period_us = options.period_s * 1e6;
    let input = match options.drive {
        Drive::Voltage => "voltage",
        Drive::Current => "current",
    };
    let name = identifier(model);
    // Writing into a string does not fail.
    let _ = write!(
        text,
        "//! Parameters of the joint `{name}`, written by `joint export --format rust`: a control\n\
         //! period of {period_us} µs with the {input} as input. Do not edit.\n\n\
         use joint_core::params::{{Friction, Load, Motor, Stage}};\n\n\
         /// Control period, s.\npub const PERIOD_S: f64 = {:?};\n\
         /// The motor, in SI units.\npub const MOTOR: Motor = {};\n\
         /// The gear stages, in SI units.\npub const STAGES: [Stage; {}] = [{}];\n\
         /// The load, in SI units.\npub const LOAD: Load = Load {{ inertia_kg_m2: {:?}, \
         gravity_nm: {:?}, gravity_phase_rad: {:?} }};\n",
        options.period_s,
        motor(&model.motor),
        model.stages.len(),
        model.stages.iter().map(stage).collect::<Vec<_>>().join(", "),
        model.load.inertia_kg_m2,
        model.load.gravity_nm,
        model.load.gravity_phase_rad,
    );
    for effect in &model.effects {
        let spec = effect.kind.spec();
        let values: Vec<String> = spec
            .parameters
            .iter()
            .zip(effect.values)
            .map(|(parameter, value)| format!("{} = {value:?}", parameter.key))
            .collect();
        let _ =
            writeln!(text, "// effect {} at {}: {}", spec.kind, effect.location, values.join(", "));
    }
    let _ = write!(
        text,
        "/// The parameter block, effects included: for `firmware::session::Session::start`, or \
         `joint_init` of the C library.\npub const BLOCK: [u8; {}] = [",
        bytes.len()
    );
    for (k, byte) in bytes.iter().enumerate() {
        let _ = write!(text, "{}{byte:#04x},", if k % 16 == 0 { "\n    " } else { " " });
    }
    let _ =
        writeln!(text, "\n];\n/// Checksum of the block.\npub const BLOCK_CRC: u32 = {crc:#010x};");
    Ok(text)
}

fn motor(motor: &Motor) -> String {
    format!(
        "Motor {{ phase_resistance_ohm: {:?}, phase_inductance_h: {:?}, \
         torque_constant_nm_per_a: {:?}, phase_back_emf_constant_v_s_per_rad: {:?}, \
         pole_pairs: {}, rotor_inertia_kg_m2: {:?}, friction: {} }}",
        motor.phase_resistance_ohm,
        motor.phase_inductance_h,
        motor.torque_constant_nm_per_a,
        motor.phase_back_emf_constant_v_s_per_rad,
        motor.pole_pairs,
        motor.rotor_inertia_kg_m2,
        friction(&motor.friction),
    )
}

fn stage(stage: &Stage) -> String {
    format!(
        "Stage {{ reduction: {:?}, inertia_kg_m2: {:?}, stiffness_nm_per_rad: {:?}, \
         cubic_stiffness_nm_per_rad3: {:?}, damping_nm_s_per_rad: {:?}, \
         worm_friction_coefficient: {:?}, worm_lead_angle_rad: {:?}, friction: {} }}",
        stage.reduction,
        stage.inertia_kg_m2,
        stage.stiffness_nm_per_rad,
        stage.cubic_stiffness_nm_per_rad3,
        stage.damping_nm_s_per_rad,
        stage.worm_friction_coefficient,
        stage.worm_lead_angle_rad,
        friction(&stage.friction),
    )
}

fn friction(friction: &Friction) -> String {
    format!(
        "Friction {{ sigma0_nm_per_rad: {:?}, sigma1_nm_s_per_rad: {:?}, \
         sigma2_nm_s_per_rad: {:?}, coulomb_nm: {:?}, stribeck_nm: {:?}, \
         stribeck_velocity_rad_per_s: {:?} }}",
        friction.sigma0_nm_per_rad,
        friction.sigma1_nm_s_per_rad,
        friction.sigma2_nm_s_per_rad,
        friction.coulomb_nm,
        friction.stribeck_nm,
        friction.stribeck_velocity_rad_per_s,
    )
}
