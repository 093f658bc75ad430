//! Energy over every scenario, and friction that never creates any.

use host_harness::energy::Ledger;
use host_harness::grid::Grid;
use host_harness::model::Model;
use host_harness::plant::{self, Inputs, Layout, Plant};
use host_harness::reproduce::{driven, prescribed, scene, systems};
use host_harness::scenario::{self, GRID_S, Scenario};
use joint_core::effect::{EffectParameters, Kind};
use joint_core::joint::Drive;
use joint_core::params::{Friction, Location, Motor};
use proptest::prelude::*;

/// Steps in one interval of a scenario's grid.
const FINE: usize = 100;

fn plant(model: &Model, drive: Drive, step_s: f64) -> (Box<dyn Plant>, Vec<f64>) {
    let grid = Grid::new(&[0.0, step_s], None);
    (plant::plant(model, &grid, drive).unwrap(), vec![0.0; Layout::of(model).len()])
}

/// What is put in, what it became, and the least work of any mass's friction.
struct Audit {
    electrical: f64,
    explained: f64,
    scale: f64,
    least_friction: f64,
}

fn audit(model: &Model, scenario: &Scenario) -> Audit {
    let Inputs { drive_values, load_nm, .. } = scenario.inputs();
    let step = GRID_S / FINE as f64;
    let (plant, mut state) = plant(model, Drive::Voltage, step);
    let ledger = Ledger::new(model);
    let masses = model.stages.len() + 1;
    let (mut electrical, mut scale, mut spent) = (0.0, 0.0, 0.0);
    let mut rubbed = vec![0.0; masses];
    for (volts, load) in drive_values.iter().zip(&load_nm) {
        for _ in 0..FINE {
            let before = (state.clone(), ledger.powers(&state));
            plant.propagate(0, &mut state, *volts, *load);
            let after = ledger.powers(&state);
            // The trapezoid rule, on steps far below the winding's 3 us.
            let mean = |a: f64, b: f64| 0.5 * (a + b) * step;
            let work = volts * mean(before.0[Layout::CURRENT], state[Layout::CURRENT]);
            electrical += work;
            scale += work.abs();
            spent += mean(before.1.winding, after.winding)
                + mean(before.1.dampers, after.dampers)
                + mean(before.1.friction, after.friction)
                + mean(before.1.coating, after.coating)
                + load * mean(before.1.load_per_nm, after.load_per_nm);
            for (mass, sum) in rubbed.iter_mut().enumerate() {
                let [a, b] = [&before.0, &state].map(|state| ledger.friction_of(mass, state));
                *sum += mean(a, b);
            }
        }
    }
    let least = (0..masses).map(|mass| rubbed[mass] - ledger.bristles_of(mass, &state));
    Audit {
        electrical,
        explained: spent + ledger.stored(&state).outside_friction(),
        scale,
        least_friction: least.fold(f64::INFINITY, f64::min),
    }
}

#[test]
fn over_every_scenario_electrical_work_is_heat_stored_and_work_on_the_load() {
    for scenario in &scenario::ALL {
        let found = audit(&scenario::paper(), scenario);
        let apart = (found.electrical - found.explained).abs() / found.scale;
        println!("{}: {apart:.1e} of {:.2e} J", scenario.name, found.scale);
        assert!(apart < 1e-3, "{}: {} for {}", scenario.name, found.explained, found.electrical);
        assert!(found.least_friction > -1e-9 * found.scale, "{}", scenario.name);
    }
}

#[test]
fn in_the_gears_of_125_and_1000_and_the_whole_joint_energy_is_kept_as_well() {
    for (file, model) in systems::built_in().unwrap() {
        // Full speed one way and the other, with the load's step.
        for scenario in
            scenario::ALL.iter().filter(|one| ["trapezoid", "step-load"].contains(&one.name))
        {
            let found = audit(&model, scenario);
            let apart = (found.electrical - found.explained).abs() / found.scale;
            println!("{file}, {}: {apart:.1e} of {:.2e} J", scenario.name, found.scale);
            assert!(apart < 1e-3, "{file}, {}: {apart}", scenario.name);
            assert!(found.least_friction > -1e-9 * found.scale, "{file}, {}", scenario.name);
        }
    }
}

