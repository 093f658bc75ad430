//! CONTRIBUTING's recipe for a new effect, followed.
//!
//! An eddy-current brake, which no effect on the list can stand for, is added to a copy of the
//! workspace by the files that the recipe names and by no other. There the tests of effects and
//! documents must pass, and `joint discover` must name the brake in a log simulated with it. The copy
//! is built into the workspace's own build folder, so that no dependency is compiled again.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use joint_tests::qemu::workspace;

const NAME: &str = "eddy_brake";

/// Where the brake's two files lie, in the folders that they belong to.
const FILES: &str = "tests/data/toy-effect";

/// Rows that are added: the file, the start of the line that each goes before, and the row.
const ROWS: [[&str; 3]; 3] = [
    [
        "joint-core/src/effect/mod.rs",
        "            encoder_eccentricity::EncoderEccentricity,",
        "            eddy_brake::EddyBrake,",
    ],
    [
        "docs/model-format.md",
        "| `encoder-eccentricity` |",
        "| `eddy-brake` | motor | `critical_torque_nm`, `critical_speed_rad_per_s` |",
    ],
    [
        "docs/model.md",
        "| `encoder-eccentricity` |",
        r"| `eddy-brake` | motor | $\tau_0 = -2T_k(\omega/\omega_k)/(1 + (\omega/\omega_k)^2)$ | $T_k$ `critical_torque_nm`, $\omega_k$ `critical_speed_rad_per_s` | `drag` |",
    ],
];

const NOMINAL: &str = "name = \"brake\"\n
[motor]
phase_resistance_ohm = 2.8
phase_inductance_h = 0.0008
torque_constant_nm_per_a = 0.11
pole_pairs = 7
rotor_inertia_kg_m2 = 0.00011\n
[motor.friction]
sigma0_nm_per_rad = 15
sigma1_nm_s_per_rad = 0.02
sigma2_nm_s_per_rad = 0.00012
coulomb_nm = 0.006
stribeck_nm = 0.003
stribeck_velocity_rad_per_s = 1.5\n
[sensor]
sample_time_s = 0.0002
motor_encoder_counts_per_rev = 16384
current_noise_a = 0.01\n";

/// Twice the breakaway torque, at a fifth of the highest speed.
const EFFECT: &str = "\n[[effect]]
kind = \"eddy-brake\"
location = \"motor\"
critical_torque_nm = 0.018
critical_speed_rad_per_s = 12\n";

const INTERVAL_S: f64 = 2e-4;
const SAMPLES: u32 = 7500;

type Tree = BTreeMap<PathBuf, Vec<u8>>;

/// The files of a folder, without what is hidden and what cargo builds.
fn tree(folder: &Path) -> Tree {
    let mut all = Tree::new();
    collect(folder, Path::new(""), &mut all);
    all
}

fn collect(root: &Path, within: &Path, all: &mut Tree) {
    for entry in fs::read_dir(root.join(within)).unwrap() {
        let entry = entry.unwrap();
        let (name, path) = (entry.file_name(), within.join(entry.file_name()));
        let built = name == "target" || entry.path().join("CACHEDIR.TAG").exists();
        if built || name.to_string_lossy().starts_with('.') {
            continue;
        }
        if entry.file_type().unwrap().is_dir() {
            collect(root, &path, all);
        } else {
            all.insert(path, fs::read(entry.path()).unwrap());
        }
    }
}

/// What has the host's crates compiled with less optimisation and without checks.
fn quick() -> Vec<String> {
    let crates = ["host-harness", "joint-estimation", "joint-simulation"];
    let less = ["opt-level=1", "debug=false", "overflow-checks=false", "debug-assertions=false"];
    let each = crates.iter().flat_map(|name| {
        less.iter().map(move |setting| format!("profile.test.package.{name}.{setting}"))
    });
    each.flat_map(|setting| ["--config".to_owned(), setting]).collect()
}

