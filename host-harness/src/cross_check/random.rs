//! Random plants: how often the step keeps its promise on joints nobody chose.
//!
//! Every parameter of the built-in joint is taken times or over up to three, with one to three
//! stages, a random voltage and a random load; the step runs in f32 at 50 µs with the micro-steps
//! and by the method that the rule finds. Stiff plants are the same with every spring up to a million
//! times stiffer, where chains cannot be resolved any more. Where a plant fails, it is run again with twice and four times the
//! micro-steps, which tells a step too long from a motion that no step follows for long, and its
//! rates are told beside it.

use std::f64::consts::TAU;
use std::fmt;

use joint_core::joint::{Drive, MAX_MICRO_STEPS, Method as Stepping, Pace};
use joint_core::params::{Friction, Stage};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::Serialize;

use super::{CrossCheckError, Quantity};
use crate::model::Model;
use crate::plant::{self, Inputs, ScalarKind, Snapshot};
use crate::reference::{self, Method, Options};
use crate::scenario::{GRID_S, paper};

/// The step, s.
const STEP_S: f64 = 50e-6;
/// Length of a run, s.
const DURATION_S: f64 = 0.05;
/// A plant passes where no state is further off than this.
const PASSED: f64 = 0.01;
/// Share by which the drive is changed to see how much hangs on it.
const NUDGE: f64 = 1e-4;
/// A plant is followable where a state changes by less than this many times the drive's change.
const FOLLOWABLE: f64 = 30.0;
/// Largest factor on a parameter.
const SPREAD: f64 = 3.0;
/// Largest factor on the springs of a stiff plant.
const STIFFER: f64 = 1e6;
/// Draws these factors apart from the plant itself.
const STIFF_SEED: u64 = 1 << 40;

/// One plant and how far its worst state is off.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plant {
    /// Makes the plant again.
    pub seed: u64,
    /// Its stages.
    pub stages: usize,
    /// Micro-steps that the rule picked.
    pub micro_steps: u32,
    /// Whether it picked the implicit method.
    pub implicit: bool,
    /// Largest relative RMS of a state with these.
    pub error: f64,
    /// The state.
    pub state: String,
    /// The same with twice and four times the micro-steps; only where it fails.
    pub refined: Option<[f64; 2]>,
    /// The same by the splitting in as many micro-steps as a step can have; only where the rule picked
    /// the implicit method.
    pub split: Option<f64>,
    /// Relative change of the reference's worst state over a relative change of the drive.
    pub sensitivity: f64,
    /// Turn of the fastest mode in a micro-step, rad.
    pub phase: f64,
    /// Growth of slip in a micro-step where the Stribeck curve falls steepest.
    pub growth: f64,
}

/// What the random plants show.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Random {
    /// Share of the plants whose every state is within 1 %.
    pub within: f64,
    /// The same among the followable: those whose every state changes by less than 30 times the
    /// share by which the drive does.
    pub within_followable: f64,
    /// Share of the followable.
    pub followable: f64,
    /// The same where the micro-steps are doubled, and doubled again, for those that fail.
    pub within_refined: [f64; 2],
    /// Mean of the micro-steps.
    pub mean_micro_steps: f64,
    /// Number of plants for which the rule picks the implicit method.
    pub implicit: usize,
    /// Share of them within 1 %, and the same by the splitting in as many micro-steps as a step can
    /// have; null without such a plant.
    pub within_implicit: Option<[f64; 2]>,
    /// The plants.
    pub plants: Vec<Plant>,
}

