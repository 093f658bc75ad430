//! Forty drawn joints and what is answered of each, as a table that is kept: a change of any rule of the
//! search shows there. It takes minutes, so `./check` asks for it by name.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

const DRAWS: &str = "40";
const SEED: &str = "40";

/// A row a draw: what is hidden, the answer, the names, and whether that is right.
fn table(score: &Value) -> String {
    let words = |value: &Value| -> Vec<String> {
        let all = value.as_array().into_iter().flatten();
        all.filter_map(Value::as_str).map(str::to_owned).collect()
    };
    let list = |all: Vec<String>| if all.is_empty() { "–".to_owned() } else { all.join(", ") };
    let mut text = String::new();
    for case in score["cases"].as_array().unwrap() {
        let right = if case["right"] == true { "right" } else { "wrong" };
        let _ = writeln!(
            text,
            "{} | {} | {} | {} | {right}",
            case["case"].as_str().unwrap(),
            list(words(&case["hidden"])),
            case["verdict"].as_str().unwrap(),
            list(words(&case["names"]))
        );
    }
    text
}

#[test]
#[ignore = "takes minutes"]
fn forty_draws_are_answered_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_joint"))
        .args(["score", "--simulate", DRAWS, "--seed", SEED, "--out", "scores", "--json"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let told = table(&serde_json::from_slice(&output.stdout).unwrap());
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/snapshots/draws.txt");
    if std::env::var_os("JOINT_SNAPSHOT").is_some_and(|value| value == "write") {
        std::fs::write(&path, &told).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap();
    assert_eq!(told.lines().count(), kept.lines().count());
    let differing = told.lines().zip(kept.lines()).filter(|(now, kept)| now != kept);
    let differing: Vec<_> =
        differing.inspect(|(now, kept)| println!("{now}\nwas {kept}")).collect();
    // Sines are of other last bits on another processor, which may tip one draw that lies on the edge.
    let renew = "renew tests/snapshots/draws.txt with JOINT_SNAPSHOT=write";
    assert!(differing.len() <= 1, "{} rows differ: {renew}", differing.len());
}
