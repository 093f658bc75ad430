//! The joint for other tools: an FMU that is loaded and stepped as an importing tool does, and a
//! MuJoCo model that says what it lacks.

#[path = "common/fmu.rs"]
mod fmu;

use std::path::Path;
use std::process::Command;

use host_harness::model::Model;
use host_harness::plant::{Inputs, ScalarKind, Snapshot, simulate};
use joint_core::joint::Drive;

use fmu::Fmu;

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
const STEPS: usize = 2_000;

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

/// Voltage and load of a step.
fn held(k: usize) -> [f64; 2] {
    [[3.0, -2.0, 0.2, 0.0][k / 300 % 4], if k > 900 { 0.004 } else { 0.0 }]
}

fn expected(model: &str) -> Vec<Snapshot> {
    let model = Model::parse(model, Path::new("m.toml")).unwrap();
    let inputs = Inputs {
        time_s: (0..=STEPS).map(|k| k as f64 * PERIOD_S).collect(),
        drive: Drive::Voltage,
        drive_values: (0..=STEPS).map(|k| held(k)[0]).collect(),
        load_nm: (0..=STEPS).map(|k| held(k)[1]).collect(),
    };
    simulate(&model, &inputs, ScalarKind::F64, None, None).unwrap()
}

#[test]
fn an_fmu_gives_what_the_model_gives_step_by_step() {
    if !cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    export(folder.path(), MODEL, "--format fmu --out m.fmu");
    let fmu = Fmu::load(&folder.path().join("m.fmu"));
    fmu.start();
    let expected = expected(MODEL);
    // Rounding alone is between the two: it is held against the largest value of each.
    type Of = fn(&Snapshot) -> f64;
    let shown: [(&str, Of); 7] = [
        ("motor_angle_rad", |own| own.motor_angle_rad),
        ("motor_speed_rad_per_s", |own| own.motor_speed_rad_per_s),
        ("current_a", |own| own.current_a),
        ("motor_bristle", |own| own.motor_bristle),
        ("stage1_windup_rad", |own| own.stages[0].windup_rad),
        ("output_angle_rad", |own| own.stages[1].angle_rad),
        ("output_speed_rad_per_s", |own| own.stages[1].speed_rad_per_s),
    ];
    let largest =
        |of: fn(&Snapshot) -> f64| expected.iter().map(of).fold(0.0, |a, b| b.abs().max(a));
    let shown = shown.map(|(name, of)| (name, of, largest(of)));
    for (k, own) in expected.iter().enumerate() {
        for (name, of, largest) in shown {
            let (found, value) = (fmu.get(name), of(own));
            assert!((found - value).abs() <= 1e-10 * largest, "{name} at {k}: {found} for {value}");
        }
        let [voltage, load] = held(k);
        assert_eq!((fmu.set("voltage_v", voltage), fmu.set("load_torque_nm", load)), (0, 0));
        assert_eq!(fmu.step(k as f64 * PERIOD_S, PERIOD_S), 0);
    }
}

#[test]
fn a_joint_that_was_copied_elsewhere_still_exports_an_fmu() {
    if !cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("joint");
    std::fs::copy(env!("CARGO_BIN_EXE_joint"), &copy).unwrap();
    std::fs::write(folder.path().join("m.toml"), MODEL).unwrap();
    let output = Command::new(copy)
        .args("export --model m.toml --format fmu --out m.fmu".split(' '))
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    Fmu::load(&folder.path().join("m.fmu"));
}

#[test]
fn an_fmus_parameters_are_set_before_it_starts_and_not_after() {
    if !cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    export(folder.path(), MODEL, "--format fmu --out m.fmu");
    let fmu = Fmu::load(&folder.path().join("m.fmu"));
    assert_eq!(fmu.get("motor.phase_resistance_ohm"), 4.55);
    assert_eq!(fmu.set("motor.phase_resistance_ohm", 9.1), 0);
    fmu.start();
    assert_eq!(fmu.set("motor.phase_resistance_ohm", 4.55), 3);
    assert_eq!(fmu.set("voltage_v", 3.0), 0);
    // One long communication step is as many of the joint's own.
    assert_eq!(fmu.step(0.0, 300.0 * PERIOD_S), 0);
    let other = MODEL.replace("phase_resistance_ohm = 4.55", "phase_resistance_ohm = 9.1");
    let wanted = expected(&other)[300].motor_speed_rad_per_s;
    assert!((fmu.get("motor_speed_rad_per_s") - wanted).abs() < 1e-9 * wanted.abs());
    assert_eq!(fmu.set("voltage_v", f64::NAN), 0);
    assert_eq!(fmu.step(300.0 * PERIOD_S, PERIOD_S), 3);
    // What no joint is made of.
    assert_eq!(fmu.call("fmi2Reset"), 0);
    assert_eq!(fmu.set("motor.rotor_inertia_kg_m2", -1.0), 0);
    assert_eq!(fmu.call("fmi2ExitInitializationMode"), 3);
}

