//! The joint as a URDF: one rigid joint, with what is known of it from the output.
//!
//! URDF has a joint's damping, Coulomb friction and limits, and nothing of a motor, a spring or a bristle.
//! So everything is seen from the output, through a stiff gear: friction and damping of every mass add up,
//! limits follow from the drive. The rotor's inertia acts about the axis alone, which no link's inertia
//! does; it stands with the numbers of the model in an element of its own, which readers of URDF skip.

use std::fmt::Write;

use super::mjcf::masses::{frictions, masses};
use super::{DriveOptions, identifier};
use crate::model::Model;
use crate::plant::inertias;

/// A URDF, and what it leaves out of the joint's model.
#[derive(Clone, Debug, PartialEq)]
pub struct Urdf {
    /// The file's text.
    pub text: String,
    /// What is lost, one line each.
    pub lost: Vec<String>,
}

/// The joint seen from its output.
struct Seen {
    /// Motor turns for one of the output; negative where the gear reverses.
    reduction: f64,
    damping_nm_s_per_rad: f64,
    coulomb_nm: f64,
    /// Of every mass but the last.
    armature_kg_m2: f64,
    effort_nm: f64,
    speed_rad_per_s: f64,
}

impl Seen {
    fn new(model: &Model, options: &DriveOptions) -> Self {
        let reduction: f64 = model.stages.iter().map(|stage| stage.reduction).product();
        let stages = model.stages.iter().map(|stage| stage.reduction);
        // From each mass to the output.
        let mut ahead = reduction;
        let (mut damping, mut coulomb) = (0.0, 0.0);
        for (friction, own) in frictions(model).zip([1.0].into_iter().chain(stages)) {
            ahead /= own;
            damping += friction.sigma2_nm_s_per_rad * ahead * ahead;
            coulomb += friction.coulomb_nm * ahead.abs();
        }
        let reflected = inertias(model);
        let before = &reflected[..reflected.len() - 1];
        let motor = &model.motor;
        let (constant, resistance) =
            (motor.torque_constant_nm_per_a, 2.0 * motor.phase_resistance_ohm);
        let stall = options.bus_v / resistance;
        let current = if stall.is_finite() {
            stall.min(options.current_limit_a)
        } else {
            options.current_limit_a
        };
        Self {
            reduction,
            damping_nm_s_per_rad: damping,
            coulomb_nm: coulomb,
            armature_kg_m2: before.iter().sum::<f64>() * reduction * reduction,
            effort_nm: constant * current * reduction.abs(),
            speed_rad_per_s: options.bus_v / (constant * reduction.abs()),
        }
    }
}

/// The URDF.
pub fn urdf(model: &Model, options: &DriveOptions) -> Urdf {
    let mut lost = lost(model);
    let seen = Seen::new(model, options);
    let bodies = masses(model, &mut lost);
    let output = &bodies[bodies.len() - 1];
    let ([out, along], inertia) = (output.offset_m, output.inertia_kg_m2);
    let name = identifier(model);
    let mut text = String::new();
    // Writing into a string does not fail.
    let _ = write!(
        text,
        "<?xml version=\"1.0\"?>\n<!-- The joint {name}, by `joint export --format urdf`, seen from its output. SI \
         units.\n     Left out, since URDF has no such element:\n{}-->\n\
         <robot name=\"{name}\">\n  <link name=\"base\"/>\n  <link name=\"output\">\n    <inertial>\n      \
         <origin xyz=\"{out:?} 0 {along:?}\"/>\n      <mass value=\"{:?}\"/>\n      \
         <inertia ixx=\"{inertia:?}\" iyy=\"{inertia:?}\" izz=\"{inertia:?}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>\n    \
         </inertial>\n  </link>\n",
        lost.iter()
            .map(|line| format!("       {}\n", line.replace("--", "- -")))
            .collect::<String>(),
        output.mass_kg,
    );
    let _ = write!(
        text,
        "  <joint name=\"{name}\" type=\"continuous\">\n    <parent link=\"base\"/>\n    <child link=\"output\"/>\n    \
         <axis xyz=\"0 -1 0\"/>\n    <dynamics damping=\"{:?}\" friction=\"{:?}\"/>\n    \
         <limit effort=\"{:?}\" velocity=\"{:?}\"/>\n  </joint>\n",
        seen.damping_nm_s_per_rad, seen.coulomb_nm, seen.effort_nm, seen.speed_rad_per_s,
    );
    let _ = write!(
        text,
        "  <transmission name=\"{name}_transmission\">\n    \
         <type>transmission_interface/SimpleTransmission</type>\n    <joint name=\"{name}\">\n      \
         <hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface>\n    </joint>\n    \
         <actuator name=\"{name}_motor\">\n      <mechanicalReduction>{:?}</mechanicalReduction>\n    </actuator>\n  \
         </transmission>\n",
        seen.reduction,
    );
    let _ = write!(
        text,
        "  <joint_model joint=\"{name}\" armature_kg_m2=\"{:?}\" torque_constant_nm_per_a=\"{:?}\" \
         resistance_ohm=\"{:?}\" inductance_h=\"{:?}\" windup_nm_per_rad=\"{:?}\" \
         encoder_counts_per_output_turn=\"{:?}\"/>\n</robot>\n",
        seen.armature_kg_m2,
        model.motor.torque_constant_nm_per_a,
        2.0 * model.motor.phase_resistance_ohm,
        2.0 * model.motor.phase_inductance_h,
        windup(model),
        model.sensor.motor_encoder_counts_per_rev * seen.reduction.abs(),
    );
    Urdf { text, lost }
}

