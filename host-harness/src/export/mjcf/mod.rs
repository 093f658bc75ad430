//! The joint as a MuJoCo model: what MuJoCo's own elements can say of it, and what they cannot.
//!
//! Every mass turns on a hinge of its own about one axis ([`masses`]); stages, motor and friction act on
//! the hinges ([`elements`]). MuJoCo knows LuGre friction since 3.7 and as a passive element since 4.0. What
//! is left out stands as a comment in the file, and is given back.

mod elements;
pub(super) mod masses;

use std::fmt::Write;

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
    let bodies = masses::masses(model, &mut lost);
    let count = bodies.len();
    let tendons = elements::tendons(model, &mut lost);
    let actuators = elements::actuators(model, options, &mut lost);
    for effect in &model.effects {
        if !elements::is_expressed(effect, options.drive) {
            let spec = effect.kind.spec();
            lost.push(format!("effect {} at {}", spec.kind, effect.location));
        }
    }
    let mut text = String::new();
    // Writing into a string does not fail. Euler steps LuGre's bristles, hinges' damping and the winding as
    // they are stiff, and comes closest to the reference.
    let _ = write!(
        text,
        "<!-- The joint {0}, by `joint export --format mjcf`, for MuJoCo 4.0 or later. SI units; every angle \
         at its own shaft.\n     {1}\n{2}-->\n\
         <mujoco model=\"{0}\">\n  <compiler angle=\"radian\" autolimits=\"true\"/>\n  \
         <option timestep=\"{3:.1e}\" integrator=\"Euler\" gravity=\"0 0 -{GRAVITY}\"/>\n  <worldbody>\n",
        identifier(model),
        if lost.is_empty() {
            "Nothing is left out."
        } else {
            "Left out, since MuJoCo has no such element:"
        },
        lost.iter()
            .map(|line| format!("       {}\n", line.replace("--", "- -")))
            .collect::<String>(),
        time_step(model, options),
    );
    for (k, mass) in bodies.iter().enumerate() {
        let name = masses::name(k, count);
        let [out, along] = mass.offset_m;
        let [viscous, square] = mass.damping;
        let square = if square == 0.0 { String::new() } else { format!(" {square:?}") };
        let [linear, cubic] = mass.stiffness;
        let spring = match linear == 0.0 && cubic == 0.0 {
            true => String::new(),
            false => format!(" stiffness=\"{linear:?} 0 {cubic:?}\""),
        };
        let _ = write!(
            text,
            "    <body name=\"{name}\" pos=\"0 {:?} 0\">\n      \
             <inertial pos=\"{out:?} 0 {along:?}\" mass=\"{:?}\" diaginertia=\"{2:?} {2:?} {2:?}\"/>\n      \
             <joint name=\"{name}\" type=\"hinge\" axis=\"0 -1 0\" damping=\"{viscous:?}{square}\"{spring}/>\n    \
             </body>\n",
            0.1 * k as f64,
            mass.mass_kg,
            mass.inertia_kg_m2,
        );
    }
    text.push_str("  </worldbody>\n");
    if !tendons.is_empty() {
        let _ = write!(text, "  <tendon>\n{tendons}  </tendon>\n");
    }
    let output = masses::name(count - 1, count);
    let windups: String = (1..count)
        .map(|number| {
            format!("    <tendonpos name=\"stage{number}_windup_rad\" tendon=\"stage{number}_windup_rad\"/>\n")
        })
        .collect();
    let _ = write!(
        text,
        "  <actuator>\n{actuators}    <motor name=\"load_torque\" joint=\"{output}\" gear=\"-1\"/>\n  \
         </actuator>\n  <sensor>\n    <jointpos name=\"motor_angle_rad\" joint=\"rotor\"/>\n    \
         <jointvel name=\"motor_speed_rad_per_s\" joint=\"rotor\"/>\n    \
         <jointpos name=\"output_angle_rad\" joint=\"{output}\"/>\n    \
         <jointvel name=\"output_speed_rad_per_s\" joint=\"{output}\"/>\n{windups}  </sensor>\n</mujoco>\n"
    );
    Mjcf { text, lost }
}

/// A step that resolves every spring between two masses and every bristle, and the springs' damping, which
/// is stepped explicitly; at most the control period.
fn time_step(model: &Model, options: &DriveOptions) -> f64 {
    let inertias = inertias(model);
    let (mut shaft, mut step) = (1.0, options.period_s);
    let mut resolves = |stiffness: f64, damping: f64, per_inertia: f64| {
        let rate = (stiffness * per_inertia).sqrt();
        step = step.min(0.1 / rate).min(0.2 / (damping * per_inertia));
    };
    for (k, friction) in masses::frictions(model).enumerate() {
        if let Some(stage) = k.checked_sub(1).and_then(|before| model.stages.get(before)) {
            shaft /= stage.reduction;
            let (own, both) = (shaft * shaft, 1.0 / inertias[k - 1] + 1.0 / inertias[k]);
            resolves(stage.stiffness_nm_per_rad * own, stage.damping_nm_s_per_rad * own, both);
        }
        let own = shaft * shaft / inertias[k];
        resolves(friction.sigma0_nm_per_rad, friction.sigma1_nm_s_per_rad, own);
    }
    // Two digits are enough, and rounded down.
    let unit = 10_f64.powf(step.log10().floor() - 1.0);
    (step / unit).floor() * unit
}
