//! A gear that loses another share of its torque where the load drives it.

use joint_core::effect::{EffectParameters, EffectSet, Kind};
use joint_core::joint::{Drive, Joint, Settings, State};
use joint_core::params::{Friction, Load, Location, Motor, Stage};

const RATIO: f64 = 20.0;
const CONSTANT: f64 = 0.05;
/// Of the rotor, at the motor.
const VISCOUS: f64 = 5e-4;
/// Of the mass behind the gear.
const COULOMB: f64 = 2e-2;
const LOAD: f64 = 1.0;
/// Efficiencies while the motor drives and while the load does.
const EFFICIENCY: [f64; 2] = [0.8, 0.5];

type Geared = Joint<f64, 1, EffectSet<f64>>;

/// The joint after some seconds under this current and load.
fn after(current: f64, load: f64, seconds: u32) -> (Geared, State<f64, 1>) {
    let motor = Motor {
        torque_constant_nm_per_a: CONSTANT,
        rotor_inertia_kg_m2: 1e-5,
        friction: Friction { sigma2_nm_s_per_rad: VISCOUS, ..Friction::default() },
        ..Motor::default()
    };
    let stage = Stage {
        reduction: RATIO,
        inertia_kg_m2: 1e-3,
        stiffness_nm_per_rad: 400.0,
        damping_nm_s_per_rad: 0.2,
        friction: Friction {
            sigma0_nm_per_rad: 400.0,
            sigma1_nm_s_per_rad: 0.1,
            coulomb_nm: COULOMB,
            ..Friction::default()
        },
        ..Stage::default()
    };
    let effects = [EffectParameters::new(Kind::DriveEfficiency, Location::Stage(1))
        .with("driving", 1.0 - EFFICIENCY[0])
        .with("driven", 1.0 / EFFICIENCY[1] - 1.0)];
    let settings = Settings { effects: &effects, ..Settings::new(Drive::Current, 1e-4) };
    let joint = Geared::new(&motor, &[stage], &Load::default(), &settings).unwrap();
    let mut state = joint.rest();
    for _ in 0..10_000 * seconds {
        joint.step(&mut state, joint.input(current, load));
    }
    (joint, state)
}

#[track_caller]
fn assert_near(found: f64, wanted: f64) {
    assert!((found - wanted).abs() < 1e-3 * wanted.abs(), "{found} for {wanted}");
}

#[test]
fn lifting_takes_the_load_and_the_friction_over_the_efficiency() {
    for way in [1.0, -1.0] {
        let needed = (LOAD + COULOMB) / EFFICIENCY[0] / RATIO;
        let (joint, state) = after(way * (needed + 0.02) / CONSTANT, way * LOAD, 2);
        assert_near(joint.speed(&state, 0), way * 0.02 / VISCOUS);
    }
}

#[test]
fn a_load_that_drives_is_felt_at_the_motor_by_the_back_efficiency() {
    for way in [1.0, -1.0] {
        let given = (LOAD - COULOMB) * EFFICIENCY[1] / RATIO;
        let (joint, state) = after(0.0, way * LOAD, 2);
        assert_near(joint.speed(&state, 0), -way * given / VISCOUS);
    }
}

#[test]
fn a_load_between_both_efficiencies_stays_where_it_is() {
    // The motor's torque neither lifts it nor lets it down.
    let [lifts, lets] = [LOAD / EFFICIENCY[0], LOAD * EFFICIENCY[1]];
    let current = 0.5 * (lifts + lets) / RATIO / CONSTANT;
    let [early, late] = [2, 4].map(|seconds| after(current, LOAD, seconds).1.angle.to_turns());
    assert!((early - late).abs() < 1e-6, "{early} {late}");
}
