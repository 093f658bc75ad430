//! The implicit method against the splitting, and where only it can go.

use joint_core::effect::{EffectParameters, EffectSet, Kind};
use joint_core::joint::{Drive, Joint, Method, Settings, State};
use joint_core::params::{Friction, Load, Location, Motor, Stage};
use joint_core::scalar::Scalar;

const STEP_S: f64 = 50e-6;

const MOTOR: Motor = Motor {
    phase_resistance_ohm: 4.55,
    phase_inductance_h: 13e-6,
    torque_constant_nm_per_a: 1.38e-3,
    phase_back_emf_constant_v_s_per_rad: None,
    pole_pairs: 1,
    rotor_inertia_kg_m2: 9.5e-10,
    friction: Friction {
        sigma0_nm_per_rad: 0.05,
        sigma1_nm_s_per_rad: 4e-7,
        sigma2_nm_s_per_rad: 1e-9,
        coulomb_nm: 9e-6,
        stribeck_nm: 4e-6,
        stribeck_velocity_rad_per_s: 20.0,
    },
};

fn stages(stiffness: [f64; 2]) -> [Stage; 2] {
    let stage = |inertia_kg_m2, stiffness_nm_per_rad, coulomb_nm| Stage {
        reduction: 32.0,
        inertia_kg_m2,
        stiffness_nm_per_rad,
        friction: Friction {
            sigma0_nm_per_rad: 2e4 * coulomb_nm,
            sigma1_nm_s_per_rad: 0.1 * coulomb_nm,
            sigma2_nm_s_per_rad: 1e-4 * coulomb_nm,
            coulomb_nm,
            stribeck_nm: 0.4 * coulomb_nm,
            stribeck_velocity_rad_per_s: 0.6,
        },
        ..Stage::default()
    };
    [stage(2e-9, stiffness[0], 8e-5), stage(8e-7, stiffness[1], 1e-3)]
}

const SOFT: [f64; 2] = [0.35, 15.0];
/// No drive can follow what swings here.
const STIFF: [f64; 2] = [0.35, 7e6];

fn joint<S: Scalar>(
    stiffness: [f64; 2],
    method: Option<Method>,
    micro_steps: Option<u32>,
    effects: &[EffectParameters],
) -> Joint<S, 2, EffectSet<S>> {
    let settings =
        Settings { method, micro_steps, effects, ..Settings::new(Drive::Voltage, STEP_S) };
    Joint::<S, 2, EffectSet<S>>::new(&MOTOR, &stages(stiffness), &Load::default(), &settings)
        .unwrap()
}

/// Speeds at the motor, rad/s, every millisecond of a run that starts, reverses and rests.
fn run<S: Scalar>(joint: &Joint<S, 2, EffectSet<S>>) -> (Vec<[f64; 3]>, State<S, 2>) {
    let (mut state, mut speeds) = (joint.rest(), Vec::new());
    for k in 0..1200_u32 {
        let volts = [1.0, -0.6, 0.0][(k / 400) as usize];
        joint.step(&mut state, joint.input(S::from_f64(volts), S::from_f64(1e-3)));
        if k % 20 == 0 {
            speeds.push([0, 1, 2].map(|mass| joint.speed_rad_per_s(&state, mass)));
        }
    }
    (speeds, state)
}

fn apart(one: &[[f64; 3]], other: &[[f64; 3]], which: usize) -> f64 {
    let square = |of: &dyn Fn(usize) -> f64| (0..one.len()).map(|k| of(k).powi(2)).sum::<f64>();
    (square(&|k| one[k][which] - other[k][which]) / square(&|k| other[k][which])).sqrt()
}

#[test]
fn both_methods_agree_where_both_are_fine_and_the_implicit_one_is_of_second_order() {
    let (exact, _) = run(&joint::<f64>(SOFT, Some(Method::Splitting), Some(64), &[]));
    let of = |n| run(&joint::<f64>(SOFT, Some(Method::Implicit), Some(n), &[])).0;
    let errors = [1, 2, 4, 8].map(|n| apart(&of(n), &exact, 0));
    assert!(errors[0] < 1e-2 && errors[3] < 1e-4, "{errors:?}");
    assert!(errors[1] > 3.0 * errors[2] && errors[2] > 3.0 * errors[3], "{errors:?}");
}

#[test]
fn a_gear_too_stiff_to_swing_moves_as_one_that_is_rigid() {
    let joint32 = joint::<f32>(STIFF, None, None, &[]);
    assert_eq!(joint32.method(), Method::Implicit);
    let (stiff, state) = run(&joint32);
    // A hundred times softer, which the splitting follows well.
    let soft = joint::<f64>([0.35, 7e2], Some(Method::Splitting), Some(64), &[]);
    let (exact, _) = run(&soft);
    assert!(apart(&stiff, &exact, 0) < 0.002);
    // Both sides of the stiff spring, at the motor.
    let sides: Vec<[f64; 3]> = stiff.iter().map(|speeds| [speeds[1], speeds[2], 0.0]).collect();
    let before: Vec<[f64; 3]> = sides.iter().map(|sides| [sides[1], 0.0, 0.0]).collect();
    assert!(apart(&sides, &before, 0) < 1e-3);
    // At rest in the end, and it stays.
    let angle = state.angle.to_turns();
    let mut later = state;
    for _ in 0..20_000 {
        joint32.step(&mut later, joint32.input(0.0, 1e-3));
    }
    assert!((later.angle.to_turns() - angle).abs() < 1e-3, "{angle} {:?}", later.angle);
}

/// Every effect at every place where it may act, of the size of its example.
#[test]
fn effects_act_in_both_methods_alike() {
    let both = |effects: &[EffectParameters]| {
        [Method::Splitting, Method::Implicit]
            .map(|method| run(&joint::<f64>(SOFT, Some(method), Some(16), effects)).0)
    };
    let [plain, _] = both(&[]);
    let places = [
        Location::Motor,
        Location::Stage(1),
        Location::Stage(2),
        Location::Output,
        Location::Inverter,
    ];
    for &kind in Kind::ALL {
        for location in places {
            if !EffectParameters::admits(kind, location, 2) {
                continue;
            }
            let [exact, found] =
                both(&[EffectParameters { location, ..EffectParameters::example(kind) }]);
            assert_ne!(exact, plain, "{kind:?} at {location:?} does nothing");
            // What was found of gravity on the rotor and of backlash behind it, and a half more.
            for (mass, bound) in [1e-4, 3e-3, 6e-3].into_iter().enumerate() {
                let error = apart(&found, &exact, mass);
                assert!(error < bound, "{kind:?} at {location:?}, {mass}: {error}");
            }
        }
    }
}

#[test]
fn a_state_may_go_from_one_method_to_the_other() {
    let joints = [Method::Splitting, Method::Implicit]
        .map(|method| joint::<f64>(SOFT, Some(method), Some(64), &[]));
    let [mut alone, mut shared] = [joints[0].rest(); 2];
    for k in 0..400 {
        let input = joints[0].input(1.0, 0.0);
        joints[0].step(&mut alone, input);
        joints[k / 20 % 2].step(&mut shared, input);
    }
    let [one, other] = [alone, shared].map(|state| joints[0].speed_rad_per_s(&state, 0));
    assert!((one - other).abs() < 2e-3 * one.abs(), "{one} {other}");
}
