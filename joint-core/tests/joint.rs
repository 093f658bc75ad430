//! The assembled joint from outside.

use joint_core::effect::{EffectParameters, EffectSet, Kind};
use joint_core::joint::{Drive, Joint, Method, Settings};
use joint_core::params::{Friction, Load, Location, Motor, Reason, Stage};

fn motor() -> Motor {
    Motor {
        phase_resistance_ohm: 0.4,
        phase_inductance_h: 2e-4,
        torque_constant_nm_per_a: 0.08,
        rotor_inertia_kg_m2: 4e-5,
        ..Motor::default()
    }
}

fn friction() -> Friction {
    Friction {
        sigma0_nm_per_rad: 10.0,
        sigma1_nm_s_per_rad: 0.01,
        coulomb_nm: 0.01,
        ..Friction::default()
    }
}

fn damped(damping: f64) -> Stage {
    Stage {
        reduction: 2.0,
        inertia_kg_m2: 4e-4,
        stiffness_nm_per_rad: 40.0,
        damping_nm_s_per_rad: damping,
        ..Stage::default()
    }
}

/// Speed of the last mass after 20 ms of one volt on a chain with two dampers.
fn speed_after(step_s: f64) -> f64 {
    let settings = Settings { micro_steps: Some(1), ..Settings::new(Drive::Voltage, step_s) };
    let stages = [damped(0.03), damped(0.06)];
    let joint = Joint::<f64, 2, ()>::new(&motor(), &stages, &Load::default(), &settings).unwrap();
    let mut state = joint.rest();
    for _ in 0..(0.02 / step_s).round() as u32 {
        joint.step(&mut state, joint.input(1.0, 0.0));
    }
    joint.speed(&state, 2)
}

#[test]
fn two_dampers_leave_no_error_of_first_order() {
    let exact = speed_after(1.5625e-6);
    let errors = [2e-4, 1e-4, 5e-5].map(|step| (speed_after(step) - exact).abs());
    for pair in errors.windows(2) {
        assert!(pair[0] / pair[1] > 3.0, "halving the step divides the error by less: {errors:?}");
    }
}

#[test]
fn dead_time_leaves_an_imposed_current_alone() {
    let dead = [EffectParameters::new(Kind::DeadTime, Location::Inverter)
        .with("voltage_v", 0.5)
        .with("softening_a", 0.01)];
    let motor = Motor { friction: friction(), ..motor() };
    let run = |method, effects: &[EffectParameters]| {
        let method = Some(method);
        let settings = Settings { method, effects, ..Settings::new(Drive::Current, 1e-4) };
        let joint =
            Joint::<f64, 0, EffectSet<f64>>::new(&motor, &[], &Load::default(), &settings).unwrap();
        let mut state = joint.rest();
        for _ in 0..100 {
            joint.step(&mut state, joint.input(0.5, 0.0));
        }
        (joint.current(&state), joint.speed(&state, 0))
    };
    for method in [Method::Splitting, Method::Implicit] {
        assert_eq!(run(method, &dead), run(method, &[]));
        assert!((run(method, &[]).0 - 0.5).abs() < 1e-12);
    }
}

#[test]
fn a_plain_joint_refuses_the_gravity_it_would_ignore() {
    let load = Load { gravity_nm: 0.1, ..Load::default() };
    let settings = Settings::new(Drive::Voltage, 1e-4);
    let error = Joint::<f64, 0, ()>::new(&motor(), &[], &load, &settings).unwrap_err();
    assert_eq!((error.key, error.reason), ("gravity_nm", Reason::NeedsEffectSet));
}

#[test]
fn a_joint_pushed_below_breakaway_stays_where_it_is() {
    let motor = Motor { friction: friction(), ..motor() };
    let settings = Settings::new(Drive::Current, 1e-4);
    let joint = Joint::<f32, 0, ()>::new(&motor, &[], &Load::default(), &settings).unwrap();
    let mut state = joint.rest();
    let push = 0.5 * 0.01 / 0.08;
    for _ in 0..1000 {
        joint.step(&mut state, joint.input(push, 0.0));
    }
    let stuck = state.angle.to_turns();
    for _ in 0..100_000 {
        joint.step(&mut state, joint.input(push, 0.0));
    }
    assert!((state.angle.to_turns() - stuck).abs() < 1e-7);
}

/// What is missed of a free spring between two masses, of its first deflection, after 16 rad in so many steps.
fn phase_missed(steps: u32) -> f64 {
    let stage = Stage { reduction: 1.0, damping_nm_s_per_rad: 0.0, ..damped(0.0) };
    let pulsation = (40.0 * (1.0 / 4e-5 + 1.0 / 4e-4_f64)).sqrt();
    let settings = Settings {
        micro_steps: Some(1),
        ..Settings::new(Drive::Current, 16.0 / pulsation / f64::from(steps))
    };
    let joint = Joint::<f64, 1, ()>::new(&motor(), &[stage], &Load::default(), &settings).unwrap();
    let mut state = joint.rest();
    joint.set_deflection(&mut state, 0, 1e-3);
    joint.refresh(&mut state);
    for _ in 0..steps {
        joint.step(&mut state, joint.input(0.0, 0.0));
    }
    (joint.deflection_rad(&state, 0) / 1e-3 - 16.0_f64.cos()).abs()
}

#[test]
fn a_free_vibration_is_of_fourth_order() {
    let [coarse, fine] = [20, 40].map(phase_missed);
    assert!(coarse < 1e-2 && coarse > 14.0 * fine, "{coarse} {fine}");
}

/// What is missed of the speeds of two masses that swing on their bristles, over them, after 5 ms in so many steps.
fn swing_missed(steps: u32) -> [f64; 2] {
    let swing = |steps: u32| {
        let friction = Friction { sigma1_nm_s_per_rad: 0.0, coulomb_nm: 1e3, ..friction() };
        let motor = Motor { friction, ..motor() };
        let stage = Stage { friction, ..damped(0.0) };
        let step_s = 5e-3 / f64::from(steps);
        let settings = Settings { micro_steps: Some(1), ..Settings::new(Drive::Current, step_s) };
        let joint = Joint::<f64, 1, ()>::new(&motor, &[stage], &Load::default(), &settings);
        let (joint, [one, other]) = (joint.unwrap(), [5e-5, -8e-5]);
        let mut state = joint.rest();
        joint.set_bristle(&mut state, 0, one);
        joint.set_bristle(&mut state, 1, other);
        joint.refresh(&mut state);
        for _ in 0..steps {
            joint.step(&mut state, joint.input(0.0, 0.0));
        }
        [0, 1].map(|mass| joint.speed(&state, mass))
    };
    let (found, exact) = (swing(steps), swing(64 * steps));
    [0, 1].map(|mass: usize| (found[mass] / exact[mass] - 1.0).abs())
}

#[test]
fn a_swing_on_bristles_is_of_fourth_order_too() {
    let [coarse, fine] = [6, 12].map(swing_missed);
    for (coarse, fine) in coarse.into_iter().zip(fine) {
        assert!(coarse < 1e-2 && coarse > 12.0 * fine, "{coarse} {fine}");
    }
}
