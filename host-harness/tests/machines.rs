//! `joint machines` from outside: two made machines, one with another record.

use std::path::Path;
use std::process::Command;

use host_harness::demo::actuator;
use host_harness::model::Model;
use host_harness::synthetic::{Experiment, record};
use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

fn put(folder: &Path, truth: &Model, names: &[&str]) {
    std::fs::create_dir_all(folder.join("transfer")).unwrap();
    let nominal = Model { effects: Vec::new(), ..truth.clone() };
    std::fs::write(folder.join("nominal.toml"), nominal.to_toml()).unwrap();
    for (seed, name) in names.iter().enumerate() {
        let experiment = Experiment { duration_s: 0.6, ..Experiment::default() };
        let log = record(truth, &experiment, seed as u64).unwrap();
        std::fs::write(folder.join(name), log.to_csv()).unwrap();
    }
}

#[test]
fn each_machine_is_told_with_what_it_hides_and_with_its_other_records() {
    let folder = tempfile::tempdir().unwrap();
    let mut plain = actuator();
    plain.stages.clear();
    let mut cogged_joint = plain.clone();
    let cogging = EffectParameters::new(Kind::Cogging, Location::Motor);
    cogged_joint.effects.push(cogging.with("order", 42.0).with("amplitude_nm", 0.02));
    put(&folder.path().join("set/cogged"), &cogged_joint, &["log.csv", "transfer/other.csv"]);
    put(&folder.path().join("set/plain"), &plain, &["one.csv", "two.csv"]);

    let joint = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_joint"));
        command.args(arguments).current_dir(folder.path()).output().unwrap()
    };
    let output = joint(&["machines", "set", "--out", "told", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let [cogged, plain] = [&json["machines"][0], &json["machines"][1]];
    assert_eq!(cogged["machine"], "cogged");
    assert_eq!(cogged["verdict"]["effects"][0]["kind"], "cogging", "{cogged}");
    assert_eq!(plain["verdict"]["verdict"], "adequate", "{plain}");
    let runs = &cogged["transfer"][0];
    let error = |model: &str| runs[model]["signals"][0]["free_run"]["rms"].as_f64().unwrap();
    assert!(error("improved") < error("refitted"), "{runs}");
    let table = std::fs::read_to_string(folder.path().join("told/machines.md")).unwrap();
    assert!(table.contains("| cogged | other | motor_angle_rad |"), "{table}");
    assert!(folder.path().join("told/plain/report.html").is_file());

    let refused = joint(&["machines", "set", "--only", "third", "--out", "none"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("there are cogged, plain"));
}
