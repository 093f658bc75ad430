//! The whole joint, two planetary stages and a worm, beyond 10000:1.

use host_harness::plant::{self, Inputs, ScalarKind, Snapshot};
use host_harness::reference::{self, Method, Options};
use host_harness::reproduce::systems;
use joint_core::joint::Drive;

fn run(volts: f64, load_nm: f64) -> [Vec<Snapshot>; 3] {
    let joints = systems::built_in().unwrap();
    let (_, model) = joints.into_iter().find(|(file, _)| *file == "joint_20480").unwrap();
    assert!(systems::ratio(&model) > 10_000.0);
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