impl Random {
    /// Runs this many plants, `seed` on; `done` is called after each of them, from any thread.
    ///
    /// # Errors
    /// A joint cannot be built, or the reference fails.
    pub fn run(
        number: u64,
        seed: u64,
        stiff: bool,
        done: impl Fn() + Sync,
    ) -> Result<Self, CrossCheckError> {
        let plants = (seed..seed + number).into_par_iter().map(|seed| {
            let plant = check(seed, stiff);
            done();
            plant
        });
        let plants = plants.collect::<Result<Vec<_>, _>>()?;
        let share = |passes: &dyn Fn(&Plant) -> bool| {
            plants.iter().filter(|plant| passes(plant)).count() as f64 / plants.len() as f64
        };
        let refined = |which: usize| {
            share(&|plant| plant.refined.map_or(plant.error, |errors| errors[which]) <= PASSED)
        };
        let implicit: Vec<f64> = plants.iter().filter_map(|plant| plant.split).collect();
        let of_implicit = |passing: usize| passing as f64 / implicit.len() as f64;
        let within_implicit = (!implicit.is_empty()).then(|| {
            let own = plants.iter().filter(|plant| plant.implicit && plant.error <= PASSED);
            let split = implicit.iter().filter(|error| **error <= PASSED);
            [own.count(), split.count()].map(of_implicit)
        });
        let follows = |plant: &Plant| plant.sensitivity < FOLLOWABLE;
        let followable = share(&follows);
        let steps: f64 = plants.iter().map(|plant| f64::from(plant.micro_steps)).sum();
        Ok(Self {
            within: share(&|plant| plant.error <= PASSED),
            within_followable: share(&|plant| follows(plant) && plant.error <= PASSED) / followable,
            followable,
            within_refined: [refined(0), refined(1)],
            mean_micro_steps: steps / plants.len() as f64,
            implicit: implicit.len(),
            within_implicit,
            plants,
        })
    }
}

fn check(seed: u64, stiff: bool) -> Result<Plant, CrossCheckError> {
    let (mut model, inputs) = draw(seed);
    if stiff {
        stiffen(&mut model, seed);
    }
    let refer =
        |inputs: &Inputs| if stiff { refer_stiff(&model, inputs) } else { refer(&model, inputs) };
    let exact = refer(&inputs)?;
    let mut nudged = inputs.clone();
    nudged.drive_values.iter_mut().for_each(|value| *value *= 1.0 + NUDGE);
    let sensitivity = worst(&model, &exact, &refer(&nudged)?).0 / NUDGE;
    let pace = Pace::of(&model.motor, &model.stages, &model.load);
    let plan = pace.plan(STEP_S);
    let chosen = plan.micro_steps;
    let by = |method, micro_steps| -> Result<(f64, Quantity), CrossCheckError> {
        let (scalar, step) = (ScalarKind::F32, Some(STEP_S));
        let micro_steps = Some(micro_steps);
        let run = plant::simulate_by(method, &model, &inputs, scalar, step, micro_steps)?;
        Ok(worst(&model, &exact, &run))
    };
    let run = |micro_steps| by(None, micro_steps);
    let (error, state) = run(chosen)?;
    let refined =
        if error > PASSED { Some([run(2 * chosen)?.0, run(4 * chosen)?.0]) } else { None };
    let implicit = plan.method == Stepping::Implicit;
    let split =
        if implicit { Some(by(Some(Stepping::Splitting), MAX_MICRO_STEPS)?.0) } else { None };
    let micro_step = STEP_S / f64::from(chosen);
    Ok(Plant {
        seed,
        stages: model.stages.len(),
        micro_steps: chosen,
        implicit,
        error,
        state: state.to_string(),
        refined,
        split,
        sensitivity,
        phase: pace.mode_rad_per_s * micro_step,
        growth: pace.growth_per_s * micro_step,
    })
}

fn refer(model: &Model, inputs: &Inputs) -> Result<Vec<Snapshot>, CrossCheckError> {
    let run = |method| reference::simulate(model, inputs, &Options::of(method));
    // The share knows nothing of a spring that hardens.
    run(Method::Scaled { share: 0.4 }).or_else(|_| refer_stiff(model, inputs))
}

fn refer_stiff(model: &Model, inputs: &Inputs) -> Result<Vec<Snapshot>, CrossCheckError> {
    reference::simulate(model, inputs, &Options::of(Method::Stiff { tolerance: 1e-8 }))
        .map_err(|error| CrossCheckError::Reference { scenario: "random", error })
}