/// Stiffness of the whole gear at its output; infinite without a stage, so zero stands for it.
fn windup(model: &Model) -> f64 {
    let mut ahead: f64 = model.stages.iter().map(|stage| stage.reduction).product();
    let compliance: f64 = model
        .stages
        .iter()
        .map(|stage| {
            ahead /= stage.reduction;
            1.0 / (stage.stiffness_nm_per_rad * ahead * ahead)
        })
        .sum();
    if compliance > 0.0 { 1.0 / compliance } else { 0.0 }
}

fn lost(model: &Model) -> Vec<String> {
    let mut lost = vec!["the motor: its winding, its back-EMF, the rotor's inertia".to_owned()];
    if !model.stages.is_empty() {
        lost.push("the stages' springs: the gear is stiff".to_owned());
    }
    if frictions(model).any(|friction| friction.coulomb_nm > 0.0) {
        lost.push("presliding and the Stribeck excess of friction".to_owned());
    }
    for effect in &model.effects {
        if effect.kind != joint_core::effect::Kind::Gravity {
            lost.push(format!("effect {} at {}", effect.kind.spec().kind, effect.location));
        }
    }
    lost
}

#[cfg(test)]
mod tests {
    use joint_core::joint::Drive;

    use super::*;
    use crate::demo::actuator;

    /// Of the demonstration's actuator by hand: one stage of 9:1.
    #[test]
    fn friction_and_limits_are_those_at_the_output() {
        let model = actuator();
        let options = DriveOptions {
            period_s: 5e-5,
            drive: Drive::Voltage,
            bus_v: 24.0,
            current_limit_a: 10.0,
        };
        let seen = Seen::new(&model, &options);
        let stage = model.stages[0].friction;
        let wanted = [
            (seen.reduction, 9.0),
            (seen.coulomb_nm, 9.0 * 0.014 + stage.coulomb_nm),
            (seen.damping_nm_s_per_rad, 81.0 * 9e-5 + stage.sigma2_nm_s_per_rad),
            (seen.armature_kg_m2, 81.0 * 4.1e-5),
            // Ten amperes are less than the 28.6 of a stalled winding.
            (seen.effort_nm, 0.085 * 10.0 * 9.0),
            (seen.speed_rad_per_s, 24.0 / (0.085 * 9.0)),
            (windup(&model), 260.0),
        ];
        for (k, (found, wanted)) in wanted.into_iter().enumerate() {
            assert!((found / wanted - 1.0).abs() < 1e-12, "{k}: {found} {wanted}");
        }
        let text = urdf(&model, &options).text;
        assert_eq!(text.matches("<link ").count(), 2);
    }
}