#[test]
fn an_fmu_starts_where_it_is_told_to_and_refuses_a_time_that_jumps() {
    if !cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    export(folder.path(), MODEL, "--format fmu --out m.fmu");
    let fmu = Fmu::load(&folder.path().join("m.fmu"));
    assert_eq!(fmu.set("initial.motor_angle_rad", 100.0), 0);
    assert_eq!(fmu.set("initial.motor_speed_rad_per_s", -320.0), 0);
    fmu.start();
    // Both stages are 32:1 and the second reverses; nothing is wound up.
    for (name, wanted) in [
        ("motor_angle_rad", 100.0),
        ("motor_speed_rad_per_s", -320.0),
        ("stage1_angle_rad", 100.0 / 32.0),
        ("output_angle_rad", -100.0 / 1024.0),
        ("output_speed_rad_per_s", 320.0 / 1024.0),
        ("stage1_windup_rad", 0.0),
        ("stage1_torque_nm", 0.0),
    ] {
        let found = fmu.get(name);
        assert!((found - wanted).abs() <= 1e-12 * wanted.abs(), "{name}: {found} for {wanted}");
    }
    assert_eq!(fmu.step(0.0, PERIOD_S), 0);
    let moved = fmu.get("motor_angle_rad");
    assert!(moved < 100.0);
    for (from, step) in [(0.0, PERIOD_S), (3.0 * PERIOD_S, PERIOD_S), (PERIOD_S, -PERIOD_S)] {
        assert_eq!(fmu.step(from, step), 3, "{from} {step}");
        assert_eq!(fmu.get("motor_angle_rad"), moved, "{from} {step}");
    }
    assert_eq!(fmu.step(PERIOD_S, PERIOD_S), 0);
}

#[test]
fn an_fmus_torques_are_those_that_accelerate_its_masses() {
    if !cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    // No effect, no gravity: what is put out is all that acts.
    let plain =
        MODEL.split("[[effect]]").next().unwrap().replace("gravity_nm = 0.002", "gravity_nm = 0.0");
    export(folder.path(), &plain, "--format fmu --out m.fmu --period-us 2");
    let fmu = Fmu::load(&folder.path().join("m.fmu"));
    fmu.start();
    fmu.set("voltage_v", 3.0);
    let (mut time, step) = (0.0, 2e-6);
    let (mut sums, mut largest) = ([0.0; 2], [0.0_f64; 2]);
    let told = |name: &str| fmu.get(name);
    for _ in 0..3000 {
        // Trapezoids of what acts on the rotor and on the output, against the change of their momentum.
        let acting = || {
            [
                told("motor_torque_nm")
                    - told("motor_friction_nm")
                    - told("stage1_torque_nm") / 32.0,
                told("stage2_torque_nm") - told("stage2_friction_nm"),
            ]
        };
        let momentum =
            || [9.5e-10 * told("motor_speed_rad_per_s"), 1.8e-6 * told("output_speed_rad_per_s")];
        let (before, had) = (acting(), momentum());
        assert_eq!(fmu.step(time, step), 0);
        time += step;
        let (after, has) = (acting(), momentum());
        for k in 0..2 {
            sums[k] += 0.5 * step * (before[k] + after[k]) - (has[k] - had[k]);
            largest[k] = has[k].abs().max(largest[k]);
        }
    }
    // The trapezoid's error at 2 us, where the chain's fastest mode turns by 0.1 rad: its square over twelve.
    for (sum, largest) in sums.into_iter().zip(largest) {
        assert!(sum.abs() < 1e-3 * largest, "{sum} of {largest}");
    }
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
fn fmpy_validates_the_fmu_and_runs_it_as_we_do() {
    if !cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        return;
    }
    let Some(python) = joint_tests::python::with("fmpy", "fmpy_validates_the_fmu") else { return };
    // The same step: rounding alone, which a chain with friction passes on.
    for (name, error) in compared(MODEL, "fmu", "embedded", python, "fmpy_run.py") {
        assert!(error < 1e-9, "{name}: {error}");
    }
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
