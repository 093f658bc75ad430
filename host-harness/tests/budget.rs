//! What the step costs on a chip stays within `budgets.toml`, and that of any model is told.

#[path = "common/schema.rs"]
mod schema;

use std::process::Command;

use host_harness::demo;
use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use joint_tests::qemu;

#[test]
fn no_row_is_past_its_budget() {
    if !qemu::available("no_row_is_past_its_budget") {
        return;
    }
    let output = Command::new(env!("CARGO_BIN_EXE_joint")).arg("budget").output().unwrap();
    let table = String::from_utf8_lossy(&output.stdout);
    println!("{table}");
    assert!(output.status.success(), "{table}{}", String::from_utf8_lossy(&output.stderr));
    let output =
        Command::new(env!("CARGO_BIN_EXE_joint")).args(["budget", "--json"]).output().unwrap();
    let mut costs: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    schema::holds("budget.json", &costs);
    costs["flash_bytes"] = "little".into();
    schema::refuses("budget.json", &costs);
}

#[test]
fn an_effect_has_a_price_on_the_chip() {
    if !qemu::available("an_effect_has_a_price_on_the_chip") {
        return;
    }
    let mut model = demo::actuator();
    let line = EffectParameters::new(Kind::Cogging, Location::Motor);
    model.effects.push(line.with("order", 42.0).with("amplitude_nm", 0.01));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.toml");
    std::fs::write(&path, model.to_toml()).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_joint"));
    let output = command.args(["budget", "--json", "--model"]).arg(&path).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let rows: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let count = |name: &str| rows[name].as_u64().unwrap();
    let [with, without] = [count("step_instructions"), count("step_instructions_without_effects")];
    assert!(0 < without && without < with, "{rows}");
    assert!(count("step_instructions_least") <= with && count("micro_steps") > 0, "{rows}");
}
