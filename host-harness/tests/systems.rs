//! The built-in joints beside the one of the figures: 1:125, 1:1000 and, with worm and coating, beyond
//! 1:10000, held against the reference.

use host_harness::cross_check::Quantity;
use host_harness::plant::{self, Inputs, ScalarKind};
use host_harness::reference::{self, Method, Options};
use host_harness::reproduce::systems;
use joint_core::joint::Drive;

/// Relative RMS error of every state that is allowed at 25 µs, as the cross-check's 1 %.
const BOUND: f64 = 0.01;

#[test]
fn every_joint_follows_the_reference_in_f64_and_f32() {
    let mut ratios = Vec::new();
    for (file, model) in systems::built_in().unwrap() {
        ratios.push(systems::ratio(&model));
        // Up, a load at the output under way, and back.
        let time_s: Vec<f64> = (0..=800).map(|k| f64::from(k) * 1e-4).collect();
        let volts = |t: f64| if t < 0.05 { 2.0 } else { -1.5 };
        let load = |t: f64| if (0.02..0.04).contains(&t) { 2e-3 } else { 0.0 };
        let inputs = Inputs {
            drive: Drive::Voltage,
            drive_values: time_s.iter().map(|t| volts(*t)).collect(),
            load_nm: time_s.iter().map(|t| load(*t)).collect(),
            time_s,
        };
        let explicit = Options::of(Method::BogackiShampine { step_s: 5e-8 });
        let judge = reference::simulate(&model, &inputs, &explicit).unwrap();
        for scalar in [ScalarKind::F64, ScalarKind::F32] {
            let run = plant::simulate(&model, &inputs, scalar, Some(25e-6), None).unwrap();
            for quantity in Quantity::of(model.stages.len()) {
                let error = quantity.relative_rms(&judge, &run);
                println!("{file} {scalar:?} {quantity:?}: {error:.1e}");
                assert!(error < BOUND, "{file} {scalar:?} {quantity:?}: {error}");
            }
        }
    }
    assert_eq!(ratios, [125.0, 1000.0, 20_480.0]);
}