/// Makes every spring stiffer, and none of them hardens.
fn stiffen(model: &mut Model, seed: u64) {
    let mut random = ChaCha8Rng::seed_from_u64(STIFF_SEED + seed);
    for stage in &mut model.stages {
        stage.stiffness_nm_per_rad *= STIFFER.powf(random.random_range(0.0..1.0));
        stage.cubic_stiffness_nm_per_rad3 = 0.0;
    }
}

fn worst(model: &Model, exact: &[Snapshot], run: &[Snapshot]) -> (f64, Quantity) {
    let mut worst = (0.0, Quantity::Current);
    for quantity in Quantity::of(model.stages.len()) {
        let error = quantity.relative_rms(exact, run);
        if error > worst.0 || error.is_nan() {
            worst = (if error.is_nan() { f64::INFINITY } else { error }, quantity);
        }
    }
    worst
}

/// A plant and what drives it.
fn draw(seed: u64) -> (Model, Inputs) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut model = paper();
    let stages = random.random_range(1..=3);
    let between = between(&model.stages[0], &model.stages[1]);
    match stages {
        1 => model.stages = vec![between],
        2 => {}
        _ => {
            // The same gear as a whole, to a tenth.
            model.stages.insert(1, between);
            model.stages.iter_mut().for_each(|stage| stage.reduction = 10.0);
        }
    }
    let mut factor = || SPREAD.powf(random.random_range(-1.0..1.0));
    let motor = &mut model.motor;
    motor.phase_resistance_ohm *= factor();
    motor.phase_inductance_h *= factor();
    motor.torque_constant_nm_per_a *= factor();
    motor.rotor_inertia_kg_m2 *= factor();
    vary(&mut motor.friction, &mut factor);
    for stage in &mut model.stages {
        stage.inertia_kg_m2 *= factor();
        stage.stiffness_nm_per_rad *= factor();
        stage.cubic_stiffness_nm_per_rad3 *= factor();
        vary(&mut stage.friction, &mut factor);
    }
    let (mut breakaway, mut shaft) = (model.motor.friction.breakaway_nm(), 1.0);
    for stage in &model.stages {
        shaft /= stage.reduction;
        breakaway += stage.friction.breakaway_nm() * shaft;
    }
    let resistance = 2.0 * model.motor.phase_resistance_ohm;
    let voltage = resistance * breakaway / model.motor.torque_constant_nm_per_a;
    let amplitude = voltage * 1.5 * 8.0_f64.powf(random.random_range(0.0..1.0));
    let (shape, frequency) = (random.random_range(0..3), random.random_range(10.0..60.0));
    let load = if random.random::<bool>() { random.random_range(0.0..2.0) } else { 0.0 };
    let (load, load_frequency) = (load * breakaway / shaft, random.random_range(0.0..80.0));
    let samples = (DURATION_S / GRID_S).round() as usize + 1;
    let time_s: Vec<f64> = (0..samples).map(|k| k as f64 * GRID_S).collect();
    let drive = |t: f64| {
        let phase = TAU * frequency * t;
        match shape {
            0 => amplitude,
            1 => amplitude * phase.sin(),
            _ => amplitude * (2.0 * phase.sin()).clamp(-1.0, 1.0),
        }
    };
    let inputs = Inputs {
        drive: Drive::Voltage,
        drive_values: time_s.iter().map(|t| drive(*t)).collect(),
        load_nm: time_s.iter().map(|t| load * (TAU * load_frequency * t).cos()).collect(),
        time_s,
    };
    (model, inputs)
}

