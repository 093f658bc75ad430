//! The JSON schemas describe what is written, all of it, and refuse what is not.

#[path = "common/schema.rs"]
mod schema;

use std::path::Path;
use std::process::Command;

use serde_json::Value;

fn joint(folder: &Path, arguments: &str) {
    let output = Command::new(env!("CARGO_BIN_EXE_joint"))
        .args(arguments.split_whitespace())
        .current_dir(folder)
        .output()
        .unwrap();
    // A wrong answer is an answer.
    assert!(output.status.code() < Some(2), "{}", String::from_utf8_lossy(&output.stderr));
}

fn read(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

#[test]
fn verdicts_are_as_their_schema_says() {
    let folder = tempfile::tempdir().unwrap();
    joint(folder.path(), "demo --seed 7 --out found");
    let mut found = read(&folder.path().join("found/verdict.json"));
    schema::holds("verdict.json", &found);
    assert!(!found["effects"].as_array().unwrap().is_empty(), "nothing was looked at: {found}");
    // At rest a log tells nothing: the other end of what a verdict may be.
    let log = std::fs::read_to_string(folder.path().join("found/log.csv")).unwrap();
    let mut still = log.lines().next().unwrap().to_owned();
    for k in 0..1000 {
        let time = format!("\n{}", 2e-4 * f64::from(k));
        let columns = still.lines().next().unwrap().split(',').count();
        still += &format!("{time}{}", ",0.0".repeat(columns - 1));
    }
    std::fs::write(folder.path().join("still.csv"), still).unwrap();
    joint(
        folder.path(),
        "discover --model found/nominal.toml --log still.csv --out still --anyway",
    );
    let undecided = read(&folder.path().join("still/verdict.json"));
    assert_eq!(undecided["verdict"], "undecided", "{undecided}");
    schema::holds("verdict.json", &undecided);
    found["verdict"] = "perhaps".into();
    schema::refuses("verdict.json", &found);
    found.as_object_mut().unwrap().remove("verdict");
    schema::refuses("verdict.json", &found);
}

#[test]
fn scores_are_as_their_schema_says() {
    let folder = tempfile::tempdir().unwrap();
    joint(folder.path(), "score --simulate 3 --seed 5 --out scores");
    let mut scores = read(&folder.path().join("scores/score.json"));
    assert_eq!(scores["cases"].as_array().unwrap().len(), 3);
    schema::holds("score.json", &scores);
    scores["cases"][0]["seconds"] = "soon".into();
    schema::refuses("score.json", &scores);
}
