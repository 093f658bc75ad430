//! `joint identify` from outside: several logs, and what a refit by simulation writes.

use std::path::Path;
use std::process::{Command, Output};

use host_harness::demo::actuator;
use host_harness::model::Model;
use host_harness::synthetic::{Experiment, record};
use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

fn joint(folder: &Path, arguments: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_joint"));
    command.args(arguments.split_whitespace()).current_dir(folder).output().unwrap()
}

/// A motor with a drag, two logs of it, and a nominal with another inertia and half the drag.
fn folder() -> (tempfile::TempDir, f64) {
    let folder = tempfile::tempdir().unwrap();
    let mut truth = actuator();
    truth.stages.clear();
    let drag = 4e-6;
    let effect = |size: f64| {
        EffectParameters::new(Kind::QuadraticDrag, Location::Motor).with("coefficient_nm_s2", size)
    };
    truth.effects.push(effect(drag));
    for (name, seed) in [("a.csv", 3), ("b.csv", 4)] {
        let log = record(&truth, &Experiment { duration_s: 1.0, ..Experiment::default() }, seed);
        std::fs::write(folder.path().join(name), log.unwrap().to_csv()).unwrap();
    }
    let mut nominal = truth.clone();
    nominal.motor.rotor_inertia_kg_m2 *= 1.08;
    nominal.effects[0] = effect(0.5 * drag);
    std::fs::write(folder.path().join("m.toml"), nominal.to_toml()).unwrap();
    (folder, drag)
}

#[test]
fn a_refit_by_simulation_of_two_logs_runs_nearer_and_moves_the_models_effects() {
    let (folder, drag) = folder();
    let output = joint(
        folder.path(),
        "identify -m m.toml -l a.csv b.csv -o refit --criterion simulation --window-s 0.25 --json",
    );
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    // Two logs of a second.
    assert_eq!(json["simulation"]["windows"], 8);
    let angle = &json["simulation"]["rms_error"]["motor_angle_rad"];
    let [before, after] = [0, 1].map(|k| angle[k].as_f64().unwrap());
    assert!(after <= before, "{before} {after}");
    let refitted = Model::read(&folder.path().join("refit/model.toml")).unwrap();
    let found = refitted.effects[0].values[0];
    assert!((found / drag - 1.0).abs() < 0.25, "{found}");
}

#[test]
fn a_window_without_a_length_is_refused() {
    let (folder, _) = folder();
    let output = joint(folder.path(), "identify -m m.toml -l a.csv -o refit --window-s 0");
    assert_eq!(output.status.code(), Some(2));
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(
        told.contains("--window-s") && told.contains("a length in seconds above zero"),
        "{told}"
    );
    assert!(!folder.path().join("refit").exists());
}