#[test]
fn behind_a_prescribed_motor_what_its_shaft_puts_in_is_heat_stored_and_work_on_the_load() {
    let model = scenario::paper();
    let (ledger, layout) = (Ledger::new(&model), Layout::of(&model));
    for (file, scene) in scene::built_in().unwrap() {
        // At the first stage's input: its torque times the prescribed speed; the rotor is outside.
        let power = |t: f64, state: &[f64]| {
            let powers = ledger.powers(state);
            let shaft = ledger.stage_torque(0, state) * state[layout.speed(0)];
            let friction = powers.friction - ledger.friction_of(0, state);
            [shaft, powers.dampers + friction + scene.load.at(t) * powers.load_per_nm]
        };
        let stored = |state: &[f64]| {
            let rotor = 0.5 * model.motor.rotor_inertia_kg_m2 * state[layout.speed(0)].powi(2);
            ledger.stored(state).outside_friction() - rotor
        };
        let (mut put_in, mut spent, mut scale) = (0.0, 0.0, 0.0);
        let mut last: Option<(f64, [f64; 2], f64)> = None;
        prescribed::watched(&model, &scene, |t, state| {
            let state = ledger.of_reference(state);
            let now = power(t, &state);
            if let Some((before, old, _)) = last {
                let mean = |k: usize| 0.5 * (old[k] + now[k]) * (t - before);
                put_in += mean(0);
                spent += mean(1);
                scale += mean(0).abs();
            }
            last = Some((t, now, stored(&state)));
        })
        .unwrap();
        let left = last.unwrap().2;
        let apart = (put_in - spent - left).abs() / scale;
        println!("{file}: {apart:.1e} of {scale:.2e} J");
        assert!(apart < 1e-3, "{file}: {put_in} for {spent} and {left}");
    }
}

#[test]
fn behind_the_six_step_motor_the_bus_pays_for_heat_and_the_shaft() {
    let amplifier = driven::amplifier().unwrap();
    for (file, scene) in scene::built_in().unwrap() {
        let trace = driven::run(&scenario::paper(), &amplifier, &scene).unwrap();
        let last = |series: &[f64]| *series.last().unwrap();
        let [bus, heat, shaft] =
            [&trace.bus_work_j, &trace.winding_heat_j, &trace.shaft_work_j].map(|s| last(s));
        let apart = (bus - heat - shaft).abs() / bus;
        println!("{file}: {apart:.1e} of {bus:.2e} J");
        assert!(apart < 1e-3, "{file}: {bus} for {heat} and {shaft}");
    }
}

#[test]
fn a_coating_bent_in_a_closed_cycle_takes_work_and_never_gives_any() {
    // A strong motor swings the output by a sine of the current; friction is next to none.
    let coating = EffectParameters::new(Kind::Coating, Location::Output)
        .with("stiffness_nm_per_rad", 0.02)
        .with("cubic_stiffness_nm_per_rad3", 0.01)
        .with("hysteresis_nm", 2e-3)
        .with("width_rad", 0.05);
    let rotor = Motor {
        torque_constant_nm_per_a: 0.01,
        rotor_inertia_kg_m2: 1e-5,
        ..scenario::paper().motor
    };
    let motor = Motor { friction: Friction::default(), ..rotor };
    let model = Model { motor, stages: vec![], effects: vec![coating], ..scenario::paper() };
    let step = 1e-5;
    let (plant, mut state) = plant(&model, Drive::Current, step);
    let layout = Layout::of(&model);
    let period = 0.2;
    let (mut taken, mut kinetic) = (Vec::new(), Vec::new());
    for _cycle in 0..25 {
        let mut work = 0.0;
        let start = 0.5 * 1e-5 * state[layout.speed(0)].powi(2);
        for k in 0..(period / step).round() as usize {
            let current = (std::f64::consts::TAU * (k as f64 + 0.5) * step / period).sin();
            let before = state[Layout::ANGLE];
            plant.propagate(0, &mut state, current, 0.0);
            work += 0.01 * current * (state[Layout::ANGLE] - before);
        }
        taken.push(work);
        kinetic.push(0.5 * 1e-5 * state[layout.speed(0)].powi(2) - start);
    }
    // Once the cycle repeats, what the motor puts in is what the loop turns to heat.
    let closed = taken.last().unwrap();
    assert!(kinetic.last().unwrap().abs() < 0.05 * closed, "{kinetic:?}");
    assert!(*closed > 0.0 && *closed < 4.0 * 2e-3 * 2.0, "{taken:?}");
}

fn friction() -> impl Strategy<Value = Friction> {
    (1e-2..10.0_f64, 1e-3..0.5_f64, 0.0..1.0_f64, 0.1..20.0_f64, 0.0..1e-2_f64).prop_map(
        |(reach, coulomb_nm, beta, stribeck_velocity_rad_per_s, sigma2)| Friction {
            sigma0_nm_per_rad: 100.0 * coulomb_nm / reach,
            sigma1_nm_s_per_rad: 1e-3 * coulomb_nm,
            sigma2_nm_s_per_rad: sigma2,
            coulomb_nm,
            stribeck_nm: beta * coulomb_nm,
            stribeck_velocity_rad_per_s,
        },
    )
}

/// A rotor so heavy that its speed stays what it is set to.
fn flywheel(friction: Friction) -> Model {
    let motor = Motor { rotor_inertia_kg_m2: 1e15, friction, ..scenario::paper().motor };
    Model { motor, stages: vec![], ..scenario::paper() }
}

