//! The reference against what can be worked out by hand, and against itself.

use joint_core::params::{Friction, Load, Motor, Stage};

use super::*;
use crate::model::Sensor;
use crate::quantity::Quantity;
use crate::scenario;

fn rotor(inertia: f64, friction: Friction) -> Model {
    Model {
        name: "rotor".to_owned(),
        motor: Motor {
            phase_resistance_ohm: 2.0,
            phase_inductance_h: 1e-3,
            torque_constant_nm_per_a: 0.1,
            rotor_inertia_kg_m2: inertia,
            friction,
            ..Motor::default()
        },
        stages: Vec::new(),
        load: Load::default(),
        sensor: Sensor::default(),
        effects: Vec::new(),
        friction_levels: Vec::new(),
    }
}

fn bristles() -> Friction {
    Friction {
        sigma0_nm_per_rad: 10.0,
        sigma1_nm_s_per_rad: 0.05,
        sigma2_nm_s_per_rad: 1e-3,
        coulomb_nm: 0.02,
        stribeck_nm: 0.01,
        stribeck_velocity_rad_per_s: 2.0,
    }
}

/// Two masses on a spring through a gear that reverses, without friction.
fn two_masses() -> Model {
    let mut model = rotor(1e-4, Friction::default());
    model.stages.push(Stage {
        reduction: -4.0,
        inertia_kg_m2: 3e-3,
        stiffness_nm_per_rad: 200.0,
        ..Stage::default()
    });
    model
}

fn constant(drive: Drive, value: f64, load: f64, step: f64, samples: u32) -> Inputs {
    let time_s: Vec<f64> = (0..samples).map(|k| f64::from(k) * step).collect();
    let all = |value: f64| vec![value; time_s.len()];
    Inputs { drive, drive_values: all(value), load_nm: all(load), time_s }
}

fn explicit(step_s: f64) -> Options {
    Options::of(Method::BogackiShampine { step_s })
}

#[test]
fn the_current_of_a_held_rotor_rises_exponentially() {
    let model = rotor(1e6, Friction::default());
    let inputs = constant(Drive::Voltage, 3.0, 0.0, 1e-4, 30);
    let stiff = Options::of(Method::Stiff { tolerance: 1e-9 });
    for options in [explicit(1e-6), stiff] {
        let run = simulate(&model, &inputs, &options).unwrap();
        for (snapshot, time) in run.iter().zip(&inputs.time_s) {
            let exact = 0.75 * -(-time * 2.0 / 1e-3_f64).exp_m1();
            assert!((snapshot.current_a - exact).abs() < 1e-7, "{} {exact}", snapshot.current_a);
        }
    }
}

/// d'' = T'/J2' − ω² d from rest: d = T'/(J2' ω²) (1 − cos ωt), with T' = T N, J2' = J N².
fn deflection(time: f64, load: f64) -> (f64, f64) {
    let shaft: f64 = -0.25;
    let (before, after) = (1e-4, 3e-3 * shaft * shaft);
    let square = 200.0 * shaft * shaft * (1.0 / before + 1.0 / after);
    let exact = load * shaft / (after * square) * (1.0 - (square.sqrt() * time).cos());
    (exact * shaft, square.sqrt())
}

#[test]
fn two_masses_ring_at_their_frequency_and_keep_their_energy() {
    let (model, load) = (two_masses(), 0.3);
    let inputs = constant(Drive::Current, 0.0, load, 2e-4, 500);
    let run = simulate(&model, &inputs, &explicit(2e-6)).unwrap();
    let (_, omega) = deflection(0.0, load);
    assert!(omega * inputs.time_s[499] > 30.0, "several periods");
    for (snapshot, time) in run.iter().zip(&inputs.time_s) {
        let stage = snapshot.stages[0];
        assert!((stage.windup_rad - deflection(*time, load).0).abs() < 1e-8);
        let energy = 0.5 * 1e-4 * snapshot.motor_speed_rad_per_s.powi(2)
            + 0.5 * 3e-3 * stage.speed_rad_per_s.powi(2)
            + 0.5 * 200.0 * stage.windup_rad.powi(2);
        assert!((energy + load * stage.angle_rad).abs() < 1e-7 * (1.0 + energy));
    }
}

#[test]
fn the_explicit_method_is_of_third_order() {
    let (model, load) = (two_masses(), 0.3);
    let inputs = constant(Drive::Current, 0.0, load, 2e-4, 200);
    let error = |step: f64| {
        let run = simulate(&model, &inputs, &explicit(step)).unwrap();
        let times = inputs.time_s.iter();
        run.iter()
            .zip(times)
            .map(|(s, t)| (s.stages[0].windup_rad - deflection(*t, load).0).abs())
            .fold(0.0, f64::max)
    };
    let ratio = error(1e-4) / error(5e-5);
    assert!((6.5..10.0).contains(&ratio), "{ratio} where 8 is third order");
}

