//! Exported FMUs, of FMI 2.0 and 3.0, that are loaded and stepped as an importing tool does, and run by FMPy.

#[path = "loaded.rs"]
mod loaded;

use std::path::Path;
use std::process::Command;

use host_harness::model::Model;
use host_harness::plant::{Inputs, ScalarKind, Snapshot, simulate};
use joint_core::joint::Drive;

use super::{MODEL, PERIOD_S, compared, export};
use loaded::Fmu;

const STEPS: usize = 2_000;
/// FMI 2.0 and 3.0.
const UNITS: [&str; 2] = ["fmu", "fmu3"];

/// An FMU of a model, exported and loaded.
fn unit(model: &str, format: &str, more: &str) -> Fmu {
    let folder = tempfile::tempdir().unwrap();
    export(folder.path(), model, &format!("--format {format} --out m.fmu{more}"));
    Fmu::load(&folder.path().join("m.fmu"))
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
    for format in UNITS {
        let fmu = unit(MODEL, format, "");
        fmu.start();
        for (k, own) in expected.iter().enumerate() {
            for (name, of, largest) in shown {
                let (found, value) = (fmu.get(name), of(own));
                let error = (found - value).abs();
                assert!(error <= 1e-10 * largest, "{format}, {name} at {k}: {found} for {value}");
            }
            let [voltage, load] = held(k);
            assert_eq!((fmu.set("voltage_v", voltage), fmu.set("load_torque_nm", load)), (0, 0));
            assert_eq!(fmu.step(k as f64 * PERIOD_S, PERIOD_S), 0);
        }
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
    for format in UNITS {
        let fmu = unit(MODEL, format, "");
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
        assert_eq!(fmu.call("Reset"), 0);
        assert_eq!(fmu.set("motor.rotor_inertia_kg_m2", -1.0), 0);
        assert_eq!(fmu.call("ExitInitializationMode"), 3);
    }
}

#[test]
fn an_fmu_starts_where_it_is_told_to_and_refuses_a_time_that_jumps() {
    if !cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        return;
    }
    for format in UNITS {
        let fmu = unit(MODEL, format, "");
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
}

#[test]
fn an_fmus_torques_are_those_that_accelerate_its_masses() {
    if !cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        return;
    }
    // No effect, no gravity: what is put out is all that acts.
    let plain =
        MODEL.split("[[effect]]").next().unwrap().replace("gravity_nm = 0.002", "gravity_nm = 0.0");
    let fmu = unit(&plain, "fmu", " --period-us 2");
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

#[test]
fn fmpy_validates_the_fmus_and_runs_them_as_we_do() {
    if !cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        return;
    }
    for format in UNITS {
        let Some(python) = joint_tests::python::with("fmpy", "fmpy_validates_the_fmus") else {
            return;
        };
        // The same step: rounding alone, which a chain with friction passes on.
        for (name, error) in compared(MODEL, format, "embedded", python, "fmpy_run.py") {
            assert!(error < 1e-9, "{format}, {name}: {error}");
        }
    }
}
