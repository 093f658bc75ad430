//! A drive that limits the current, at rest, on the run, and as an imposed current.

use joint_core::effect::{EffectParameters, EffectSet, Kind};
use joint_core::fixed::Fixed;
use joint_core::joint::{Drive, Joint, Method, Settings, State};
use joint_core::params::{Load, Location, Motor};
use joint_core::scalar::Scalar;

const RESISTANCE: f64 = 0.8;
const CONSTANT: f64 = 0.08;
const LIMIT: f64 = 2.5;

fn motor(inertia: f64) -> Motor {
    Motor {
        phase_resistance_ohm: RESISTANCE / 2.0,
        phase_inductance_h: 2e-4,
        torque_constant_nm_per_a: CONSTANT,
        rotor_inertia_kg_m2: inertia,
        ..Motor::default()
    }
}

type Limited<S> = Joint<S, 0, EffectSet<S>>;

/// A step of 50 µs, undivided; 0.5 ms is the winding's time constant.
fn limited<S: Scalar>(inertia: f64, drive: Drive) -> Limited<S> {
    limited_by(None, inertia, drive)
}

fn limited_by<S: Scalar>(method: Option<Method>, inertia: f64, drive: Drive) -> Limited<S> {
    let effects =
        [EffectParameters::new(Kind::CurrentLimit, Location::Inverter).with("limit_a", LIMIT)];
    let settings =
        Settings { micro_steps: Some(1), method, effects: &effects, ..Settings::new(drive, 50e-6) };
    Limited::<S>::new(&motor(inertia), &[], &Load::default(), &settings).unwrap()
}

fn after<S: Scalar>(joint: &Limited<S>, drive: f64, steps: u32) -> State<S, 0> {
    let mut state = joint.rest();
    for _ in 0..steps {
        joint.step(&mut state, joint.input(S::from_f64(drive), S::ZERO));
    }
    state
}

#[test]
fn at_rest_the_current_settles_at_the_equation_however_high_the_voltage() {
    // So heavy that it does not turn.
    let joint = limited::<f64>(1e9, Drive::Voltage);
    for volts in [0.05, 1.0, -2.0, 6.0, 1e4, -1e6] {
        let wanted = LIMIT * (volts / RESISTANCE / LIMIT).tanh();
        let found = joint.current(&after(&joint, volts, 1000));
        assert!((found - wanted).abs() < 1e-7, "{volts}: {found}, {wanted}");
    }
}

#[test]
fn the_winding_follows_the_limit_with_its_own_time_constant() {
    let joint = limited::<f64>(1e9, Drive::Voltage);
    for volts in [0.5, 5.0, 500.0] {
        let settled = LIMIT * (volts / RESISTANCE / LIMIT).tanh();
        let found = joint.current(&after(&joint, volts, 10));
        assert!((found - settled * (1.0 - (-1.0_f64).exp())).abs() < 1e-6, "{volts}: {found}");
    }
}

#[test]
fn far_beyond_the_limit_the_motor_is_a_source_of_current() {
    // Two thousand rad/s in half a second, at a thousandth of the voltage's acceleration; the current
    // takes 0.5 ms of it to come.
    let inertia = CONSTANT * LIMIT / 4000.0;
    let joint = limited::<f64>(inertia, Drive::Voltage);
    let state = after(&joint, 1000.0 * LIMIT * RESISTANCE, 10_000);
    let wanted = 4000.0 * (0.5 - 5e-4);
    let found = joint.speed(&state, 0);
    assert!((found - wanted).abs() < 1e-4 * wanted, "{found}, {wanted}");
    assert!((joint.current(&state) - LIMIT).abs() < 1e-4 * LIMIT);
}

#[test]
fn an_imposed_current_is_limited_as_it_is_asked_for() {
    for method in [Method::Splitting, Method::Implicit] {
        let joint = limited_by::<f64>(Some(method), 1e-4, Drive::Current);
        for asked in [0.01, 1.0, -2.5, 40.0] {
            let wanted = LIMIT * (asked / LIMIT).tanh();
            let found = joint.current(&after(&joint, asked, 3));
            assert!((found - wanted).abs() < 1e-7, "{asked}: {found}, {wanted}");
            assert!((joint.imposed_current(asked) - wanted).abs() < 1e-7);
        }
    }
}

#[test]
fn floats_and_fixed_point_limit_alike() {
    // Friction sets the units of fixed point: eight times its level is the limit's torque.
    let mut motor = motor(1e-4);
    motor.friction.sigma0_nm_per_rad = 20.0;
    motor.friction.coulomb_nm = 0.025;
    motor.friction.sigma2_nm_s_per_rad = 1e-3;
    let effects =
        [EffectParameters::new(Kind::CurrentLimit, Location::Inverter).with("limit_a", LIMIT)];
    let settings = Settings { effects: &effects, ..Settings::new(Drive::Voltage, 50e-6) };
    fn speeds<S: Scalar>(motor: &Motor, settings: &Settings<'_>) -> Vec<f64> {
        let joint = Limited::<S>::new(motor, &[], &Load::default(), settings).unwrap();
        let mut state = joint.rest();
        let run = (0..4000_u32).map(|k| {
            let volts = [6.0, -4.0, 1.0, -12.0][(k / 1000) as usize];
            joint.step(&mut state, joint.input(S::from_f64(volts), S::ZERO));
            joint.speed_rad_per_s(&state, 0)
        });
        run.collect()
    }
    let exact = speeds::<f64>(&motor, &settings);
    let rms = |of: &dyn Fn(usize) -> f64| (0..4000).map(|k| of(k).powi(2)).sum::<f64>().sqrt();
    // As the step is bound to the reference in each.
    for (found, most) in
        [(speeds::<f32>(&motor, &settings), 1e-4), (speeds::<Fixed>(&motor, &settings), 0.02)]
    {
        let error = rms(&|k| found[k] - exact[k]) / rms(&|k| exact[k]);
        assert!(error < most, "{error} of {most}");
    }
}
