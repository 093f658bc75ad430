//! The joint for other tools: FMUs (`export/fmu.rs`), a MuJoCo model that says what it lacks, and a URDF.

#[path = "export/fmu.rs"]
mod fmu;

use std::path::Path;
use std::process::Command;

const MODEL: &str = r#"
name = "two stages"
[motor]
phase_resistance_ohm = 4.55
phase_inductance_h = 13e-6
torque_constant_nm_per_a = 1.38e-3
rotor_inertia_kg_m2 = 9.5e-10
[motor.friction]
sigma0_nm_per_rad = 0.05
sigma1_nm_s_per_rad = 4e-7
sigma2_nm_s_per_rad = 1e-9
coulomb_nm = 9e-6
stribeck_nm = 4e-6
stribeck_velocity_rad_per_s = 20.0
[[stage]]
reduction = 32.0
inertia_kg_m2 = 2e-9
stiffness_nm_per_rad = 0.5
damping_nm_s_per_rad = 1e-5
[[stage]]
reduction = -32.0
inertia_kg_m2 = 8e-7
stiffness_nm_per_rad = 15.0
damping_nm_s_per_rad = 1e-3
[load]
inertia_kg_m2 = 1e-6
gravity_nm = 0.002
gravity_phase_rad = 0.4
[[effect]]
kind = "cogging"
location = "motor"
order = 6
amplitude_nm = 1e-5
"#;
const PERIOD_S: f64 = 50e-6;

fn export(folder: &Path, model: &str, arguments: &str) -> serde_json::Value {
    std::fs::write(folder.join("m.toml"), model).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_joint"))
        .args("export --model m.toml --json --force".split(' '))
        .args(arguments.split(' '))
        .current_dir(folder)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A log with the inputs of the comparison, and zeros for what is not known.
fn driven(folder: &Path) {
    let mut text = String::from("t_s,u_v,i_a,motor_angle_rad,output_angle_rad,load_torque_nm\n");
    for k in 0..=6000 {
        let time = k as f64 * PERIOD_S;
        let sine = 2.0 * (std::f64::consts::TAU * 12.0 * time).sin();
        let voltage = [3.0, -2.0, 0.3, sine][k / 1500 % 4];
        let load = if k > 3000 { 0.004 } else { 0.0 };
        text += &format!("{time:?},{voltage:?},0,0,0,{load:?}\n");
    }
    std::fs::write(folder.join("l.csv"), text).unwrap();
}

/// Columns of a file.
fn columns(path: &Path) -> std::collections::BTreeMap<String, Vec<f64>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let names = reader.headers().unwrap().clone();
    let rows: Vec<_> = reader.records().map(|record| record.unwrap()).collect();
    let column = |k: usize| rows.iter().map(|row| row[k].parse().unwrap_or(f64::NAN)).collect();
    names.iter().enumerate().map(|(k, name)| (name.to_owned(), column(k))).collect()
}

/// A tool's run of an exported model, and ours by the reference.
fn compared(
    model: &str,
    format: &str,
    method: &str,
    mut python: Command,
    tool: &str,
) -> Vec<(String, f64)> {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    driven(folder.path());
    export(folder.path(), model, &format!("--format {format} --out joint.{format}"));
    let simulated = Command::new(env!("CARGO_BIN_EXE_joint"))
        .args(["simulate", "-m", "m.toml", "-i", "l.csv", "-o", "s.csv", "--from-rest", "--method"])
        .arg(method)
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(simulated.status.success(), "{}", String::from_utf8_lossy(&simulated.stderr));
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/tools").join(tool);
    let run = python
        .arg(script)
        .args([path(&format!("joint.{format}")), path("l.csv"), path("theirs.csv")])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let (ours, theirs) = (columns(&path("s.csv")), columns(&path("theirs.csv")));
    let last = ours.keys().rfind(|name| name.ends_with("_speed_rad_per_s")).unwrap();
    let mut errors = Vec::new();
    for (name, values) in theirs.iter().filter(|(name, _)| *name != "t_s") {
        let own = match name.as_str() {
            "output_speed_rad_per_s" => ours.get(last),
            name => ours.get(name),
        };
        let Some(own) = own else { continue };
        let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
            own.iter().zip(values).map(|(a, b)| of(*a, *b)).sum()
        };
        let missed = sum(&|a, b| (a - b) * (a - b)) / sum(&|a, _| a * a).max(f64::MIN_POSITIVE);
        errors.push((name.clone(), missed.sqrt()));
    }
    assert!(errors.len() >= 5, "{errors:?}");
    println!("{tool}: {errors:?}");
    errors
}

#[test]
fn mujoco_runs_the_model_as_the_reference_does() {
    let Some(python) = joint_tests::python::with("mujoco", "mujoco_runs_the_model") else { return };
    within(&compared(MODEL, "mjcf", "reference", python, "mujoco_run.py"));
}

