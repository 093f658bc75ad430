//! A worm stage, driven by its worm and by its wheel.

use joint_core::effect::EffectSet;
use joint_core::effect::worm::{back_efficiency, efficiency};
use joint_core::joint::{Drive, Joint, Settings, State};
use joint_core::params::{Friction, Load, Motor, Reason, Stage};

const COULOMB: f64 = 1e-3;
const VISCOUS: f64 = 5e-4;
const RATIO: f64 = 20.0;
/// Load at the wheel, Nm.
const LOAD: f64 = 1.0;

fn motor() -> Motor {
    Motor {
        torque_constant_nm_per_a: 0.05,
        rotor_inertia_kg_m2: 1e-5,
        friction: Friction {
            sigma0_nm_per_rad: 5.0,
            sigma1_nm_s_per_rad: 1e-3,
            sigma2_nm_s_per_rad: VISCOUS,
            coulomb_nm: COULOMB,
            ..Friction::default()
        },
        ..Motor::default()
    }
}

fn stage(lead: f64, mu: f64) -> Stage {
    Stage {
        reduction: RATIO,
        inertia_kg_m2: 1e-3,
        stiffness_nm_per_rad: 400.0,
        damping_nm_s_per_rad: 0.2,
        worm_lead_angle_rad: lead,
        worm_friction_coefficient: mu,
        ..Stage::default()
    }
}

type Geared = Joint<f64, 1, EffectSet<f64>>;

/// The joint after two seconds under this current and load.
fn after(stage: Stage, current: f64, load: f64) -> (Geared, State<f64, 1>) {
    let settings = Settings::new(Drive::Current, 1e-4);
    let joint = Geared::new(&motor(), &[stage], &Load::default(), &settings).unwrap();
    let mut state = joint.rest();
    for _ in 0..20_000 {
        joint.step(&mut state, joint.input(current, load));
    }
    (joint, state)
}

#[track_caller]
fn assert_near(found: f64, wanted: f64) {
    assert!((found - wanted).abs() < 1e-3 * wanted.abs(), "{found} for {wanted}");
}

#[test]
fn lifting_takes_the_ideal_torque_over_the_efficiency() {
    let stage = stage(0.15, 0.05);
    let needed = LOAD / RATIO / efficiency(&stage).unwrap() + COULOMB;
    let (joint, state) = after(stage, (needed + 0.02) / 0.05, LOAD);
    assert_near(joint.speed(&state, 0), 0.02 / VISCOUS);
}

#[test]
fn a_load_that_drives_gives_its_torque_times_the_back_efficiency() {
    let stage = stage(0.15, 0.05);
    let given = LOAD / RATIO * back_efficiency(&stage).unwrap() - COULOMB;
    let (joint, state) = after(stage, 0.0, LOAD);
    assert_near(joint.speed(&state, 0), -given / VISCOUS);
}

#[test]
fn a_locking_worm_holds_any_load_and_is_let_down_by_the_motor_alone() {
    let locking = stage(0.05, 0.1);
    assert!(back_efficiency(&locking).unwrap() < 0.0);
    for load in [LOAD, -LOAD, 30.0 * LOAD] {
        let (joint, state) = after(locking, 0.0, load);
        // The bristles carry the whole of it, and nothing creeps.
        assert!(joint.speed(&state, 0).abs() < 1e-9, "{load}: {}", joint.speed(&state, 0));
        assert_near(joint.bristle(&state, 0) * COULOMB, -load / RATIO);
    }
    // With the load, the worm must be pushed by what the mesh holds beyond it.
    let held = LOAD / RATIO * -back_efficiency(&locking).unwrap() + COULOMB;
    let (joint, state) = after(locking, -(held + 0.02) / 0.05, LOAD);
    assert_near(joint.speed(&state, 0), -0.02 / VISCOUS);
    let (joint, state) = after(locking, -(held - 0.002) / 0.05, LOAD);
    assert!(joint.speed(&state, 0).abs() < 1e-3);
}

#[test]
fn a_stage_without_a_lead_angle_is_an_ordinary_one() {
    let (_, plain) = after(stage(0.0, 0.0), 1.5, LOAD);
    let (_, smooth) = after(stage(0.3, 0.0), 1.5, LOAD);
    let turns = [plain, smooth].map(|state| state.angle.to_turns());
    assert!(turns[0] > 1.0 && (turns[0] - turns[1]).abs() < 1e-9 * turns[0], "{turns:?}");
}

#[test]
fn a_worm_is_refused_where_it_would_be_ignored_or_cannot_turn() {
    let settings = Settings::new(Drive::Current, 1e-4);
    let plain = |stage| {
        Joint::<f64, 1>::new(&motor(), &[stage], &Load::default(), &settings).map(drop).unwrap_err()
    };
    assert_eq!(plain(stage(0.1, 0.1)).reason, Reason::NeedsEffectSet);
    assert_eq!(plain(stage(0.0, 0.1)).key, "worm_lead_angle_rad");
    assert!(matches!(plain(stage(1.5, 0.1)).reason, Reason::OutOfRange { .. }));
    let smooth = Motor { friction: Friction::default(), ..motor() };
    let error = Geared::new(&smooth, &[stage(0.1, 0.1)], &Load::default(), &settings).unwrap_err();
    assert_eq!((error.key, error.reason), ("coulomb_nm", Reason::NotPositive));
}