/// A stage half way between two, without cubic stiffness.
fn between(one: &Stage, other: &Stage) -> Stage {
    let mean = |of: fn(&Stage) -> f64| (of(one) * of(other)).sqrt();
    Stage {
        inertia_kg_m2: mean(|s| s.inertia_kg_m2),
        stiffness_nm_per_rad: mean(|s| s.stiffness_nm_per_rad),
        cubic_stiffness_nm_per_rad3: 0.0,
        friction: Friction {
            sigma0_nm_per_rad: mean(|s| s.friction.sigma0_nm_per_rad),
            sigma1_nm_s_per_rad: mean(|s| s.friction.sigma1_nm_s_per_rad),
            sigma2_nm_s_per_rad: mean(|s| s.friction.sigma2_nm_s_per_rad),
            coulomb_nm: mean(|s| s.friction.coulomb_nm),
            stribeck_nm: mean(|s| s.friction.stribeck_nm),
            stribeck_velocity_rad_per_s: mean(|s| s.friction.stribeck_velocity_rad_per_s),
        },
        ..*one
    }
}

fn vary(friction: &mut Friction, factor: &mut impl FnMut() -> f64) {
    friction.sigma0_nm_per_rad *= factor();
    friction.sigma1_nm_s_per_rad *= factor();
    friction.sigma2_nm_s_per_rad *= factor();
    friction.coulomb_nm *= factor();
    friction.stribeck_nm *= factor();
    friction.stribeck_velocity_rad_per_s *= factor();
}

impl fmt::Display for Random {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let per_cent = |share: f64| format!("{:.1} %", 100.0 * share);
        let [twice, four_times] = self.within_refined.map(per_cent);
        writeln!(
            f,
            "random plants within 1 % in every state at 50 µs, f32: {} of {} with the rule's \
             micro-steps ({:.2} on average); {twice} and {four_times} where those that fail take \
             twice and four times as many",
            per_cent(self.within),
            self.plants.len(),
            self.mean_micro_steps
        )?;
        writeln!(
            f,
            "among the {} that a change of the drive moves by less than {FOLLOWABLE} times itself: {}",
            per_cent(self.followable),
            per_cent(self.within_followable)
        )?;
        if let Some([own, split]) = self.within_implicit.map(|shares| shares.map(per_cent)) {
            writeln!(
                f,
                "the rule takes the implicit method for {}, {own} of them within 1 %; by the splitting \
                 in {MAX_MICRO_STEPS} micro-steps {split}",
                self.implicit
            )?;
        }
        let mut failed: Vec<_> = self.plants.iter().filter(|p| p.error > PASSED).collect();
        failed.sort_by(|a, b| b.error.total_cmp(&a.error));
        for plant in failed.iter().take(25) {
            let [twice, four_times] = plant.refined.unwrap_or_default();
            writeln!(
                f,
                "  seed {:<6} {} stages, {} micro-steps, {:<14} {:>8.2} %, then {:.2} and {:.2} %; \
                 sensitivity {:.0}, mode {:.2} rad, slip grows by \
                 e^{:.2}",
                plant.seed,
                plant.stages,
                plant.micro_steps,
                plant.state,
                100.0 * plant.error,
                100.0 * twice,
                100.0 * four_times,
                plant.sensitivity,
                plant.phase,
                plant.growth
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_makes_the_same_admissible_plant_again() {
        for seed in 0..50 {
            let (model, inputs) = draw(seed);
            assert_eq!(
                joint_core::params::validate(&model.motor, &model.stages, &model.load),
                Ok(())
            );
            assert_eq!(draw(seed).1, inputs);
            assert!((1..=3).contains(&model.stages.len()));
        }
    }

    #[test]
    fn most_random_plants_stay_within_one_per_cent() {
        let random = Random::run(12, 1, false, || ()).unwrap();
        assert!(random.within >= 0.5, "{random}");
    }

    #[test]
    fn chains_too_stiff_to_be_divided_are_stepped_by_the_implicit_method() {
        let random = Random::run(8, 3, true, || ()).unwrap();
        let [own, split] = random.within_implicit.unwrap();
        assert!(random.implicit >= 4 && own > 0.3 && own >= split, "{random}");
        assert!(random.plants.iter().all(|plant| plant.error < 0.5), "{random}");
    }
}
