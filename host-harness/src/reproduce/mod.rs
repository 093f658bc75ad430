//! The paper's figures and its stated numbers, beside ours.
//!
//! Every scenario is data ([`scene`]); it runs once with the motor prescribed, as the paper excites the
//! gear ([`prescribed`]), and once with the motor's three phases, its amplifier and a speed loop
//! ([`driven`]). One set of parameters serves all, [`crate::scenario::paper`]. What comes out is
//! measured the way the paper words it ([`numbers`]); where it disagrees, the row says why.

pub mod claim;
pub mod commutation;
pub mod driven;
pub mod numbers;
mod pages;
pub mod prescribed;
pub mod scene;
pub mod systems;
pub mod trace;
pub mod why;

use joint_core::effect::{EffectParameters, Kind};
use joint_core::joint::Drive;
use joint_core::motor::inverter::Amplifier;
use joint_core::params::{Friction, Location};
use rayon::prelude::*;

use crate::model::Model;
use crate::planetary::{self, Gear, Mode, Reduction, Soft};
use crate::plant::{self, Inputs, ScalarKind};
use claim::Claim;
use commutation::Commutation;
use numbers::Number;
use scene::Scene;
use trace::Trace;
use why::Why;

pub use pages::{figures, page};

/// Coefficient of the load-dependent friction that gives the catalogue's gear efficiency.
const MESH_FRICTION: f64 = 0.22;
/// Middle of the catalogue's gear efficiency, as the paper gives it.
const CATALOGUE_GEAR: f64 = 0.525;
/// Voltage of the friction's share over k_t: the speed that it would give without, rad/s.
const FREE_SPEED: f64 = 500.0;

/// Voltage at which the six-step motor is shown beside its DC equivalent, V.
const COMMUTATED_V: f64 = 6.0;

/// A scenario run with one of the two motors.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The scenario's file.
    pub file: &'static str,
    /// The scenario.
    pub scene: Scene,
    /// Whether the motor is the six-step one; else its speed is prescribed.
    pub six_step: bool,
    /// What came out.
    pub trace: Trace,
}

/// Efficiencies at the nominal load.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Efficiency {
    /// Of the motor: work on the gear over work from the bus.
    pub motor: f64,
    /// Of the gear: work on the load over work from the motor.
    pub gear: f64,
    /// Of the gear with load-dependent friction.
    pub loaded: f64,
}

/// Everything that the numbers are taken from.
#[derive(Clone, Debug, PartialEq)]
pub struct Runs {
    /// Every scenario with both motors.
    pub traces: Vec<Run>,
    /// Section 5.1.
    pub claim: Claim,
    /// At the nominal load.
    pub efficiency: Efficiency,
    /// Share of the speed that friction takes at a fixed voltage.
    pub friction_loss: f64,
    /// Ratio of the gear.
    pub ratio: f64,
    /// Ratios of the other joints, by the name of their file.
    pub ratios: Vec<(&'static str, f64)>,
    /// What stands behind the rows that disagree.
    pub why: Why,
    /// The six-step motor beside its DC equivalent.
    pub commutation: Commutation,
    /// Modes of one full planetary stage.
    pub modes: Vec<Mode>,
    /// The full chain beside equation (1), its shafts soft.
    pub reduction: Reduction,
}

impl Runs {
    /// The trace of a scenario.
    ///
    /// # Panics
    /// There is no built-in scenario of this name.
    pub fn of(&self, file: &str, six_step: bool) -> &Trace {
        let found = self.traces.iter().find(|run| run.file == file && run.six_step == six_step);
        &found.unwrap_or_else(|| panic!("no scenario {file}")).trace
    }