/// Friction torque over a path of speeds, Nm, at every step.
fn torques(friction: Friction, speeds: &[f64], step: f64) -> Vec<f64> {
    let model = flywheel(friction);
    let (plant, mut state) = plant(&model, Drive::Current, step);
    let (ledger, layout) = (Ledger::new(&model), Layout::of(&model));
    let torque = speeds.iter().map(|speed| {
        state[layout.speed(0)] = *speed;
        plant.propagate(0, &mut state, 0.0, 0.0);
        state[layout.speed(0)] = *speed;
        ledger.friction_of(0, &state) / speed
    });
    torque.collect()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(24) })]

    #[test]
    fn in_steady_slip_friction_is_g_and_the_viscous_torque(
        friction in friction(), speed in -50.0..50.0_f64,
    ) {
        prop_assume!(speed.abs() > 1e-2);
        // Twenty times the bristles' reach.
        let travel = 20.0 * 2.0 * friction.coulomb_nm / friction.sigma0_nm_per_rad;
        let step = travel / speed.abs() / 2000.0;
        let found = *torques(friction, &vec![speed; 2000], step).last().unwrap();
        let bell = (-(speed / friction.stribeck_velocity_rad_per_s).powi(2)).exp();
        let level = friction.coulomb_nm + friction.stribeck_nm * bell;
        let wanted = level * speed.signum() + friction.sigma2_nm_s_per_rad * speed;
        prop_assert!((found - wanted).abs() < 1e-4 * wanted.abs(), "{found} for {wanted}");
    }

    #[test]
    fn slow_presliding_loops_do_not_know_their_rate_and_take_work(friction in friction()) {
        let friction = Friction { sigma1_nm_s_per_rad: 0.0, sigma2_nm_s_per_rad: 0.0, ..friction };
        // Back and forth by half the bristles' reach, at speeds far below Stribeck's.
        let amplitude = 0.5 * friction.coulomb_nm / friction.sigma0_nm_per_rad;
        let slow = 1e-4 * friction.stribeck_velocity_rad_per_s;
        let run = |factor: f64| {
            let speed = slow * factor;
            let step = amplitude / speed / 500.0;
            let legs = (0..6).flat_map(|leg| vec![if leg % 2 == 0 { speed } else { -speed }; 500]);
            let speeds: Vec<f64> = legs.collect();
            let torque = torques(friction, &speeds, step);
            let powers = torque.iter().zip(&speeds).skip(1000);
            let work: f64 = powers.map(|(torque, speed)| torque * speed * step).sum();
            (torque, work)
        };
        let ((first, work), (second, _)) = (run(1.0), run(10.0));
        let apart = first.iter().zip(&second).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
        prop_assert!(apart < 1e-4 * friction.coulomb_nm, "{apart}");
        prop_assert!(work > 0.0, "{work}");
    }
}

#[test]
fn below_breakaway_a_joint_stays_for_a_quarter_of_an_hour() {
    let model = scenario::paper();
    // Half the breakaway of 0.12 V.
    let (plant, mut state) = plant(&model, Drive::Voltage, 1e-3);
    let run = |state: &mut [f64], steps: usize| {
        (0..steps).for_each(|_| plant.propagate(0, state, 0.06, 0.0));
        state[Layout::ANGLE]
    };
    let settled = run(&mut state, 1000);
    let after = run(&mut state, 900_000);
    assert!(settled.abs() < 1e-2 && (after - settled).abs() < 1e-9, "{settled} then {after}");
}

#[test]
fn below_breakaway_a_rotor_in_f32_stays_for_three_hours() {
    use joint_core::joint::{Joint, Settings};
    let model = scenario::paper();
    let settings = Settings::new(Drive::Voltage, 0.01);
    let joint = Joint::<f32, 0>::new(&model.motor, &[], &model.load, &settings).unwrap();
    let mut state = joint.rest();
    let mut run = |steps: u32| {
        (0..steps).for_each(|_| joint.step(&mut state, joint.input(0.05, 0.0)));
        state.angle.to_turns()
    };
    let settled = run(100);
    let after = run(3 * 360_000);
    assert!((after - settled).abs() < 1e-7, "{settled} then {after}");
}

#[test]
fn below_breakaway_the_whole_chain_in_f32_stays_for_two_hours() {
    use joint_core::joint::{Joint, Settings};
    let model = scenario::paper();
    let stages = [model.stages[0], model.stages[1]];
    // One micro-step, coarser than the rule's: drift would show the sooner.
    let settings = Settings { micro_steps: Some(1), ..Settings::new(Drive::Voltage, 100e-6) };
    let joint = Joint::<f32, 2>::new(&model.motor, &stages, &model.load, &settings).unwrap();
    let mut state = joint.rest();
    let mut run = |seconds: u32| {
        (0..seconds * 10_000).for_each(|_| joint.step(&mut state, joint.input(0.06, 0.0)));
        let windup = [0, 1].map(|stage| joint.deflection(&state, stage));
        (state.angle.to_turns(), windup)
    };
    let (settled, before) = run(1);
    let (after, behind) = run(2 * 3600);
    // The wheel behind the second stage stands where the rotor less both deflections does.
    assert!((after - settled).abs() < 1e-6, "{settled} then {after} turns");
    for (one, other) in before.iter().zip(&behind) {
        assert!((one - other).abs() < 1e-5, "{before:?} then {behind:?}");
    }
}