/// Errors are of first order in MuJoCo's step, which turns the fastest mode by 0.1 rad: half of it halves them.
/// An element that is left out makes one that is larger in some signal: 0.37 % of a wind-up for the cubic
/// stiffness, 5 % for the hysteresis, 0.4 % of a speed or more for the others.
fn within(errors: &[(String, f64)]) {
    for name in ["stage1_windup_rad", "stage2_windup_rad", "current_a", "output_speed_rad_per_s"] {
        assert!(errors.iter().any(|(own, _)| own == name), "{name}: {errors:?}");
    }
    for (name, error) in errors {
        let bound = if name.ends_with("angle_rad") { 1e-4 } else { 2e-3 };
        assert!(*error < bound, "{name}: {error}");
    }
}

#[test]
fn mujoco_has_the_effects_that_the_file_does_not_leave_out() {
    let Some(python) = joint_tests::python::with("mujoco", "mujoco_has_the_effects") else {
        return;
    };
    let friction = "[stage.friction]\nsigma0_nm_per_rad = 0.5\nsigma1_nm_s_per_rad = 2e-5\n\
        coulomb_nm = 3e-4\nstribeck_nm = 1e-4\nstribeck_velocity_rad_per_s = 0.3\n[load]";
    let effects = "[[effect]]\nkind = \"hardening-stiffness\"\nlocation = \"stage2\"\n\
        cubic_stiffness_nm_per_rad3 = 5e5\n[[effect]]\nkind = \"quadratic-drag\"\nlocation = \"motor\"\n\
        coefficient_nm_s2 = 2e-12\n[[effect]]\nkind = \"structural-hysteresis\"\nlocation = \"stage1\"\n\
        amplitude_nm = 1e-4\nwidth_rad = 1e-3\n";
    let model = format!("{}{effects}", MODEL.replace("[load]", friction));
    let folder = tempfile::tempdir().unwrap();
    let told = export(folder.path(), &model, "--format mjcf --out m.xml");
    assert_eq!(told["lost"], serde_json::json!([]));
    within(&compared(&model, "mjcf", "reference", python, "mujoco_run.py"));
}

#[test]
fn a_urdf_has_friction_and_limits_as_they_are_at_the_output() {
    let folder = tempfile::tempdir().unwrap();
    let told =
        export(folder.path(), MODEL, "--format urdf --out m.urdf --bus-v 12 --current-limit-a 0.5");
    let text = std::fs::read_to_string(folder.path().join("m.urdf")).unwrap();
    let value = |start: &str| -> f64 {
        let rest = text.split(start).nth(1).unwrap_or_else(|| panic!("{start}: {text}"));
        rest.split('"').next().unwrap().parse().unwrap()
    };
    for (start, wanted) in [
        ("friction=\"", 9e-6 * 1024.0),
        ("damping=\"", 1e-9 * 1024.0 * 1024.0),
        ("effort=\"", 1.38e-3 * 0.5 * 1024.0),
        ("velocity=\"", 12.0 / (1.38e-3 * 1024.0)),
    ] {
        assert!((value(start) / wanted - 1.0).abs() < 1e-12, "{start}");
    }
    assert!(text.contains("<mechanicalReduction>-1024.0</mechanicalReduction>"), "{text}");
    assert!(
        told["lost"]
            .as_array()
            .unwrap()
            .iter()
            .any(|line| line.as_str().unwrap().contains("cogging"))
    );
}

#[test]
fn a_mujoco_model_has_what_it_can_say_and_names_what_it_cannot() {
    let folder = tempfile::tempdir().unwrap();
    let more = "[[effect]]\nkind = \"backlash\"\nlocation = \"stage1\"\nwidth_rad = 0.004\n\
        [[effect]]\nkind = \"torque-ripple\"\nlocation = \"motor\"\norder = 6\nrelative_amplitude = 0.02\n";
    let told =
        export(folder.path(), &format!("{MODEL}{more}"), "--format mjcf --out m.xml --bus-v 12");
    let text = std::fs::read_to_string(folder.path().join("m.xml")).unwrap();
    for part in [
        "stiffness=\"0.5\" damping=\"1e-5\" springlength=\"-0.002 0.002\"",
        "coef=\"0.03125\"",
        "coef=\"-0.03125\"",
        "resistance=\"9.1\" inductance=\"2.6e-5 0\"",
        "ctrlrange=\"-12.0 12.0\"",
        "lugre=\"0.05 4e-7 9e-6 1.3",
        "cogging=\"1e-5 6.0 3.14159",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    // Gravity: m g l at the output, and the inertia about the hinge still the load's and the gear's.
    let output =
        text.lines().skip_while(|line| !line.contains("body name=\"output\"")).nth(1).unwrap();
    let numbers: Vec<f64> = output.split(['"', ' ']).filter_map(|word| word.parse().ok()).collect();
    let [x, _, z, mass, inertia, ..] = numbers[..] else { panic!("{output}") };
    assert!((mass * 9.81 * x.hypot(z) - 0.002).abs() < 1e-12);
    assert!((inertia + mass * x.hypot(z).powi(2) - 1.8e-6).abs() < 1e-15);
    assert!((x.atan2(-z) - 0.4).abs() < 1e-12);
    let lost: Vec<&str> =
        told["lost"].as_array().unwrap().iter().map(|line| line.as_str().unwrap()).collect();
    assert_eq!(
        lost,
        ["stage 1: that its damping ends where play begins", "effect torque-ripple at motor"]
    );
    for line in lost {
        assert!(text.contains(line), "the file does not say {line}");
    }
}
