//! What acts between masses and on them, as MuJoCo's springs and actuators.
//!
//! A gear stage is a spring on the fixed tendon `η q_in − q_out` with a polynomial stiffness. The motor is a
//! `dcmotor`: winding, back-EMF, LuGre friction with its Stribeck curve, cogging, heat. A `dcmotor` without
//! input and without a motor's constant is LuGre friction alone, for the masses behind the gear. And LuGre
//! friction whose level is constant is Dahl's, which is the law of a hysteresis: on a tendon it is a gear's,
//! on the output a coating's.

use std::f64::consts::PI;
use std::fmt::Write;

use joint_core::effect::{EffectParameters, Kind};
use joint_core::joint::Drive;
use joint_core::params::{Friction, Location};

use super::masses::{at, frictions, name};
use crate::export::DriveOptions;
use crate::model::Model;

/// Whether an effect is expressed.
pub(super) fn is_expressed(effect: &EffectParameters, drive: Drive) -> bool {
    match effect.kind {
        Kind::Backlash
        | Kind::Cogging
        | Kind::Coating
        | Kind::Gravity
        | Kind::HardeningStiffness
        | Kind::QuadraticDrag
        | Kind::StructuralHysteresis => true,
        Kind::WindingHeating => drive == Drive::Voltage,
        _ => false,
    }
}

/// The springs of the stages.
pub(super) fn tendons(model: &Model, lost: &mut Vec<String>) -> String {
    let (mut text, masses) = (String::new(), model.stages.len() + 1);
    for (k, stage) in model.stages.iter().enumerate() {
        let (number, place) = (k + 1, Location::Stage(k as u8 + 1));
        let sum = |kind, key: &str| {
            at(model, kind, place).filter_map(|effect| effect.get(key)).sum::<f64>()
        };
        let slack = sum(Kind::Backlash, "width_rad");
        let cubic = stage.cubic_stiffness_nm_per_rad3
            + sum(Kind::HardeningStiffness, "cubic_stiffness_nm_per_rad3");
        if stage.worm_friction_coefficient != 0.0 {
            lost.push(format!("stage {number}: the friction of its worm"));
        }
        if slack > 0.0 && stage.damping_nm_s_per_rad > 0.0 {
            lost.push(format!("stage {number}: that its damping ends where play begins"));
        }
        let cubic = if cubic == 0.0 { String::new() } else { format!(" 0 {cubic:?}") };
        let _ = write!(
            text,
            "    <fixed name=\"stage{number}_windup_rad\" stiffness=\"{:?}{cubic}\" damping=\"{:?}\" \
             springlength=\"{:?} {:?}\">\n      <joint joint=\"{}\" coef=\"{:?}\"/>\n      \
             <joint joint=\"{}\" coef=\"-1\"/>\n    </fixed>\n",
            stage.stiffness_nm_per_rad,
            stage.damping_nm_s_per_rad,
            -slack / 2.0,
            slack / 2.0,
            name(k, masses),
            1.0 / stage.reduction,
            name(k + 1, masses),
        );
    }
    text
}

/// The motor, friction, and what else acts with a memory.
pub(super) fn actuators(model: &Model, options: &DriveOptions, lost: &mut Vec<String>) -> String {
    let masses = model.stages.len() + 1;
    let mut text = motor(model, options, lost);
    for (k, friction) in frictions(model).enumerate() {
        // The rotor's is the motor's own where that is one.
        let own = if k == 0 && options.drive == Drive::Voltage { None } else { lugre(friction) };
        if let Some(own) = own {
            let mass = name(k, masses);
            passive(&mut text, &format!("{mass}_friction"), &format!("joint=\"{mass}\""), &own);
        }
    }
    // One of a kind stands in the motor itself; a second harmonic and further ones beside it.
    let coggings = coggings(model);
    let beside = if options.drive == Drive::Voltage { 1 } else { 0 };
    for (k, cogging) in coggings.iter().enumerate().skip(beside) {
        passive(&mut text, &format!("cogging{}", k + 1), "joint=\"rotor\"", cogging);
    }
    for effect in &model.effects {
        let value = |key| effect.get(key).unwrap_or(0.0);
        match (effect.kind, effect.location) {
            (Kind::StructuralHysteresis, Location::Stage(number)) => {
                let dahl = dahl(value("amplitude_nm"), value("width_rad"));
                let tendon = format!("tendon=\"stage{number}_windup_rad\"");
                passive(&mut text, &format!("stage{number}_hysteresis"), &tendon, &dahl);
            }
            (Kind::Coating, _) if value("hysteresis_nm") > 0.0 => {
                let dahl = dahl(value("hysteresis_nm"), value("width_rad"));
                let output = format!("joint=\"{}\"", name(masses - 1, masses));
                passive(&mut text, "coating", &output, &dahl);
            }
            _ => {}
        }
    }
    text
}