    /// The paper's numbers beside ours.
    pub fn numbers(&self) -> Vec<Number> {
        numbers::numbers(self)
    }
}

/// Runs everything; `done` is called after each run, from any thread.
///
/// # Errors
/// A data file or a model that is not admissible.
pub fn run(model: &Model, done: impl Fn() + Sync) -> Result<Runs, String> {
    let amplifier = driven::amplifier()?;
    let tasks: Vec<(&'static str, Scene, bool)> = scene::built_in()?
        .into_iter()
        .flat_map(|(file, scene)| [(file, scene.clone(), false), (file, scene, true)])
        .collect();
    let traces: Result<Vec<Run>, String> = tasks
        .into_par_iter()
        .map(|(file, scene, six_step)| {
            let trace = traced(model, &amplifier, &scene, six_step)
                .map_err(|error| format!("{file}: {error}"))?;
            done();
            Ok(Run { file, scene, six_step, trace })
        })
        .collect();
    // Alone, because it compares times.
    let claim = claim::measure(model, &done)?;
    let mut runs = Runs {
        traces: traces?,
        claim,
        efficiency: Efficiency::default(),
        friction_loss: friction_loss(model)?,
        ratio: systems::ratio(model),
        ratios: systems::built_in()?.iter().map(|(f, model)| (*f, systems::ratio(model))).collect(),
        why: Why::default(),
        commutation: commutation::run(model, COMMUTATED_V)?,
        modes: planetary::modes(&Gear::micro()),
        reduction: planetary::reduction(&Gear::micro(), model, Soft::Shafts)
            .ok_or("the joint has other than two stages, or stages stiffer than their meshes")?,
    };
    let nominal = runs.of("nominal_load", true);
    let (motor, gear) = efficiency(model, nominal);
    let mut meshing = model.clone();
    for stage in 1..=model.stages.len() as u8 {
        let friction = EffectParameters::new(Kind::LoadDependentFriction, Location::Stage(stage));
        meshing.effects.push(friction.with("coefficient", MESH_FRICTION));
    }
    let scene = runs.traces.iter().find(|run| run.file == "nominal_load").map(|run| &run.scene);
    let scene = scene.ok_or("no scenario nominal_load")?;
    let trace = traced(&meshing, &amplifier, scene, true)?;
    let (_, loaded) = efficiency(&meshing, &trace);
    runs.efficiency = Efficiency { motor, gear, loaded };
    runs.why = why::measure(model, gear, CATALOGUE_GEAR)?;
    Ok(runs)
}

/// Steps that [`run`] reports as done.
pub const STEPS: u64 = 36;

fn traced(
    model: &Model,
    amplifier: &Amplifier,
    scene: &Scene,
    six_step: bool,
) -> Result<Trace, String> {
    if six_step {
        driven::run(model, amplifier, scene).map_err(|error| error.to_string())
    } else {
        prescribed::run(model, scene).map_err(|error| error.to_string())
    }
}

/// Efficiency of motor and gear over the second half of a run.
fn efficiency(model: &Model, trace: &Trace) -> (f64, f64) {
    let half = trace.time_s.len() / 2;
    let last = trace.time_s.len() - 1;
    let over = |series: &[f64]| series[last] - series[half];
    let shaft: f64 = model.stages.iter().map(|stage| 1.0 / stage.reduction).product();
    let (mut load, mut rubbed) = (0.0, 0.0);
    for k in half..last {
        let interval = trace.time_s[k + 1] - trace.time_s[k];
        load += trace.load_nm[k] * trace.output()[k] * shaft * interval;
        let speed = trace.speed[0][k];
        rubbed += slip_torque(&model.motor.friction, speed) * speed * interval;
    }
    let on_gear = over(&trace.shaft_work_j) - rubbed;
    (on_gear / over(&trace.bus_work_j), load / on_gear)
}

/// Friction torque in steady slip, (2) and (3).
fn slip_torque(friction: &Friction, speed: f64) -> f64 {
    let bell = (-(speed / friction.stribeck_velocity_rad_per_s).powi(2)).exp();
    let level = friction.coulomb_nm + friction.stribeck_nm * bell;
    level * speed.signum() + friction.sigma2_nm_s_per_rad * speed
}

fn friction_loss(model: &Model) -> Result<f64, String> {
    let plateau = |model: &Model| {
        let samples = 1001;
        let volts = FREE_SPEED * model.motor.torque_constant_nm_per_a;
        let inputs = Inputs {
            time_s: (0..samples).map(|k| f64::from(k) * 1e-4).collect(),
            drive: Drive::Voltage,
            drive_values: vec![volts; samples as usize],
            load_nm: vec![0.0; samples as usize],
        };
        let run = plant::simulate(model, &inputs, ScalarKind::F64, Some(1e-5), None)
            .map_err(|error| error.to_string())?;
        let last = &run[run.len() - 200..];
        Ok::<f64, String>(last.iter().map(|s| s.motor_speed_rad_per_s).sum::<f64>() / 200.0)
    };
    let mut free = model.clone();
    free.motor.friction = Friction::default();
    for stage in &mut free.stages {
        stage.friction = Friction::default();
        // Without friction nothing ends the vibration; damping takes no mean speed.
        stage.damping_nm_s_per_rad = 1e-4;
    }
    Ok(1.0 - plateau(model)? / plateau(&free)?)
}
