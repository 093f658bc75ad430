//! The joint as a MuJoCo model: what MuJoCo's own elements can say of it, and what they cannot.
//!
//! Every mass turns on a hinge of its own about one axis. A gear stage is a spring on the fixed
//! tendon `η q_in − q_out`, which is the stage's own law as long as it is linear; play is the
//! tendon's slack. Coulomb and viscous friction are the hinge's `frictionloss` and `damping`. What
//! is left out stands as a comment in the file, and is given back.

use std::fmt::Write;

use joint_core::effect::Kind;
use joint_core::joint::Drive;
use joint_core::params::{Friction, Location, Stage};

use super::{DriveOptions, identifier};
use crate::model::Model;
use crate::plant::inertias;

/// Acceleration of gravity, m/s²: it cancels in the pendulum that stands for the load's gravity.
const GRAVITY: f64 = 9.81;

/// A MuJoCo model, and what it leaves out of the joint's.
#[derive(Clone, Debug, PartialEq)]
pub struct Mjcf {
    /// The file's text.
    pub text: String,
    /// What is lost, one line each.
    pub lost: Vec<String>,
}

/// The MuJoCo model.
pub fn mjcf(model: &Model, options: &DriveOptions) -> Mjcf {
    let mut lost = Vec::new();
    let masses = masses(model, &mut lost);
    let (tendons, loads) = (tendons(model, &mut lost), masses.len());
    let motor = actuator(model, options, &mut lost);
    for effect in &model.effects {
        if !matches!(effect.kind, Kind::Backlash | Kind::Gravity) {
            let spec = effect.kind.spec();
            lost.push(format!("effect {} at {}", spec.kind, effect.location));
        }
    }
    // Friction as stiff as MuJoCo's solver admits: at its default the small masses of a gear slide
    // without ever reaching their Coulomb level.
    let step = time_step(model, options);
    let mut text = String::new();
    // Writing into a string does not fail.
    let _ = write!(
        text,
        "<!-- The joint {0}, by `joint export --format mjcf`. SI units; every angle at its own \
         shaft.\n     Left out, since MuJoCo has no such element:\n{1}-->\n\
         <mujoco model=\"{0}\">\n  <compiler angle=\"radian\" autolimits=\"true\"/>\n  \
         <option timestep=\"{2:e}\" integrator=\"{3}\" gravity=\"0 0 -{GRAVITY}\"/>\n  <worldbody>\n",
        identifier(model),
        lost.iter()
            .map(|line| format!("       {}\n", line.replace("--", "- -")))
            .collect::<String>(),
        step,
        if tendons.is_empty() { "implicitfast" } else { "implicit" },
    );
    for (k, mass) in masses.iter().enumerate() {
        let name = name(k, loads);
        let [out, along] = mass.offset_m;
        let _ = write!(
            text,
            "    <body name=\"{name}\" pos=\"0 {:?} 0\">\n      \
             <inertial pos=\"{out:?} 0 {along:?}\" mass=\"{:?}\" diaginertia=\"{2:?} {2:?} {2:?}\"/>\n      \
             <joint name=\"{name}\" type=\"hinge\" axis=\"0 -1 0\" damping=\"{3:?}\" \
             frictionloss=\"{4:?}\" solreffriction=\"{5:e} 1\"/>\n    </body>\n",
            0.1 * k as f64,
            mass.mass_kg,
            mass.inertia_kg_m2,
            mass.damping,
            mass.coulomb_nm,
            2.0 * step,
        );
    }
    text.push_str("  </worldbody>\n");
    if !tendons.is_empty() {
        let _ = write!(text, "  <tendon>\n{tendons}  </tendon>\n");
    }
    let output = name(loads - 1, loads);
    let _ = write!(
        text,
        "  <actuator>\n{motor}    <motor name=\"load_torque\" joint=\"{output}\" gear=\"-1\"/>\n  \
         </actuator>\n  <sensor>\n    <jointpos name=\"motor_angle_rad\" joint=\"rotor\"/>\n    \
         <jointvel name=\"motor_speed_rad_per_s\" joint=\"rotor\"/>\n    \
         <jointpos name=\"output_angle_rad\" joint=\"{output}\"/>\n    \
         <jointvel name=\"output_speed_rad_per_s\" joint=\"{output}\"/>\n  </sensor>\n</mujoco>\n"
    );
    Mjcf { text, lost }
}