#[test]
fn sliding_friction_is_the_stribeck_curve_and_the_viscous_part() {
    let model = rotor(1e-3, bristles());
    let inputs = constant(Drive::Current, 0.32, 0.0, 1e-2, 1000);
    let run = simulate(&model, &inputs, &explicit(1e-5)).unwrap();
    let v = run.last().unwrap().motor_speed_rad_per_s;
    let exact = 0.02 + 0.01 * (-(v / 2.0) * (v / 2.0)).exp() + 1e-3 * v;
    assert!(v > 2.0 && (exact - 0.1 * 0.32).abs() < 1e-5, "{v}: {exact}");
}

#[test]
fn below_breakaway_the_rotor_leans_on_its_bristles() {
    let model = rotor(1e-3, bristles());
    let inputs = constant(Drive::Current, 1e-3, 0.0, 1e-2, 100);
    let run = simulate(&model, &inputs, &explicit(1e-5)).unwrap();
    let lean = 0.1 * 1e-3 / 10.0;
    // The bristle is bent to 1/300 of its reach, and creeps by that share of the way travelled,
    // which is some twice the lean while the rotor settles.
    let found = run.last().unwrap().motor_angle_rad;
    assert!((found / lean - 1.0).abs() < 0.01, "{found:e} where {lean:e} is right");
}

#[test]
fn the_two_references_agree_on_every_scenario() {
    let model = scenario::paper();
    for scenario in scenario::ALL {
        let inputs = scenario.lasting(0.04).inputs();
        let run = simulate(&model, &inputs, &Options::default()).unwrap();
        let stiff = Options::of(Method::Stiff { tolerance: 1e-9 });
        let other = simulate(&model, &inputs, &stiff).unwrap();
        for quantity in Quantity::of(2) {
            let error = quantity.relative_rms(&run, &other);
            assert!(error < 1e-4, "{} {quantity}: {error:e}", scenario.name);
        }
    }
}

#[test]
fn twice_the_paper_step_is_silently_wrong_or_fails_at_top_speed() {
    let model = scenario::paper();
    let inputs = constant(Drive::Voltage, 9.0, 0.0, 1e-4, 400);
    let speed = |step: f64| {
        let run = simulate(&model, &inputs, &explicit(step))?;
        Ok::<_, ReferenceError>(run.last().map_or(0.0, |s| s.motor_speed_rad_per_s))
    };
    let right = speed(2.5e-8).unwrap();
    assert!(right > 5000.0);
    assert!(speed(2e-7).is_err() || (speed(2e-7).unwrap() / right - 1.0).abs() > 0.01);
}

#[test]
fn a_winding_without_inductance_takes_its_current_at_once() {
    let mut model = rotor(1e6, Friction::default());
    model.motor.phase_inductance_h = 0.0;
    let run =
        simulate(&model, &constant(Drive::Voltage, 3.0, 0.0, 1e-4, 3), &explicit(1e-5)).unwrap();
    assert!(run[0].current_a == 0.0 && (run[2].current_a - 0.75).abs() < 1e-9);
}

#[test]
fn nonsense_is_refused_without_a_panic() {
    let model = scenario::paper();
    let good = constant(Drive::Voltage, 0.5, 0.0, 1e-4, 5);
    let refused = |inputs: &Inputs, options: &Options| {
        matches!(simulate(&model, inputs, options), Err(ReferenceError::Inputs(_)))
    };
    assert!(refused(&Inputs { time_s: vec![], ..good.clone() }, &explicit(1e-6)));
    assert!(refused(&Inputs { drive_values: vec![1.0], ..good.clone() }, &explicit(1e-6)));
    assert!(refused(&Inputs { time_s: vec![0.0; 5], ..good.clone() }, &explicit(1e-6)));
    assert!(refused(&Inputs { load_nm: vec![f64::NAN; 5], ..good.clone() }, &explicit(1e-6)));
    assert!(refused(&good, &explicit(0.0)) && refused(&good, &explicit(f64::NAN)));
    let mut still = model.clone();
    still.motor.phase_resistance_ohm = 0.0;
    assert_eq!(simulate(&still, &good, &explicit(1e-6)), Err(ReferenceError::NoResistance));
}

#[test]
fn a_step_scaled_to_the_speed_is_as_good_as_converged() {
    let model = scenario::paper();
    for scenario in scenario::ALL {
        let inputs = scenario.lasting(0.05).inputs();
        let run = simulate(&model, &inputs, &Options::of(Method::Scaled { share: 0.4 })).unwrap();
        let finer = simulate(&model, &inputs, &explicit(2.5e-8)).unwrap();
        for quantity in Quantity::of(2) {
            let error = quantity.relative_rms(&finer, &run);
            assert!(error < 1e-4, "{} {quantity}: {error:e}", scenario.name);
        }
    }
}
