//! How wrong an observer is, row by row: its standard deviations.
//!
//! A filter's own covariance believes its model. What a user wants to know is how far the estimate
//! is off on a joint whose parameters were found by a refit and whose friction is not quite the law
//! in the book, so the drive's update is run over such joints and its errors are counted.

use std::f64::consts::TAU;

use joint_core::joint::Drive;
use joint_core::observer::{Design, Regime, SETS, Spread};
use joint_core::per_unit::Bases;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::noise::{drive_noise, sensors};
use super::rating::{Rating, breakaway_nm};
use super::run::{Seen, observer, run};
use super::twin::{Felt, Motion, Style, Twin};
use crate::model::Model;
use crate::plant::{BuildError, Layout};

/// Joints that are tried.
const JOINTS: u64 = 4;
/// Samples of each.
const SAMPLES: usize = 5000;
/// Samples at the start that do not count.
const START: usize = 400;
/// Errors from which a row's deviation is taken; with fewer it takes that of all rows.
const ENOUGH: usize = 60;

/// Share of the joint's friction from which on its bristles turn round.
const TURNING: f64 = 0.05;

/// What a refit leaves: one sigma of the parameters' errors, relative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrong {
    /// R, k_t.
    pub motor: f64,
    /// Inertias and stiffnesses.
    pub chain: f64,
    /// Everything of friction.
    pub friction: f64,
}

impl Default for Wrong {
    fn default() -> Self {
        Self { motor: 4e-4, chain: 1e-3, friction: 7e-3 }
    }
}

/// A joint near a model.
pub fn near(model: &Model, wrong: &Wrong, seed: u64) -> Model {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut off = |value: &mut f64, sigma: f64| {
        let normal: f64 = StandardNormal.sample(&mut random);
        *value *= 1.0 + sigma * normal.clamp(-2.5, 2.5);
    };
    let mut model = model.clone();
    let motor = &mut model.motor;
    off(&mut motor.phase_resistance_ohm, wrong.motor);
    off(&mut motor.torque_constant_nm_per_a, wrong.motor);
    motor.phase_back_emf_constant_v_s_per_rad = None;
    off(&mut motor.rotor_inertia_kg_m2, 0.3 * wrong.chain);
    let rotor = &mut motor.friction;
    for value in [&mut rotor.coulomb_nm, &mut rotor.stribeck_nm, &mut rotor.sigma2_nm_s_per_rad] {
        off(value, wrong.friction);
    }
    for stage in &mut model.stages {
        off(&mut stage.stiffness_nm_per_rad, wrong.chain);
        off(&mut stage.inertia_kg_m2, 0.3 * wrong.chain);
        off(&mut stage.cubic_stiffness_nm_per_rad3, 3.0 * wrong.chain);
        let own = &mut stage.friction;
        for value in [&mut own.coulomb_nm, &mut own.stribeck_nm, &mut own.sigma2_nm_s_per_rad] {
            off(value, wrong.friction);
        }
    }
    model
}

/// What the sensors of a model show of a motion.
pub fn shown(model: &Model, kind: Drive, motion: &Twin, output: bool, seed: u64) -> Vec<Seen> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let layout = Layout::of(model);
    let shaft = Bases::si(&model.motor, &model.stages).shaft(model.stages.len());
    let sensor = &model.sensor;
    let counted = |angle: f64, counts: f64| {
        if counts > 0.0 { (angle / TAU * counts).round() / counts * TAU } else { angle }
    };
    let rows = motion.states.iter().zip(&motion.drive);
    rows.map(|(state, drive)| {
        let angle = state[Layout::ANGLE];
        let wound: f64 = (0..layout.stages).map(|k| state[layout.deflection(k)]).sum();
        let normal: f64 = StandardNormal.sample(&mut random);
        let current = state[Layout::CURRENT] + sensor.current_noise_a * normal;
        let voltage = kind == Drive::Voltage && sensor.current_noise_a > 0.0;
        let behind = (angle - wound) * shaft;
        let counts = sensor.output_encoder_counts_per_rev;
        Seen {
            drive: *drive,
            current: if voltage { current } else { f64::NAN },
            motor: counted(angle, sensor.motor_encoder_counts_per_rev),
            output: if output { counted(behind, counts) } else { f64::NAN },
        }
    })
    .collect()
}

/// Errors of one quantity by row.
type Errors = [Vec<f64>; SETS];