/// A body that turns about its hinge.
struct Mass {
    mass_kg: f64,
    /// Of its own centre from the axis, x and z at angle zero.
    offset_m: [f64; 2],
    /// About its own centre.
    inertia_kg_m2: f64,
    damping: f64,
    coulomb_nm: f64,
}

fn name(mass: usize, masses: usize) -> String {
    match mass {
        0 => "rotor".to_owned(),
        k if k + 1 == masses => "output".to_owned(),
        k => format!("stage{k}"),
    }
}

fn masses(model: &Model, lost: &mut Vec<String>) -> Vec<Mass> {
    let mut shaft = 1.0;
    let mut masses = Vec::new();
    for (k, reflected) in inertias(model).into_iter().enumerate() {
        let friction = match k.checked_sub(1).and_then(|stage| model.stages.get(stage)) {
            None => &model.motor.friction,
            Some(stage) => {
                shaft /= stage.reduction;
                &stage.friction
            }
        };
        lose_friction(friction, k, lost);
        masses.push(Mass {
            mass_kg: 1e-3,
            offset_m: [0.0; 2],
            inertia_kg_m2: reflected / (shaft * shaft),
            damping: friction.sigma2_nm_s_per_rad,
            coulomb_nm: friction.coulomb_nm,
        });
    }
    let last = masses.len() - 1;
    for [gravity_nm, phase] in gravities(model, last) {
        hang(&mut masses[last], gravity_nm, phase, lost);
    }
    masses
}

/// Amplitude and phase of what pulls on the last mass.
fn gravities(model: &Model, last: usize) -> Vec<[f64; 2]> {
    let own = [model.load.gravity_nm, model.load.gravity_phase_rad];
    let found = model.effects.iter().filter(|effect| {
        effect.kind == Kind::Gravity && (last == 0 || effect.location == Location::Output)
    });
    let (mut sine, mut cosine) = (own[0] * own[1].sin(), own[0] * own[1].cos());
    for effect in found {
        let amplitude = effect.get("amplitude_nm").unwrap_or(0.0);
        let phase = effect.get("phase_rad").unwrap_or(0.0);
        sine += amplitude * phase.sin();
        cosine += amplitude * phase.cos();
    }
    let amplitude = sine.hypot(cosine);
    if amplitude == 0.0 { vec![] } else { vec![[amplitude, sine.atan2(cosine)]] }
}

/// A pendulum of this torque, of the same inertia about the hinge.
fn hang(mass: &mut Mass, gravity_nm: f64, phase: f64, lost: &mut Vec<String>) {
    // Half of the inertia is the offset's: m g l is the torque, and m l² that half.
    let arm = 0.5 * mass.inertia_kg_m2 * GRAVITY / gravity_nm;
    if !(arm.is_finite() && arm > 0.0) {
        lost.push("gravity: there is no inertia for it to act on".to_owned());
        return;
    }
    mass.mass_kg = gravity_nm / (GRAVITY * arm);
    mass.inertia_kg_m2 *= 0.5;
    mass.offset_m = [arm * phase.sin(), -arm * phase.cos()];
}

fn lose_friction(friction: &Friction, mass: usize, lost: &mut Vec<String>) {
    if friction.coulomb_nm > 0.0 {
        lost.push(format!(
            "mass {mass} (0 is the rotor): presliding stiffness sigma0 and damping sigma1 of LuGre \
             friction; MuJoCo's friction creeps in stick"
        ));
    }
    if friction.stribeck_nm > 0.0 {
        lost.push(format!(
            "mass {mass}: the Stribeck excess of {} Nm at standstill",
            friction.stribeck_nm
        ));
    }
}

