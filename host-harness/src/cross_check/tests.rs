//! The drive's step against the reference: how near, and with which effects.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::joint::Drive;
use joint_core::params::Location;

use super::*;
use crate::scenario::{ALL, paper};

fn errors(model: &Model, scenario: &Scenario, scalar: ScalarKind, step_s: f64) -> Vec<f64> {
    let inputs = scenario.inputs();
    let exact = reference::simulate(model, &inputs, &Options::default()).unwrap();
    let run = plant::simulate(model, &inputs, scalar, Some(step_s), None).unwrap();
    let all = Quantity::of(model.stages.len()).into_iter();
    all.map(|quantity| quantity.relative_rms(&exact, &run)).collect()
}

fn worst(errors: &[f64]) -> f64 {
    errors.iter().copied().fold(0.0, f64::max)
}

#[test]
fn a_running_joint_in_f32_at_a_drive_step_stays_within_one_per_cent() {
    for scenario in [ALL[0], ALL[2]] {
        let error = worst(&errors(&paper(), &scenario, ScalarKind::F32, 50e-6));
        assert!(error < 0.01, "{}: {error}", scenario.name);
    }
}

/// As [`bound`] has it for their number; a guard of the method's order, which the joint's own choice of
/// five would hide.
#[test]
fn fewer_micro_steps_than_the_joint_chooses_cost_a_bound_only_across_breakaway() {
    let model = paper();
    for scenario in ALL {
        let inputs = scenario.inputs();
        let exact = reference::simulate(&model, &inputs, &Options::default()).unwrap();
        let holds = |micro_steps| {
            let (scalar, step) = (ScalarKind::F32, Some(50e-6));
            let run = plant::simulate(&model, &inputs, scalar, step, Some(micro_steps)).unwrap();
            Quantity::of(model.stages.len()).into_iter().all(|quantity| {
                let most = bound(50.0, micro_steps, quantity).unwrap();
                quantity.relative_rms(&exact, &run) <= most
            })
        };
        let wiggle = scenario.name == ALL[5].name;
        assert_eq!([1, 2].map(holds), [!wiggle, true], "{}", scenario.name);
    }
}

#[test]
fn forced_micro_steps_are_a_study_that_has_no_bound_and_breaks_none() {
    let row = |micro_steps, chosen, bound| Row {
        scenario: "wiggle",
        method: if chosen { CHOSEN } else { "embedded-forced-1" },
        scalar: "f32",
        step_us: 50.0,
        state: "stage1_speed".to_owned(),
        relative_rms: 0.05,
        bound,
        micro_steps,
        chosen,
    };
    let mut check = CrossCheck { rows: vec![row(1, false, None)], speed: None };
    assert!(check.passed() && check.to_string().contains(" study  stage1_speed"), "{check}");
    check.rows.push(row(5, true, Some(0.01)));
    assert!(!check.passed() && check.to_string().contains("1 of 2 rows break"), "{check}");
}

#[test]
fn the_step_converges_to_the_reference_across_reversals() {
    let wiggle = ALL[5].lasting(0.03);
    let error = |step| worst(&errors(&paper(), &wiggle, ScalarKind::F64, step));
    let (coarse, fine) = (error(10e-6), error(1e-6));
    // At least first order, where friction has its corner.
    assert!(fine < 0.2 * coarse && fine < 2e-3, "{coarse} then {fine}");
}

#[test]
fn every_effect_is_the_same_in_the_step_and_in_the_reference() {
    for kind in Kind::ALL {
        let model = Model { effects: vec![EffectParameters::example(*kind)], ..paper() };
        let name = kind.spec().kind;
        let loaded = worst(&errors(&model, &ALL[2], ScalarKind::F64, 50e-6));
        assert!(loaded < 0.02, "{name} on a running joint: {loaded}");
        // With the step the difference goes, so both hold the same law.
        let reversing = ALL[1].lasting(0.05);
        let fine = worst(&errors(&model, &reversing, ScalarKind::F64, 5e-6));
        assert!(fine < 4e-3, "{name} across a reversal: {fine}");
    }
}

/// A limit of a fifth of the stall current, alone and beside what changes the voltage, the constants and the
/// friction.
#[test]
fn a_limit_of_the_current_keeps_a_drive_step_within_one_per_cent() {
    let limit = EffectParameters::new(Kind::CurrentLimit, Location::Inverter).with("limit_a", 0.02);
    let beside = [Kind::TorqueRipple, Kind::DeadTime, Kind::DriveEfficiency];
    let pairs = beside.map(|kind| vec![limit, EffectParameters::example(kind)]);
    for effects in [vec![limit]].into_iter().chain(pairs) {
        let model = Model { effects, ..paper() };
        let scenario = ALL[0].lasting(0.05);
        let exact = reference::simulate(&model, &scenario.inputs(), &Options::default()).unwrap();
        let plain = reference::simulate(&paper(), &scenario.inputs(), &Options::default()).unwrap();
        let moved = Quantity::MotorSpeed.relative_rms(&plain, &exact);
        assert!(moved > 0.1, "the limit is not reached: {moved}");
        let error = worst(&errors(&model, &scenario, ScalarKind::F32, 50e-6));
        let kinds: Vec<Kind> = model.effects.iter().map(|effect| effect.kind).collect();
        assert!(error < 0.01, "{kinds:?}: {error}");
    }
}

#[test]
fn a_model_with_an_effect_is_checked_along_a_log() {
    let mut model = crate::demo::actuator();
    let line = EffectParameters::new(Kind::Cogging, Location::Motor);
    model.effects.push(line.with("order", 42.0).with("amplitude_nm", 0.01));
    let inputs = Inputs {
        time_s: (0..400).map(|k| f64::from(k) * 1e-4).collect(),
        drive: Drive::Voltage,
        drive_values: (0..400).map(|k| if k % 200 < 100 { 3.0 } else { -2.0 }).collect(),
        load_nm: vec![0.0; 400],
    };
    let check = along(&model, &inputs).unwrap();
    assert!(check.passed(), "{check}");
    let single = |row: &&Row| row.scalar == "f32" && row.step_us <= 50.0;
    assert!(check.rows.iter().filter(single).all(|row| row.relative_rms < 1e-3), "{check}");
    let plain = Model { effects: Vec::new(), ..model.clone() };
    let speed = |model: &Model| plant::simulate(model, &inputs, ScalarKind::F64, None, None);
    assert!(speed(&model).unwrap() != speed(&plain).unwrap());
}
