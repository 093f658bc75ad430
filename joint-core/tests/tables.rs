//! Laws with a table in every number format, over many turns and both ways.

use joint_core::effect::{EffectParameters, EffectSet, Kind};
use joint_core::fixed::Fixed;
use joint_core::joint::{Drive, Joint, Settings};
use joint_core::params::{Friction, Load, Location, Motor, Reason, Stage};
use joint_core::scalar::Scalar;

fn friction(coulomb_nm: f64) -> Friction {
    Friction {
        sigma0_nm_per_rad: 500.0 * coulomb_nm,
        sigma1_nm_s_per_rad: 0.5 * coulomb_nm,
        sigma2_nm_s_per_rad: 0.002 * coulomb_nm,
        coulomb_nm,
        stribeck_nm: 0.3 * coulomb_nm,
        ..Friction::default()
    }
}

/// Speeds of the motor, rad/s, over a second there and half of one back.
fn speeds<S: Scalar>(effects: &[EffectParameters]) -> Vec<f64> {
    let motor = Motor {
        phase_resistance_ohm: 0.5,
        phase_inductance_h: 1e-4,
        torque_constant_nm_per_a: 0.05,
        rotor_inertia_kg_m2: 2e-5,
        friction: friction(4e-3),
        ..Motor::default()
    };
    let stage = Stage {
        reduction: -5.0,
        inertia_kg_m2: 2e-4,
        stiffness_nm_per_rad: 60.0,
        friction: friction(2e-2),
        ..Stage::default()
    };
    let settings = Settings { effects, ..Settings::new(Drive::Voltage, 1e-4) };
    let joint =
        Joint::<S, 1, EffectSet<S>>::new(&motor, &[stage], &Load::default(), &settings).unwrap();
    let mut state = joint.rest();
    let run = (0..15_000).map(|k| {
        let volts = if k < 10_000 { 2.0 } else { -2.5 };
        joint.step(&mut state, joint.input(S::from_f64(volts), S::ZERO));
        joint.speed_rad_per_s(&state, 0)
    });
    run.collect()
}

fn apart(one: &[f64], other: &[f64]) -> f64 {
    let square = |of: &dyn Fn(usize) -> f64| (0..one.len()).map(|k| of(k).powi(2)).sum::<f64>();
    (square(&|k| one[k] - other[k]) / square(&|k| other[k])).sqrt()
}

fn tabled(kind: Kind, place: Location, curves: [&[f64]; 2]) -> EffectParameters {
    EffectParameters::new(kind, place).with_table(curves[0], curves[1]).unwrap()
}

#[test]
fn every_format_looks_up_the_same_torque_and_the_same_level() {
    let map = |place, size: f64| {
        let knots = [0.0, 1.0, 0.4, -0.7, -0.2, 0.5].map(|knot| size * knot);
        tabled(Kind::TorqueMap, place, [&knots, &[]])
    };
    let course = [&[0.5, -0.4, 0.9, 0.0][..], &[-0.2, 0.6, 0.0, 0.3]];
    let course = |place| tabled(Kind::FrictionCourse, place, course);
    let plain = speeds::<f64>(&[]);
    for effects in [
        vec![map(Location::Motor, 4e-3).with("period_rad", 2.0)],
        vec![map(Location::Output, 2e-2).with("start_rad", -25.0).with("span_rad", 25.0)],
        vec![map(Location::Motor, -3e-3).with("speed_rad_per_s", 40.0)],
        vec![course(Location::Stage(1)).with("start_rad", -15.0).with("span_rad", 12.0)],
        vec![course(Location::Motor).with("period_rad", 1.3)],
        vec![map(Location::Output, 1e-2).with("period_rad", 3.0)],
    ] {
        let exact = speeds::<f64>(&effects);
        let moved = apart(&exact, &plain);
        assert!(moved > 5e-3, "{effects:?} changes nothing: {moved}");
        // Of rounding, over a run in which every turn repeats; and what fixed point is held to.
        let [single, fixed] = [speeds::<f32>(&effects), speeds::<Fixed>(&effects)];
        let [single, fixed] = [single, fixed].map(|found| apart(&found, &exact));
        assert!(single < 2e-3 && fixed < 0.02, "{effects:?}: {single}, {fixed}");
    }
}

#[test]
fn a_joint_takes_one_table() {
    let map = tabled(Kind::TorqueMap, Location::Motor, [&[0.0, 1e-3], &[]]);
    let map = map.with("period_rad", 1.0);
    let check = |count: usize| joint_core::effect::validate(&vec![map; count], 0);
    assert_eq!(check(1), Ok(()));
    assert_eq!(check(2).unwrap_err().reason, Reason::TooManyTables { most: 1 });
}