/// A `dcmotor` without input and without a winding.
fn passive(text: &mut String, name: &str, on: &str, what: &str) {
    let _ = writeln!(
        text,
        "    <dcmotor name=\"{name}\" {on} input=\"none\" motorconst=\"0 0\" resistance=\"1\" {what}/>"
    );
}

/// LuGre friction without its viscous part, which is the hinge's damping; `None` where there is none.
fn lugre(friction: &Friction) -> Option<String> {
    (friction.coulomb_nm > 0.0).then(|| {
        format!(
            "lugre=\"{:?} {:?} {:?} {:?} {:?}\"",
            friction.sigma0_nm_per_rad,
            friction.sigma1_nm_s_per_rad,
            friction.coulomb_nm,
            friction.coulomb_nm + friction.stribeck_nm,
            friction.stribeck_velocity_rad_per_s,
        )
    })
}

/// Torque that follows a displacement and stays behind it: a bristle of constant level.
fn dahl(amplitude: f64, width_rad: f64) -> String {
    format!("lugre=\"{:?} 0 {amplitude:?} {amplitude:?} 0\"", amplitude / width_rad)
}

/// Every harmonic of every cogging torque. Ours is subtracted, MuJoCo's added.
fn coggings(model: &Model) -> Vec<String> {
    let mut found = Vec::new();
    for effect in at(model, Kind::Cogging, Location::Motor) {
        let value = |key| effect.get(key).unwrap_or(0.0);
        for (times, amplitude, phase) in
            [(1.0, "amplitude_nm", "phase_rad"), (2.0, "second_amplitude_nm", "second_phase_rad")]
        {
            if value(amplitude) != 0.0 {
                found.push(format!(
                    "cogging=\"{:?} {:?} {:?}\"",
                    value(amplitude),
                    times * value("order"),
                    value(phase) + PI
                ));
            }
        }
    }
    found
}

/// The motor: a winding, or a torque in proportion to the current.
fn motor(model: &Model, options: &DriveOptions, lost: &mut Vec<String>) -> String {
    let motor = &model.motor;
    let constant = motor.torque_constant_nm_per_a;
    if options.drive == Drive::Current {
        let limit = options.current_limit_a;
        return format!(
            "    <general name=\"current_a\" joint=\"rotor\" gainprm=\"{constant:?}\" \
             ctrlrange=\"-{limit:?} {limit:?}\"/>\n"
        );
    }
    let (resistance, bus) = (2.0 * motor.phase_resistance_ohm, options.bus_v);
    let mut more = lugre(&motor.friction).into_iter().collect::<Vec<_>>();
    more.extend(coggings(model).into_iter().next());
    let heating: Vec<_> = at(model, Kind::WindingHeating, Location::Motor).collect();
    if let Some(effect) = heating.first() {
        let value = |key| effect.get(key).unwrap_or(0.0);
        // In units of the rise that the reference current gives: one kelvin stands for it.
        let rise = 1.0 / (resistance * value("reference_current_a").powi(2));
        more.push(format!(
            "thermal=\"{rise:?} 0 {:?} {:?} 0 0\"",
            value("time_constant_s"),
            value("relative_rise")
        ));
        lost.push(
            "winding-heating: that the heat is of the cold resistance; here it rises with it"
                .to_owned(),
        );
    }
    if heating.len() > 1 {
        lost.push("winding-heating: more than one of them".to_owned());
    }
    format!(
        "    <dcmotor name=\"voltage_v\" joint=\"rotor\" motorconst=\"{constant:?} {constant:?}\" \
         resistance=\"{resistance:?}\" inductance=\"{:?} 0\" {} ctrlrange=\"-{bus:?} {bus:?}\"/>\n",
        2.0 * motor.phase_inductance_h,
        more.join(" "),
    )
}
