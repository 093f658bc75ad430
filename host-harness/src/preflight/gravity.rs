//! A weight that the model does not have: torque that follows the output's angle, once a turn.

use joint_core::effect::Kind;

use super::torque_balance::{CERTAIN, Weight};
use super::unit::figure;
use super::{Case, Check, Finding};
use crate::plant::output_shaft;

pub(super) const CHECK: Check =
    Check { name: "gravity", compares: "torque against the output's angle", run };

/// A weight that is certain, and not in the model.
pub(super) fn lacking(case: &Case<'_>) -> Option<Weight> {
    let model = case.model;
    let held = |kind: Kind| model.effects.iter().any(|effect| effect.kind == kind);
    if model.load.gravity_nm != 0.0 || held(Kind::Gravity) || held(Kind::Coating) {
        return None;
    }
    let weight = case.balance.as_ref().and_then(|balance| balance.weight);
    // Below what is left otherwise it is one of many things that repeat with a turn.
    weight.filter(|weight| weight.stands_out(CERTAIN))
}

fn run(case: &Case<'_>) -> Vec<Finding> {
    let model = case.model;
    let Some(weight) = lacking(case) else { return Vec::new() };
    let (amplitude, error) = weight.amplitude();
    let shaft = output_shaft(model).abs();
    let phase = weight.cosine.0.atan2(weight.sine.0);
    let torque = figure(amplitude / shaft, error / shaft);
    vec![
        Finding::warning(format!(
            "torque follows the output's angle once a turn with {torque} Nm, and the model has no gravity"
        ))
        .help(format!(
            "if a weight hangs on it, give [load] gravity_nm = {torque}, gravity_phase_rad = {phase:.2}"
        )),
    ]
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::made::of;
    use super::*;
    use crate::demo::actuator;
    use crate::log::Log;
    use crate::model::Model;
    use crate::plant::{Inputs, ScalarKind, simulate};
    use joint_core::joint::Drive;

    /// An actuator without a gear, its current and its angle, over several turns to and fro.
    pub(in super::super) fn swinging(gravity_nm: f64) -> (Model, Log) {
        let mut model = actuator();
        model.stages.clear();
        model.load.inertia_kg_m2 = 2e-3;
        let bare = model.clone();
        model.load.gravity_nm = gravity_nm;
        model.load.gravity_phase_rad = 0.4;
        let time_s: Vec<f64> = (0..5000).map(|k| 1e-3 * f64::from(k)).collect();
        let current: Vec<f64> =
            time_s.iter().map(|t| 3.0 * (5.0 * t).sin() + 1.5 * (11.3 * t).cos()).collect();
        let inputs = Inputs {
            time_s: time_s.clone(),
            drive: Drive::Current,
            drive_values: current.clone(),
            load_nm: vec![0.0; 5000],
        };
        let run = simulate(&model, &inputs, ScalarKind::F64, None, None).unwrap();
        let motor_angle_rad = run.iter().map(|s| s.motor_angle_rad).collect();
        (bare, Log { time_s, current_a: Some(current), motor_angle_rad, ..Log::default() })
    }

    #[test]
    fn a_weight_that_the_model_lacks_is_told_with_its_torque_and_phase() {
        let (model, log) = swinging(0.1);
        let told = of(&CHECK, &model, &log);
        assert_eq!(told.len(), 1);
        let number = |key: &str| -> f64 {
            let rest = told[0].help.split(&format!("{key} = ")).nth(1).unwrap();
            rest.split([',', ' ']).next().unwrap().parse().unwrap()
        };
        // Bristles bias a regression that takes friction for a sign: 5 %.
        assert!((number("gravity_nm") / 0.1 - 1.0).abs() < 0.05, "{told:?}");
        assert!((number("gravity_phase_rad") - 0.4).abs() < 0.05, "{told:?}");
    }

    #[test]
    fn without_a_weight_nothing_is_told() {
        let (model, log) = swinging(0.0);
        assert_eq!(of(&CHECK, &model, &log), []);
    }
}