fn tendons(model: &Model, lost: &mut Vec<String>) -> String {
    let (mut text, masses) = (String::new(), model.stages.len() + 1);
    for (k, stage) in model.stages.iter().enumerate() {
        let slack: f64 = model
            .effects
            .iter()
            .filter(|effect| {
                effect.kind == Kind::Backlash && effect.location == Location::Stage(k as u8 + 1)
            })
            .filter_map(|effect| effect.get("width_rad"))
            .sum();
        lose_stage(stage, k + 1, slack, lost);
        let _ = write!(
            text,
            "    <fixed name=\"stage{}_windup_rad\" stiffness=\"{:?}\" damping=\"{:?}\" \
             springlength=\"{:?} {:?}\">\n      <joint joint=\"{}\" coef=\"{:?}\"/>\n      \
             <joint joint=\"{}\" coef=\"-1\"/>\n    </fixed>\n",
            k + 1,
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

fn lose_stage(stage: &Stage, number: usize, slack: f64, lost: &mut Vec<String>) {
    if stage.cubic_stiffness_nm_per_rad3 != 0.0 {
        let cubic = stage.cubic_stiffness_nm_per_rad3;
        lost.push(format!("stage {number}: its cubic stiffness of {cubic} Nm/rad3"));
    }
    if stage.worm_friction_coefficient != 0.0 {
        lost.push(format!("stage {number}: the friction of its worm"));
    }
    if slack > 0.0 && stage.damping_nm_s_per_rad > 0.0 {
        lost.push(format!("stage {number}: that its damping ends where play begins"));
    }
}

/// The motor: its torque from the voltage less the back-EMF, or from the current.
fn actuator(model: &Model, options: &DriveOptions, lost: &mut Vec<String>) -> String {
    let motor = &model.motor;
    let constant = motor.torque_constant_nm_per_a;
    if options.drive == Drive::Current {
        let limit = options.current_limit_a;
        return format!(
            "    <general name=\"current_a\" joint=\"rotor\" gainprm=\"{constant:?}\" \
             ctrlrange=\"-{limit:?} {limit:?}\"/>\n"
        );
    }
    let resistance = 2.0 * motor.phase_resistance_ohm;
    let back_emf =
        motor.phase_back_emf_constant_v_s_per_rad.map_or(constant, |constant| 2.0 * constant);
    let lag = motor.phase_inductance_h / motor.phase_resistance_ohm;
    let dynamics = if lag > 0.0 {
        lost.push("that the back-EMF acts through the inductance: here it acts at once".to_owned());
        format!("dyntype=\"filterexact\" dynprm=\"{lag:?}\" ")
    } else {
        String::new()
    };
    let bus = options.bus_v;
    format!(
        "    <general name=\"voltage_v\" joint=\"rotor\" {dynamics}gainprm=\"{:?}\" \
         biastype=\"affine\" biasprm=\"0 0 {:?}\" ctrlrange=\"-{bus:?} {bus:?}\"/>\n",
        constant / resistance,
        -constant * back_emf / resistance,
    )
}

/// A step that resolves the stiffest spring between two masses, at most the control period.
fn time_step(model: &Model, options: &DriveOptions) -> f64 {
    let inertias = inertias(model);
    let (mut shaft, mut step) = (1.0, options.period_s);
    for (k, stage) in model.stages.iter().enumerate() {
        shaft /= stage.reduction;
        let stiffness = stage.stiffness_nm_per_rad * shaft * shaft;
        let rate = (stiffness * (1.0 / inertias[k] + 1.0 / inertias[k + 1])).sqrt();
        step = step.min(0.1 / rate);
    }
    // Two digits are enough, and rounded down.
    let unit = 10_f64.powf(step.log10().floor() - 1.0);
    (step / unit).floor() * unit
}
