//! `joint new` from outside: a datasheet becomes a model that the other verbs take.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use host_harness::model::Model;
use joint_core::effect::Kind;

/// A brushless motor of 40 mm with a planetary gear, its numbers as a catalogue prints them.
const MOTOR: &str = "--terminal-resistance 1.25 --terminal-inductance 0.56 --torque-constant 43.6 \
                     --speed-constant 219 --rotor-inertia 24.2 --no-load-current 145 \
                     --no-load-speed 5150 --nominal-voltage 24";

fn joint(folder: &Path, arguments: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_joint"))
        .args(arguments.split_whitespace())
        .current_dir(folder)
        .stdin(Stdio::null())
        .output()
        .unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// The model of these flags, what was told on standard error, and the file's text.
fn model(flags: &str) -> (Model, String, String) {
    let folder = tempfile::tempdir().unwrap();
    let output = joint(folder.path(), &format!("new {flags} --out arm.toml"));
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let path = folder.path().join("arm.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    (Model::read(&path).unwrap_or_else(|error| panic!("{error}")), stderr(&output), text)
}

/// Values in the file are rounded to six digits.
fn close(own: f64, expected: f64) {
    assert!((own / expected - 1.0).abs() < 5e-6, "{own} for {expected}");
}

#[test]
fn a_catalogues_numbers_become_those_of_the_model() {
    let gear =
        "--gear 624/35 --gear-efficiency 75 --gear-torque 6 --gear-backlash 0.8 --gear-inertia 0.8";
    let (model, told, text) = model(&format!(
        "{MOTOR} {gear} --pole-pairs 7 --motor-encoder 1024lines --load-inertia 0.02"
    ));
    assert_eq!(told, "", "the numbers fit each other");
    let motor = &model.motor;
    close(motor.phase_resistance_ohm, 0.625);
    close(motor.phase_inductance_h, 0.28e-3);
    close(motor.torque_constant_nm_per_a, 0.0436);
    close(motor.rotor_inertia_kg_m2, 2.5e-6);
    assert_eq!(motor.pole_pairs, 7);
    // Half of 0.0436 Nm/A times 0.145 A each, the second at 5150 rpm.
    close(motor.friction.coulomb_nm, 0.003161);
    let speed = 5150.0 * std::f64::consts::PI / 30.0;
    close(motor.friction.sigma2_nm_s_per_rad, 0.003161 / speed);
    let stage = &model.stages[0];
    assert_eq!(stage.reduction, 624.0 / 35.0, "in full");
    close(stage.stiffness_nm_per_rad, 6.0 / 5e-3);
    close(stage.friction.coulomb_nm, 0.5 * 0.25 * 6.0);
    close(model.sensor.motor_encoder_counts_per_rev, 4096.0);
    assert_eq!(model.effects[0].kind, Kind::Backlash);
    close(model.effects[0].values[0], 0.8_f64.to_radians());
    assert!(
        text.contains("# assumed: winds up by 5 mrad under the gear's continuous torque"),
        "{text}"
    );
    assert!(text.contains("# half of the terminal resistance"), "{text}");
}

/// Every line that no flag states says that it is assumed, and by what rule.
#[test]
fn what_the_datasheet_does_not_state_is_marked() {
    let (_, _, text) =
        model("--terminal-resistance 1.25 --torque-constant 43.6 --rotor-inertia 24.2 --gear 20");
    for key in [
        "phase_inductance_h",
        "coulomb_nm",
        "sigma0_nm_per_rad",
        "sigma1_nm_s_per_rad",
        "stribeck_nm",
        "stiffness_nm_per_rad",
        "damping_nm_s_per_rad",
    ] {
        let line = text.lines().find(|line| line.starts_with(key)).unwrap();
        assert!(line.contains("# assumed: "), "{line}");
    }
    for key in
        ["phase_resistance_ohm", "torque_constant_nm_per_a", "rotor_inertia_kg_m2", "reduction"]
    {
        let line = text.lines().find(|line| line.starts_with(key)).unwrap();
        assert!(line.contains('#') && !line.contains("assumed"), "{line}");
    }
}

#[test]
fn a_speed_constant_alone_gives_the_torque_constant() {
    let (model, ..) = model("--terminal-resistance 1.25 --speed-constant 219 --rotor-inertia 24.2");
    close(model.motor.torque_constant_nm_per_a, 30.0 / (std::f64::consts::PI * 219.0));
    assert!(model.stages.is_empty(), "a direct drive");
}

#[test]
fn under_field_oriented_control_the_peak_of_the_back_emf_counts() {
    let (model, ..) = model(
        "--terminal-resistance 1.25 --torque-constant 43.6 --rotor-inertia 24.2 --field-oriented",
    );
    close(model.motor.torque_constant_nm_per_a, 0.0436 * std::f64::consts::PI / 3.0);
}

/// The whole gear's wind-up is the sum of the stages', each brought to the output.
#[test]
fn several_stages_share_the_gears_stiffness() {
    let (model, ..) =
        model(&format!("{MOTOR} --gear 5 --gear -4 --gear-stiffness 900 --gear-torque 6"));
    let [first, second] = &model.stages[..] else { panic!("two stages") };
    assert_eq!((first.reduction, second.reduction), (5.0, -4.0));
    let at_output = first.stiffness_nm_per_rad * second.reduction.powi(2);
    close(1.0 / (1.0 / at_output + 1.0 / second.stiffness_nm_per_rad), 900.0);
}

#[test]
fn numbers_that_cannot_belong_to_one_motor_are_told() {
    let warned = |flags: &str| model(flags).1;
    let base = "--terminal-resistance 1.25 --rotor-inertia 24.2";
    let cases = [
        // A torque constant per peak ampere of a phase: 8.27 over the speed constant.
        (
            format!("{base} --torque-constant 37.8 --speed-constant 219"),
            "per peak ampere of a phase",
        ),
        (format!("{base} --torque-constant 53.4 --speed-constant 219"), "per RMS ampere"),
        (
            format!("{base} --torque-constant 0.0436 --speed-constant 219"),
            "is the torque constant in Nm/A",
        ),
        (
            format!("{base} --torque-constant 50 --speed-constant 219"),
            "disagree: their product is 1.14",
        ),
        (
            format!("{base} --torque-constant 43.6 --terminal-inductance 560"),
            "electrical time constant L/R is 448",
        ),
        (
            "--terminal-resistance 1.25 --torque-constant 43.6 --rotor-inertia 24200".to_owned(),
            "mechanical time constant",
        ),
        (format!("{MOTOR} --mechanical-time-constant 3.2"), "the sheet has 3.2 ms"),
        (MOTOR.replace("5150", "9000"), "no-load speed that follows"),
        (MOTOR.replace("145", "145A"), "no-load current is"),
        (format!("{MOTOR} --load-inertia 500"), "load's inertia is"),
    ];
    for (flags, told) in cases {
        assert!(warned(&flags).contains(told), "{flags}: {}", warned(&flags));
    }
    assert_eq!(warned(&format!("{MOTOR} --mechanical-time-constant 1.59")), "");
}

#[test]
fn what_is_missing_is_listed_and_bad_numbers_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |flags: &str| {
        let output = joint(folder.path(), &format!("new {flags} --out arm.toml"));
        assert_eq!(output.status.code(), Some(2), "{flags}");
        assert!(!folder.path().join("arm.toml").exists(), "{flags}");
        stderr(&output)
    };
    let all = refused("");
    for flag in ["--terminal-resistance", "--torque-constant", "--rotor-inertia"] {
        assert!(all.contains(&format!("\n  {flag}  ")), "{all}");
    }
    let one = refused("--terminal-resistance 1 --speed-constant 100");
    assert!(one.contains("--rotor-inertia") && !one.contains("--torque-constant"), "{one}");
    for (flags, told) in [
        ("--terminal-resistance 0", "must be a number above zero"),
        ("--terminal-resistance 1kg", "unknown unit `kg`: write one of ohm"),
        ("--rotor-inertia many", "many"),
        ("--gear 5/0", "write 16, 624/35 or 4.8:1"),
        ("--gear 5 --gear-efficiency 120", "no efficiency"),
        ("--gear-efficiency 80", "--gear <RATIO>"),
        ("--pole-pairs 0", "--pole-pairs"),
    ] {
        let told_is = refused(flags);
        assert!(told_is.contains(told), "{flags}: {told_is}");
    }
}

#[test]
fn an_earlier_model_stays_and_json_lists_what_is_assumed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm.toml");
    std::fs::write(&path, "mine").unwrap();
    assert_eq!(joint(folder.path(), &format!("new {MOTOR} --out arm.toml")).status.code(), Some(2));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
    let output = joint(folder.path(), &format!("new {MOTOR} --out arm.toml --force --json"));
    let object: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(object["model"], "arm");
    let assumed = object["assumed"].as_array().unwrap();
    assert!(assumed.contains(&"[motor.friction] sigma0_nm_per_rad".into()), "{object}");
}
