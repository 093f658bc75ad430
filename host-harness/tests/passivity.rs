//! LuGre friction that gives nothing back, and where it would.

use host_harness::energy::Ledger;
use host_harness::grid::Grid;
use host_harness::model::Model;
use host_harness::plant::{self, Layout};
use host_harness::scenario;
use joint_core::joint::Drive;
use joint_core::params::{Friction, Motor};
use proptest::prelude::*;

/// Work that friction takes beside what its bristles store, J, and what is moved to and fro, along speeds
/// that are held for a step each, on a rotor too heavy to follow.
fn taken(friction: Friction, speeds: &[f64], step: f64) -> [f64; 2] {
    let motor = Motor { rotor_inertia_kg_m2: 1e15, friction, ..scenario::paper().motor };
    let model = Model { motor, stages: vec![], effects: vec![], ..scenario::paper() };
    let grid = Grid::new(&[0.0, step], None);
    let plant = plant::plant(&model, &grid, Drive::Current).unwrap();
    let (ledger, layout) = (Ledger::new(&model), Layout::of(&model));
    let mut state = vec![0.0; layout.len()];
    let [mut work, mut moved] = [0.0; 2];
    for speed in speeds {
        // The bristle at both ends of the step, at the speed that it is moved with.
        let at = |state: &mut Vec<f64>| {
            state[layout.speed(0)] = *speed;
            ledger.friction_of(0, state)
        };
        let before = at(&mut state);
        plant.propagate(0, &mut state, 0.0, 0.0);
        let after = at(&mut state);
        work += 0.5 * (before + after) * step;
        moved += 0.5 * (before.abs() + after.abs()) * step;
    }
    [work - ledger.bristles_of(0, &state), moved]
}

fn friction() -> impl Strategy<Value = Friction> {
    let levels = (1e-3..0.5_f64, -0.8..3.0_f64);
    (levels, 0.01..10.0_f64, 1e-4..10.0_f64, 0.1..20.0_f64, 0.0..1e-2_f64).prop_map(
        |((coulomb_nm, beta), reach, damping, stribeck_velocity_rad_per_s, viscous)| Friction {
            sigma0_nm_per_rad: coulomb_nm / reach,
            sigma1_nm_s_per_rad: damping * coulomb_nm,
            sigma2_nm_s_per_rad: viscous * coulomb_nm,
            coulomb_nm,
            stribeck_nm: beta * coulomb_nm,
            stribeck_velocity_rad_per_s,
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(100) })]

    /// Jumps of the speed by any share of what it may be, each held for a part of the bristles' reach.
    #[test]
    fn up_to_its_speed_friction_gives_nothing_back(
        friction in friction(), shares in prop::collection::vec(-1.0..1.0_f64, 4..12),
    ) {
        let most = friction.passive_to_rad_per_s().min(100.0 * friction.stribeck_velocity_rad_per_s);
        let step = 0.01 * friction.coulomb_nm / friction.sigma0_nm_per_rad / most;
        let speeds: Vec<f64> =
            shares.iter().flat_map(|share| vec![share * most; 150]).collect();
        let [taken, moved] = taken(friction, &speeds, step);
        // The trapezoid over a hundredth of the reach.
        prop_assert!(taken >= -1e-3 * moved, "{taken} of {moved}");
    }
}

#[test]
fn far_beyond_that_speed_bristles_let_go_at_once_give_back_more_than_they_stored() {
    let friction = Friction {
        sigma0_nm_per_rad: 100.0,
        sigma1_nm_s_per_rad: 0.01,
        sigma2_nm_s_per_rad: 0.0,
        coulomb_nm: 0.1,
        stribeck_nm: 0.1,
        stribeck_velocity_rad_per_s: 1.0,
    };
    let limit = friction.passive_to_rad_per_s();
    assert!((limit - 40.0).abs() < 1e-9);
    // Bent slowly as far as they go, then carried on twenty times as fast for a quarter of their reach.
    let jumped = |speed: f64| {
        let step = 1e-5 / speed;
        let slow = vec![0.2; (5e-3 / 0.2 / step) as usize];
        let fast = vec![speed; (2.5e-4 / speed / step) as usize];
        taken(friction, &[slow, fast].concat(), step)[0]
    };
    assert!(jumped(limit) > 0.0);
    assert!(jumped(20.0 * limit) < 0.0);
}