/// Makes a folder hold these files and no others; one that is right already keeps its age, so that
/// cargo finds it as it was.
fn write(files: &Tree, folder: &Path) {
    fs::create_dir_all(folder).unwrap();
    let there = tree(folder);
    for gone in there.keys().filter(|path| !files.contains_key(*path)) {
        fs::remove_file(folder.join(gone)).unwrap();
    }
    for (path, bytes) in files.iter().filter(|(path, bytes)| there.get(*path) != Some(bytes)) {
        let path = folder.join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
}

/// The workspace with the brake.
fn with_brake(plain: &Tree) -> Tree {
    let mut files = plain.clone();
    files.extend(tree(&workspace().join(FILES)));
    for [file, before, row] in ROWS {
        let bytes = files.get_mut(Path::new(file)).unwrap_or_else(|| panic!("no {file}"));
        let text = String::from_utf8(bytes.clone()).unwrap();
        let found = text.lines().filter(|line| line.starts_with(before)).count();
        assert_eq!(found, 1, "{file}: lines that start with {before}");
        let lines = text.lines().flat_map(|line| {
            let own = line.starts_with(before).then_some(row);
            own.into_iter().chain([line]).flat_map(|line| [line, "\n"])
        });
        *bytes = lines.collect::<String>().into_bytes();
    }
    files
}

/// Kinds of libraries that are linked by others, as a manifest names them beside `rlib`.
const LINKED: [&str; 2] = ["\"cdylib\", ", "\"staticlib\", "];

/// The same packages under a version of their own: cargo tells builds apart by it, and those of the copy do
/// not take the place of the workspace's in the build folder that they share. A library that is to be linked by
/// others has one name in all versions; the copy's are for Rust alone.
fn with_own_version(mut files: Tree) -> Tree {
    let [own, other] =
        ["", "-recipe"].map(|mark| format!("version = \"{}{mark}\"", env!("CARGO_PKG_VERSION")));
    // Packages of the workspace ask for each other by version as well as by path.
    let manifests =
        files.keys().filter(|path| path.file_name().is_some_and(|own| own == "Cargo.toml"));
    let asking: Vec<PathBuf> = manifests.cloned().collect();
    for file in asking.iter().map(PathBuf::as_path).chain([Path::new("Cargo.lock")]) {
        let bytes = files.get_mut(file).unwrap_or_else(|| panic!("no {}", file.display()));
        let text = String::from_utf8(bytes.clone()).unwrap();
        // A package of a registry has a source, one of the workspace none.
        let packages = text.split("\n\n").map(|package| match package.contains("\nsource = ") {
            true => package.to_owned(),
            false => package.replace(&own, &other),
        });
        let own = packages.collect::<Vec<_>>().join("\n\n");
        *bytes = LINKED.iter().fold(own, |own, kind| own.replace(kind, "")).into_bytes();
    }
    files
}

/// The same for joints of two stages at most, which is all that is run there: the host compiles its step for every
/// number of stages, which takes longer than all else.
fn with_few_stages(mut files: Tree) -> Tree {
    let bytes = files.get_mut(Path::new("host-harness/simulation/src/plant.rs")).unwrap();
    let text = String::from_utf8(bytes.clone()).unwrap();
    let arm = |stages: usize| {
        format!(
            "            {stages} => {{\n                const $n: usize = {stages};\n                $body\n            }}\n"
        )
    };
    let few = (3..=6).map(arm).fold(text, |text, arm| {
        assert_eq!(text.matches(&arm).count(), 1, "{arm}");
        text.replace(&arm, "")
    });
    *bytes = few.into_bytes();
    files
}

/// The files that the recipe's numbered steps name.
fn recipe(contributing: &str) -> BTreeSet<PathBuf> {
    let section = contributing.split("\n## To add an effect\n").nth(1).unwrap();
    let section = section.split("\n## ").next().unwrap();
    let step =
        |line: &&str| line.starts_with("   ") || line.starts_with(|c: char| c.is_ascii_digit());
    let steps: Vec<&str> = section.lines().filter(step).collect();
    let steps = steps.join("\n");
    let quoted = steps.split('`').skip(1).step_by(2);
    quoted
        .filter(|text| text.contains('/'))
        .map(|path| path.replace("<name>", NAME).into())
        .collect()
}

fn run(command: &mut Command) -> String {
    let began = Instant::now();
    let output = command.output().unwrap();
    let [out, error] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
    assert!(output.status.success(), "{command:?}\n{out}\n{error}");
    println!("{:>6.1} s  {command:?}", began.elapsed().as_secs_f64());
    out.into_owned()
}

/// Voltages that take the motor through its critical speed, to the highest and back, both ways.
fn input() -> String {
    let mut text = "t_s,u_v,i_a,motor_angle_rad\n".to_owned();
    for k in 0..SAMPLES {
        let time = f64::from(k) * INTERVAL_S;
        let volts = 5.0 * (TAU * 1.3 * time).sin() + 2.5 * (TAU * 3.7 * time).sin();
        writeln!(text, "{time:.4},{volts:.3},0,0").unwrap();
    }
    text
}

/// A simulated log as the sensors of the nominal would have written it down.
fn measured(simulated: &str) -> String {
    // Marsaglia's xorshift; the sum of twelve uniform numbers less six is normal enough.
    let mut word = 0x9e37_79b9_7f4a_7c15_u64;
    let mut uniform = || {
        word ^= word << 13;
        word ^= word >> 7;
        word ^= word << 17;
        (word >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut normal = || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
    let mut lines = simulated.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let columns = ["t_s", "u_v", "i_a", "motor_angle_rad"];
    let places = columns.map(|name| names.iter().position(|own| *own == name).unwrap());
    let mut text = columns.join(",") + "\n";
    for line in lines {
        let values: Vec<f64> = line.split(',').map(|value| value.parse().unwrap_or(0.0)).collect();
        let [time, volts, current, angle] = places.map(|place| values[place]);
        let count = TAU / 16384.0;
        let (current, angle) = (current + 0.01 * normal(), (angle / count).round() * count);
        writeln!(text, "{time:.4},{volts:.3},{current:.4},{angle:.6}").unwrap();
    }
    text
}

#[test]
fn the_recipe_for_an_effect_is_two_files_and_a_row_and_discover_names_it() {
    let plain = tree(&workspace());
    let files = with_brake(&plain);
    let touched: BTreeSet<PathBuf> = files
        .iter()
        .filter(|(path, bytes)| plain.get(*path) != Some(bytes))
        .map(|(path, _)| path.clone())
        .collect();
    let contributing = fs::read_to_string(workspace().join("CONTRIBUTING.md")).unwrap();
    assert_eq!(touched, recipe(&contributing), "touched, and what CONTRIBUTING.md names");
    println!("an effect touches {touched:?}");

    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("recipe");
    let copy = folder.join("workspace");
    fs::create_dir_all(&folder).unwrap();
    let lock = File::create(folder.join("lock")).unwrap();
    lock.lock().unwrap();
    write(&with_few_stages(with_own_version(files)), &copy);

    // Of the whole workspace, so that the dependencies have the features that they are built with here.
    let built = Path::new(env!("CARGO_TARGET_TMPDIR")).join("..");
    let passed = run(Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()))
        .current_dir(&copy)
        .env("CARGO_BUILD_BUILD_DIR", built.canonicalize().unwrap())
        .env("CARGO_TARGET_DIR", folder.join("target"))
        .env("CARGO_INCREMENTAL", "0")
        // Compiling takes most of the time, and the search is fast enough with less of it.
        .args(quick())
        .args(["test", "--locked", "--workspace", "--test", "effects", "--test", "docs"]));
    assert!(passed.contains("every_law_acts_at_the_size_of_its_example ... ok"), "{passed}");

    for (name, text) in [
        ("nominal.toml", NOMINAL.to_owned()),
        ("truth.toml", NOMINAL.to_owned() + EFFECT),
        ("input.csv", input()),
    ] {
        fs::write(folder.join(name), text).unwrap();
    }
    let joint = |arguments: &[&str]| {
        let mut command = Command::new(folder.join("target/debug/joint"));
        run(command.current_dir(&folder).args(arguments).arg("--force"))
    };
    let simulated = ["--model", "truth.toml", "--input", "input.csv", "--out", "simulated.csv"];
    joint(&[&["simulate", "--method", "reference"], &simulated[..]].concat());
    let simulated = fs::read_to_string(folder.join("simulated.csv")).unwrap();
    fs::write(folder.join("log.csv"), measured(&simulated)).unwrap();
    let discover = ["discover", "--model", "nominal.toml", "--log", "log.csv"];
    let verdict = |out: &str, more: &[&str]| -> serde_json::Value {
        println!("{}", joint(&[&discover[..], &["--out", out], more].concat()));
        let verdict = fs::read_to_string(folder.join(out).join("verdict.json")).unwrap();
        serde_json::from_str(&verdict).unwrap()
    };
    let without = verdict("without", &["--without", "eddy-brake"]);
    assert_eq!(without["verdict"], "unknown", "another effect stands for it: {without:#}");
    let found = verdict("found", &[]);
    let named = found["effects"].as_array().unwrap();
    assert_eq!(found["verdict"], "effect", "{found:#}");
    assert_eq!(named.len(), 1, "{found:#}");
    assert_eq!((&named[0]["kind"], &named[0]["location"]), (&"eddy-brake".into(), &"motor".into()));
    // What is one in two million for an error that is normal is no accident; and a log that tells the
    // brake from all else knows its size.
    let of = |table: &str| named[0][table]["critical_torque_nm"].as_f64().unwrap();
    let (torque, sigma) = (of("parameters"), of("standard_errors"));
    assert!((torque - 0.018).abs() < 5.0 * sigma && sigma < 0.01 * torque, "{torque} ± {sigma}");
}
