//! The walk of docs/firmware.md, line by line: from a log with something hidden in it to a drive that
//! runs the improved model, with the estimates that the host has foretold.

use std::collections::HashMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use host_harness::demo::actuator;
use host_harness::model::Model;
use host_harness::synthetic::{Experiment, perturbed, record};
use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;
use joint_tests::qemu::{self, Board};

const DOCUMENT: &str = include_str!("../../docs/firmware.md");
/// Control periods between two reports, where nothing asks for another rate.
const EVERY: usize = firmware::session::DEFAULT_RATE as usize;

/// The commands of the document, with the test's own programs for `joint` and `cargo`.
fn script() -> String {
    let (_, rest) = DOCUMENT.split_once("## From a model to an accepted block").unwrap();
    let lines = rest.split("```sh\n").nth(1).unwrap().split("```").next().unwrap();
    let (own, walk) = lines.split_once('\n').unwrap();
    assert!(own.starts_with("joint() {"), "{own}");
    // The firmware is built before, where tests build it.
    format!("set -eu\njoint() {{ \"$JOINT\" \"$@\"; }}\ncargo() {{ :; }}\n{walk}")
}

/// A log of a joint with hidden cogging, and a nominal model that is wrong in every parameter.
fn data(folder: &Path) {
    let hidden = EffectParameters::new(Kind::Cogging, Location::Motor)
        .with("order", 42.0)
        .with("amplitude_nm", 0.012)
        .with("phase_rad", 0.8);
    let mut truth = perturbed(&actuator(), 51);
    truth.effects.push(hidden);
    let experiment =
        Experiment { duration_s: 0.8, stribeck_exponent: 1.8, ..Experiment::default() };
    let log = record(&truth, &experiment, 52).unwrap();
    fs::write(folder.join("log.csv"), log.to_csv()).unwrap();
    fs::write(folder.join("nominal.toml"), perturbed(&truth, 53).to_toml()).unwrap();
}

/// Columns of a file by their names.
fn columns(path: &Path) -> HashMap<String, Vec<String>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let names: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let mut columns: HashMap<String, Vec<String>> = HashMap::new();
    for row in reader.records() {
        for (name, value) in names.iter().zip(row.unwrap().iter()) {
            columns.entry(name.clone()).or_default().push(value.to_owned());
        }
    }
    columns
}

/// Single precision as it was written, exactly.
fn bits(text: &str) -> u32 {
    (text.parse::<f64>().unwrap() as f32).to_bits()
}

#[test]
fn the_documented_walk_ends_in_a_drive_that_estimates_what_the_host_foretold() {
    let name = "the_documented_walk_ends_in_a_drive_that_estimates_what_the_host_foretold";
    if !qemu::available(name) {
        return;
    }
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    data(folder);
    let built = folder.join("target").join(qemu::TARGET).join("release");
    fs::create_dir_all(&built).unwrap();
    fs::copy(qemu::firmware("hil", Board::NetduinoPlus2), built.join("hil")).unwrap();

    let output = Command::new("bash")
        .args(["-c", &script()])
        .env("JOINT", env!("CARGO_BIN_EXE_joint"))
        .current_dir(folder)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    let complained = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}\n{complained}");
    let model = Model::parse(
        &fs::read_to_string(folder.join("found/model.toml")).unwrap(),
        "model.toml".as_ref(),
    )
    .unwrap();
    assert_eq!(model.effects.iter().map(|own| own.kind).collect::<Vec<_>>(), [Kind::Cogging]);
    assert!(said.lines().any(|line| line == "parameters=accepted"), "{said}");
    // The checksum that the export has told is the one that the drive has found.
    let block =
        firmware::block::Block::check(&fs::read(folder.join("joint.block")).unwrap()).unwrap().crc;
    assert!(said.contains(&format!("CRC {block:08x}")), "{said}");
    assert!(said.contains(&format!("parameters_crc32={block:08x}")), "{said}");

    let (host, chip) = (columns(&folder.join("observed.csv")), columns(&folder.join("chip.csv")));
    let samples = host["t_s"].len();
    assert_eq!(chip["t_s"].len(), samples / EVERY);
    for end in ["", "_std"] {
        for (own, drives) in [
            ("motor_velocity_rad_per_s", "motor_velocity_rad_per_s"),
            ("total_friction_at_motor_nm", "total_friction_at_motor_nm"),
            ("stage1_windup_rad", "stage1_windup_rad"),
            ("output_angle_rad", "estimated_output_angle_rad"),
            ("output_velocity_rad_per_s", "output_velocity_rad_per_s"),
            ("load_torque_nm", "estimated_load_torque_nm"),
        ] {
            let (host, chip) = (&host[&format!("{own}{end}")], &chip[&format!("{drives}{end}")]);
            for (k, chip) in chip.iter().enumerate() {
                let at = (k + 1) * EVERY - 1;
                assert_eq!(bits(chip), bits(&host[at]), "{own}{end} at sample {at}");
            }
        }
    }
    println!("{samples} samples, {} reports of the drive, every one as foretold", samples / EVERY);
}