/// The standard deviations of a design on joints that are `wrong` so: by row, and how much more of
/// friction there is where bristles turn round.
///
/// # Errors
/// The model cannot be built.
pub fn spread<const N: usize>(
    model: &Model,
    kind: Drive,
    step_s: f64,
    rating: &Rating,
    design: &Design<N>,
    wrong: &Wrong,
) -> Result<([Spread<f64, N>; SETS], [f64; 2]), BuildError> {
    // Read without a deviation of its own, friction's is what of it turns round.
    let bare = Design { turning: [1.0; 2], ..design.clone() };
    let observer = observer::<f64, N>(model, kind, step_s, &bare)?;
    let layout = Layout::of(model);
    let bases = Bases::si(&model.motor, &model.stages);
    let shaft = bases.shaft(N);
    let mut errors: Vec<Errors> = (0..5 + N).map(|_| Default::default()).collect();
    let mut turns: [Vec<[f64; 2]>; 2] = Default::default();
    let level = breakaway_nm(model);
    let has_output = sensors(model)[2].is_finite();
    for seed in 0..JOINTS {
        let truth = near(model, wrong, 100 + seed);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let size = random.random_range(0.5..1.5);
        let drive = drive_noise(&truth, kind, rating, 1e-3 * size);
        let felt = Felt { drive, torque: 0.01 * size * level };
        let style = if seed % 2 == 0 { Style::Creep } else { Style::Duty };
        let motion = Motion {
            truth: &truth,
            kind,
            step_s,
            rating,
            felt,
            style,
            samples: SAMPLES,
            seed: 200 + seed,
        };
        let motion = motion.run()?;
        let friction = super::truth::frictions(&truth, &motion);
        for output in [false, true] {
            if output && !has_output {
                continue;
            }
            let seen = shown(&truth, kind, &motion, output, seed);
            let found = run(&observer, &seen, &[]);
            for (k, found) in found.iter().enumerate().skip(START) {
                let (state, e) = (&motion.states[k], &found.estimate);
                let wound: f64 = (0..N).map(|k| state[layout.deflection(k)]).sum();
                let mut put = |which: usize, error: f64| errors[which][e.row].push(error.abs());
                put(0, e.motor_velocity - state[layout.speed(0)]);
                let (off, turning) = (e.total_friction - friction[k], e.spread.total_friction);
                if turning < TURNING * level {
                    put(1, off);
                } else {
                    turns[usize::from(Regime::has_output(e.row))].push([off.abs(), turning]);
                }
                put(2, found.output_angle - (state[Layout::ANGLE] - wound) * shaft);
                put(3, e.output_velocity - state[layout.speed(N)] * shaft);
                put(4, e.load - motion.load[k]);
                for stage in 0..N {
                    let true_one = state[layout.deflection(stage)] * bases.shaft(stage + 1);
                    put(5 + stage, e.windup[stage] - true_one);
                }
            }
        }
    }
    let blind = level / shaft.abs();
    let spread: [Spread<f64, N>; SETS] = std::array::from_fn(|row| {
        let of = |which: usize| deviation(&errors[which], row);
        let held_blind = row % Regime::COUNT == Regime::Held as usize && !Regime::has_output(row);
        Spread {
            motor_velocity: of(0),
            total_friction: of(1),
            windup: std::array::from_fn(|stage| of(5 + stage)),
            output_angle: of(2),
            output_velocity: of(3),
            load: if held_blind { of(4).max(0.5 * blind) } else { of(4) },
        }
    });
    // Without an output encoder where there is none to be judged by.
    let more = [0, 1].map(|output: usize| {
        let own = if turns[output].is_empty() { &turns[0] } else { &turns[output] };
        let steady = spread[Regime::Steady.row(output == 1, false)].total_friction;
        let shares = own.iter().map(|[off, turning]| (off - steady).max(0.0) / turning);
        middle(shares.collect())
    });
    Ok((spread, more))
}

fn deviation(errors: &Errors, row: usize) -> f64 {
    let mut own: Vec<f64> = errors[row].clone();
    let mut from = |other: usize| {
        if own.len() < ENOUGH {
            own.extend(&errors[other]);
        }
    };
    // The other bend of the spring, then the calmer regime, then everything without an output.
    from((row + SETS / 2) % SETS);
    from(row - row % Regime::COUNT);
    (0..SETS).for_each(&mut from);
    middle(own)
}

/// One sigma of some errors, such that 68 % of them lie within it: just after a change of the load
/// they have long tails, which a root mean square would spread over all.
fn middle(mut own: Vec<f64>) -> f64 {
    own.retain(|v| v.is_finite());
    if own.is_empty() {
        return 0.0;
    }
    own.sort_by(f64::total_cmp);
    own[((own.len() - 1) as f64 * 0.683) as usize]
}
