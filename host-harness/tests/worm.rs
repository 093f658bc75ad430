//! The whole joint, two planetary stages and a worm, beyond 10000:1.

use std::path::Path;

use host_harness::model::Model;
use host_harness::plant::{self, Inputs, ScalarKind, Snapshot};
use host_harness::reference::{self, Method, Options};
use joint_core::joint::Drive;

const MODEL: &str = r#"
name = "whole"
[motor]
phase_resistance_ohm = 4.55
phase_inductance_h = 13e-6
torque_constant_nm_per_a = 1.38e-3
rotor_inertia_kg_m2 = 9.5e-10
friction = { sigma0_nm_per_rad = 0.05, sigma1_nm_s_per_rad = 4e-7, sigma2_nm_s_per_rad = 1e-9, coulomb_nm = 9e-6, stribeck_nm = 4e-6, stribeck_velocity_rad_per_s = 20 }
[[stage]]
reduction = 32
inertia_kg_m2 = 2e-9
stiffness_nm_per_rad = 0.35
friction = { sigma0_nm_per_rad = 1.5, sigma1_nm_s_per_rad = 6e-6, sigma2_nm_s_per_rad = 2e-8, coulomb_nm = 8e-5, stribeck_nm = 4e-5, stribeck_velocity_rad_per_s = 0.6 }
[[stage]]
reduction = 32
inertia_kg_m2 = 2e-7
stiffness_nm_per_rad = 15
friction = { sigma0_nm_per_rad = 60, sigma1_nm_s_per_rad = 2e-3, sigma2_nm_s_per_rad = 2e-5, coulomb_nm = 1e-3, stribeck_nm = 5e-4, stribeck_velocity_rad_per_s = 0.02 }
[[stage]]
reduction = 20
inertia_kg_m2 = 2e-5
stiffness_nm_per_rad = 200
damping_nm_s_per_rad = 0.01
worm_lead_angle_rad = 0.08
worm_friction_coefficient = 0.12
"#;

fn run(volts: f64, load_nm: f64) -> [Vec<Snapshot>; 3] {
    let model = Model::parse(MODEL, Path::new("whole.toml")).unwrap();
    let ratio: f64 = model.stages.iter().map(|stage| stage.reduction).product();
    assert!(ratio > 10_000.0);
    let time_s: Vec<f64> = (0..=600).map(|k| f64::from(k) * 1e-4).collect();
    let inputs = Inputs {
        drive: Drive::Voltage,
        drive_values: vec![volts; time_s.len()],
        load_nm: vec![load_nm; time_s.len()],
        time_s,
    };
    let explicit = Options::of(Method::BogackiShampine { step_s: 1e-7 });
    let reference = reference::simulate(&model, &inputs, &explicit).unwrap();
    let [wide, narrow] = [ScalarKind::F64, ScalarKind::F32]
        .map(|scalar| plant::simulate(&model, &inputs, scalar, Some(25e-6), None).unwrap());
    [reference, wide, narrow]
}

#[test]
fn the_whole_joint_lifts_with_the_reference_in_f64_and_f32() {
    let [reference, wide, narrow] = run(2.0, 0.05);
    let of = |run: &[Snapshot]| run.last().unwrap().stages[2].angle_rad;
    assert!(of(&reference) > 1e-3, "{}", of(&reference));
    for other in [&wide, &narrow] {
        let apart = (of(other) - of(&reference)).abs();
        assert!(apart < 0.01 * of(&reference), "{} for {}", of(other), of(&reference));
    }
}

#[test]
fn the_whole_joint_is_not_driven_back_by_its_load() {
    for run in run(0.0, 0.2) {
        // It gives by the springs and bristles only, and then rests.
        let angles: Vec<f64> = [300, 600].iter().map(|k| run[*k].stages[2].angle_rad).collect();
        assert!((angles[1] - angles[0]).abs() < 2e-4, "{angles:?}");
        assert!(run[600].motor_speed_rad_per_s.abs() < 1.0, "{}", run[600].motor_speed_rad_per_s);
    }
}
