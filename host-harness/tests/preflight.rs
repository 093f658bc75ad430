//! The pre-flight from outside: what is stopped, what is let pass, and with which words.

use std::path::Path;
use std::process::{Command, Output};

use host_harness::demo::riddle;
use host_harness::log::Log;
use host_harness::model::Model;
use host_harness::preflight::{self, Severity};
use host_harness::score::blind;
use host_harness::score::wide::{self, Rigs};

fn joint(folder: &Path, arguments: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_joint"))
        .args(arguments.split_whitespace())
        .current_dir(folder)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// A folder with a model and 0.8 s of a log of it, both changed.
fn folder(change: impl Fn(&mut Model, &mut Log)) -> tempfile::TempDir {
    let mut riddle = riddle(2).unwrap();
    let first: Vec<bool> = (0..riddle.log.len()).map(|k| k < 4000).collect();
    riddle.log = riddle.log.only(&first);
    change(&mut riddle.nominal, &mut riddle.log);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.toml"), riddle.nominal.to_toml()).unwrap();
    std::fs::write(folder.path().join("l.csv"), riddle.log.to_csv()).unwrap();
    folder
}

/// The number behind these words.
fn number(text: &str, words: &str) -> f64 {
    let rest = text.split(words).nth(1).unwrap_or_else(|| panic!("no `{words}` in {text}"));
    rest.trim_start().split([' ', ',', '\n']).next().unwrap().parse().unwrap()
}

#[test]
fn a_sound_log_passes_and_its_measured_ratio_is_told() {
    let folder = folder(|_, _| {});
    let output = joint(folder.path(), "check --model m.toml --log l.csv");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stdout));
    // What is allowed to be off: half a per cent.
    let ratio = number(&text(&output.stdout), "gear ratio ");
    assert!((ratio / 9.0 - 1.0).abs() < 0.005, "{ratio}");
    let output = joint(folder.path(), "check --model m.toml --log l.csv --json");
    let object: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(object["errors"], 0);
    assert!(object["logs"][0]["excitation"]["reversals"].as_u64().unwrap() > 3);
}

#[test]
fn a_wrong_ratio_stops_every_fit_until_it_is_told_to_go_on() {
    let folder = folder(|model, _| model.stages[0].reduction *= 1.05);
    let told = "l.csv: output_angle_rad and motor_angle_rad make a gear ratio of";
    let output = joint(folder.path(), "check --model m.toml --log l.csv");
    assert_eq!(output.status.code(), Some(1));
    let ratio = number(&text(&output.stdout), told);
    assert!((ratio / 9.0 - 1.0).abs() < 0.005, "{ratio}");
    for verb in ["discover", "identify"] {
        let output = joint(folder.path(), &format!("{verb} --model m.toml --log l.csv --out o"));
        assert_eq!(output.status.code(), Some(2), "{verb}");
        assert!(text(&output.stderr).contains(told), "{}", text(&output.stderr));
        assert!(text(&output.stderr).contains("--anyway"), "{}", text(&output.stderr));
        assert!(!folder.path().join("o").exists());
    }
    let output = joint(folder.path(), "identify --model m.toml --log l.csv --out o --anyway");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains(&format!("warning: {told}")), "{}", text(&output.stderr));
}

#[test]
fn one_impossible_sample_is_told_by_file_and_line() {
    let folder = folder(|_, log| log.voltage_v.as_mut().unwrap()[1000] = 1e6);
    let output = joint(folder.path(), "discover --model m.toml --log l.csv --out o");
    assert_eq!(output.status.code(), Some(2));
    // A header, and rows from the second line on.
    assert!(
        text(&output.stderr).starts_with("error: l.csv:1002: u_v = 1e6"),
        "{}",
        text(&output.stderr)
    );
}

/// What would be stopped of a drawn joint's logs.
fn stopped(nominal: &Model, logs: &[Log]) -> Vec<String> {
    let found = logs.iter().flat_map(|log| preflight::findings(nominal, log));
    found.filter(|f| f.severity == Severity::Error).map(|f| f.message).collect()
}

#[test]
fn no_drawn_joint_is_stopped_whatever_it_hides() {
    for number in 0..16 {
        let trial = blind::trial(41, number).unwrap();
        assert_eq!(stopped(&trial.nominal, &trial.logs), Vec::<String>::new(), "{number}");
    }
    for number in 0..4 {
        let trial = wide::trial(41, number, Rigs::All).unwrap();
        assert_eq!(stopped(&trial.nominal, &trial.logs), Vec::<String>::new(), "wide {number}");
    }
}
