//! Runs of hours: angles keep their resolution, stick stays where it is.

use joint_core::fixed::Fixed;
use joint_core::joint::{Drive, Joint, Settings, State};
use joint_core::params::{Friction, Load, Motor};
use joint_core::scalar::Scalar;

fn joint<S: Scalar>() -> Joint<S, 0> {
    let motor = Motor {
        phase_resistance_ohm: 4.55,
        phase_inductance_h: 13e-6,
        torque_constant_nm_per_a: 1.38e-3,
        rotor_inertia_kg_m2: 9.5e-10,
        friction: Friction {
            sigma0_nm_per_rad: 0.05,
            sigma1_nm_s_per_rad: 4e-7,
            sigma2_nm_s_per_rad: 1e-9,
            coulomb_nm: 9e-6,
            stribeck_nm: 4e-6,
            stribeck_velocity_rad_per_s: 20.0,
        },
        ..Motor::default()
    };
    let settings = Settings::new(Drive::Voltage, 50e-6);
    Joint::<S, 0>::new(&motor, &[], &Load::default(), &settings).unwrap()
}

fn run<S: Scalar>(joint: &Joint<S, 0>, state: &mut State<S, 0>, volts: f64, steps: u64) {
    let input = joint.input(S::from_f64(volts), S::ZERO);
    for _ in 0..steps {
        joint.step(state, input);
    }
}

/// Turns of the last `steps` of a run at this voltage, after a tenth of them.
fn turned<S: Scalar>(volts: f64, steps: u64) -> f64 {
    let joint = joint::<S>();
    let mut state = joint.rest();
    run(&joint, &mut state, volts, steps / 10);
    let start = state.angle.to_turns();
    run(&joint, &mut state, volts, steps);
    assert_eq!(joint.saturated(&state), 0);
    state.angle.to_turns() - start
}

fn check(steps: u64) {
    let exact = turned::<f64>(1.0, 100_000) * (steps as f64 / 100_000.0);
    // Breakaway is at 0.086 V.
    let (spin_v, stick_v) = (1.0, 0.05);
    let [spin, spin_fixed, stick, stick_fixed] = std::thread::scope(|scope| {
        [
            scope.spawn(|| turned::<f32>(spin_v, steps)),
            scope.spawn(|| turned::<Fixed>(spin_v, steps)),
            scope.spawn(|| turned::<f32>(stick_v, steps)),
            scope.spawn(|| turned::<Fixed>(stick_v, steps)),
        ]
        .map(|run| run.join().unwrap())
    });
    println!("{steps} steps at {spin_v} V: {exact} turns, f32 {spin}, fixed {spin_fixed}");
    for turns in [spin, spin_fixed] {
        assert!((turns / exact - 1.0).abs() < 1e-3, "{turns} of {exact}");
    }
    println!("{steps} steps in stick: f32 {stick} turns, fixed {stick_fixed}");
    for turns in [stick, stick_fixed] {
        assert!(turns.abs() < 1e-6, "crept by {turns} turns");
    }
}

#[test]
fn a_million_steps_neither_lose_turns_nor_creep() {
    check(1_000_000);
}

#[test]
#[ignore = "half a minute: ./check runs it; cargo test -p joint-core --test long_run -- --ignored --nocapture"]
fn a_hundred_million_steps_neither_lose_turns_nor_creep() {
    check(100_000_000);
}
