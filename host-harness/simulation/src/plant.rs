//! The joint behind one interface, whatever its number of stages.
//!
//! `joint-core` fixes the number of stages at compile time; a model file does not. This is where
//! the one becomes the other, and where a log's uneven sampling becomes a set of joints, one per
//! distinct interval of its grid.

use std::borrow::Cow;

use joint_core::angle::Angle;
use joint_core::effect::{EffectSet, MEMORIES, Memory};
use joint_core::fixed::Fixed;
use joint_core::joint::{Drive, Joint, Mass, Method, Pace, Settings, StageState, State};
use joint_core::params::ParameterError;
use joint_core::per_unit::{Bases, reflected_inertia};
use joint_core::scalar::Scalar;

use crate::acting::{acts_late_s, at_samples, stepped, switch};
use crate::grid::Grid;
use crate::lanes::{self, Abreast, Constants, Linear};
use crate::model::Model;

pub use crate::acting::Inputs;
pub use crate::layout::{Layout, MAX_STAGES};

/// Which number the joint is computed in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScalarKind {
    /// Double precision.
    F64,
    /// Single precision, bit for bit as on the drive.
    F32,
    /// Fixed point, bit for bit as on a drive without a floating-point unit.
    Fixed,
}

/// One stage at one instant, at its own side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageSnapshot {
    /// Angle of the mass behind the spring, rad.
    pub angle_rad: f64,
    /// Its speed, rad/s.
    pub speed_rad_per_s: f64,
    /// Deflection of the spring, η q_in − q_out, rad.
    pub windup_rad: f64,
    /// Bristle torque over Coulomb level.
    pub bristle: f64,
}

/// A joint at one instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// Current in the winding, A.
    pub current_a: f64,
    /// What the current sensor shows, A.
    pub measured_current_a: f64,
    /// Rotor angle, rad.
    pub motor_angle_rad: f64,
    /// Rotor speed, rad/s.
    pub motor_speed_rad_per_s: f64,
    /// Bristle torque of the rotor over its Coulomb level.
    pub motor_bristle: f64,
    /// The stages, from the motor on.
    pub stages: Vec<StageSnapshot>,
}

/// Why a joint cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum BuildError {
    /// A parameter that the equations cannot take.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// More stages than the harness is compiled for.
    #[error("the model has {0} stages; at most {MAX_STAGES} are supported")]
    TooManyStages(usize),
}

/// A joint with its state as a plain vector, reflected to the motor:
/// `[current A, angle rad, deflections rad…, speeds rad/s…, bristle ζ…, memories…]`.
pub trait Plant: Send + Sync {
    /// Advances a state over the interval after sample `k`; `drive` in V or A, `load` in Nm.
    fn propagate(&self, k: usize, state: &mut [f64], drive: f64, load: f64) {
        self.propagate_switched(k, state, [drive; 2], load);
    }

    /// The same where the drive switches within the interval, if the model has it act late
    /// ([`crate::acting`]): before and after.
    fn propagate_switched(&self, k: usize, state: &mut [f64], drives: [f64; 2], load: f64);
    /// What the current sensor shows, A, when this flows, of what effects remember.
    fn measured_current(&self, current: f64, memory: &Memory<f64>) -> f64;
    /// What an encoder shows beside the angle of its shaft, rad, from that angle and its speed, and
    /// from what effects remember: the motor's, or the output's.
    fn encoder_error(&self, output: bool, angle: f64, speed: f64, memory: &Memory<f64>) -> f64;
    /// Micro-steps in the interval after sample `k`.
    fn micro_steps(&self, k: usize) -> u32;
    /// The constants of its joints, to be laid beside those of others.
    fn constants(&self) -> Constants;
    /// Plants of these constants side by side, over the intervals of this one; `None` where they differ
    /// by more than their numbers.
    fn abreast(&self, constants: &[&Constants]) -> Option<Box<dyn Abreast>>;
    /// The plant with derivatives by its own state.
    fn linear(&self) -> Box<dyn Linear>;
    /// Whether its constants move smoothly to those a step away and two.
    fn moves_smoothly(&self, steps: [&Constants; 2]) -> bool;
}

struct Built<S: Scalar, const N: usize> {
    /// One joint per distinct interval; two where its drive switches on the way.
    joints: Vec<Joint<S, N, EffectSet<S>>>,
    /// Which distinct interval is after a sample.
    serves: Vec<u32>,
    /// Whether the drive switches within an interval.
    switched: bool,
}

impl<S: Scalar, const N: usize> Built<S, N> {
    /// Of a model whose drive acts late if `delay_s` is not zero.
    fn new(model: &Model, grid: &Grid, drive: Drive, delay_s: f64) -> Result<Self, ParameterError> {
        joint_core::effect::validate(&model.effects, model.stages.len())?;
        let effects = stepped(&model.effects);
        let switched = delay_s != 0.0;
        let share = switch(delay_s, grid.typical_interval());
        let parts = if switched { vec![share, 1.0 - share] } else { vec![1.0] };
        // Where it is the log that leads, by half an interval, what an interval takes is divided.
        let halves = if delay_s == -grid.lead_s { parts.len() as u32 } else { 1 };
        // A model that many logs share rubs as it did on the day of each.
        let days: Vec<Cow<'_, Model>> = (0..grid.logs()).map(|log| model.on_day(log)).collect();
        let joints = grid
            .distinct()
            .flat_map(|interval| parts.iter().map(move |part| (interval, part)))
            .map(|((interval, log), part)| {
                let Model { motor, stages, load, .. } = &*days[log];
                let stages: [_; N] = std::array::from_fn(|k| stages[k]);
                let settings = Settings {
                    drive,
                    step_s: part * grid.bridged(interval) / f64::from(grid.per_interval),
                    micro_steps: grid.micro_steps(interval).map(|all| all.div_ceil(halves)),
                    method: grid.method,
                    effects: &effects,
                };
                Joint::<S, N, EffectSet<S>>::new(motor, &stages, load, &settings)
            })
            .collect::<Result<_, _>>()?;
        Ok(Self { joints, serves: grid.serves.clone(), switched })
    }

    /// The joints of the parts of the interval after sample `k`, each with its drive of those before
    /// and after the switch.
    fn parts(
        &self,
        k: usize,
        drives: [f64; 2],
    ) -> impl Iterator<Item = (&Joint<S, N, EffectSet<S>>, f64)> {
        let parts = 1 + usize::from(self.switched);
        let first = parts * self.serves[k.min(self.serves.len() - 1)] as usize;
        self.joints[first..first + parts].iter().zip(drives.into_iter().skip(2 - parts))
    }

    /// The joint of the interval after sample `k`, of its first part if it has two.
    fn joint(&self, k: usize) -> &Joint<S, N, EffectSet<S>> {
        let parts = 1 + usize::from(self.switched);
        &self.joints[parts * self.serves[k.min(self.serves.len() - 1)] as usize]
    }
}

fn unpack<S: Scalar, const N: usize, E: joint_core::effect::Effects<S>>(
    joint: &Joint<S, N, E>,
    flat: &[f64],
) -> State<S, N> {
    let layout = Layout { stages: N, memories: 0 };
    let mut state = State {
        current: S::ZERO,
        angle: Angle::from_turns(flat[Layout::ANGLE] / std::f64::consts::TAU),
        rotor: Mass::default(),
        stages: [StageState::default(); N],
        memory: [S::ZERO; MEMORIES],
    };
    for (memory, value) in state.memory.iter_mut().zip(flat.iter().skip(layout.len())) {
        *memory = S::from_f64(*value);
    }
    joint.set_current(&mut state, flat[Layout::CURRENT]);
    for stage in 0..N {
        joint.set_deflection(&mut state, stage, flat[layout.deflection(stage)]);
    }
    for mass in 0..=N {
        joint.set_speed(&mut state, mass, flat[layout.speed(mass)]);
        joint.set_bristle(&mut state, mass, flat[layout.bristle(mass)]);
    }
    joint.refresh(&mut state);
    state
}

fn pack<S: Scalar, const N: usize, E: joint_core::effect::Effects<S>>(
    joint: &Joint<S, N, E>,
    state: &State<S, N>,
    flat: &mut [f64],
) {
    let layout = Layout { stages: N, memories: 0 };
    for (value, memory) in flat.iter_mut().skip(layout.len()).zip(&state.memory) {
        *value = memory.to_f64();
    }
    flat[Layout::CURRENT] = joint.current(state).to_f64();
    flat[Layout::ANGLE] = state.angle.to_turns() * std::f64::consts::TAU;
    for stage in 0..N {
        flat[layout.deflection(stage)] = joint.deflection(state, stage).to_f64();
    }
    for mass in 0..=N {
        flat[layout.speed(mass)] = joint.speed(state, mass).to_f64();
        flat[layout.bristle(mass)] = joint.bristle(state, mass).to_f64();
    }
}

impl<const N: usize> Plant for Built<f64, N> {
    fn propagate_switched(&self, k: usize, flat: &mut [f64], drives: [f64; 2], load: f64) {
        for (joint, drive) in self.parts(k, drives) {
            let mut state = unpack(joint, flat);
            joint.step(&mut state, joint.input(drive, load));
            pack(joint, &state, flat);
        }
    }

    fn measured_current(&self, current: f64, memory: &Memory<f64>) -> f64 {
        self.joints[0].measured(current, memory)
    }

    fn encoder_error(&self, output: bool, angle: f64, speed: f64, memory: &Memory<f64>) -> f64 {
        self.joints[0].encoder_error(output, angle, speed, memory)
    }

    fn micro_steps(&self, k: usize) -> u32 {
        self.joint(k).micro_steps()
    }

    fn constants(&self) -> Constants {
        lanes::constants(&self.joints)
    }

    fn abreast(&self, constants: &[&Constants]) -> Option<Box<dyn Abreast>> {
        lanes::abreast::<N>(constants, &self.serves, self.switched)
    }

    fn linear(&self) -> Box<dyn Linear> {
        lanes::linear(&self.joints, &self.serves, self.switched)
    }

    fn moves_smoothly(&self, steps: [&Constants; 2]) -> bool {
        lanes::is_smooth(&self.joints, steps)
    }
}

/// A body with the number of stages as the constant `$n`; more than six are an error of the result that it is.
#[macro_export]
macro_rules! by_stages {
    ($stages:expr, $n:ident => $body:expr) => {
        match $stages {
            0 => {
                const $n: usize = 0;
                $body
            }
            1 => {
                const $n: usize = 1;
                $body
            }
            2 => {
                const $n: usize = 2;
                $body
            }
            3 => {
                const $n: usize = 3;
                $body
            }
            4 => {
                const $n: usize = 4;
                $body
            }
            5 => {
                const $n: usize = 5;
                $body
            }
            6 => {
                const $n: usize = 6;
                $body
            }
            more => Err($crate::plant::BuildError::TooManyStages(more)),
        }
    };
}

pub use crate::by_stages;

/// A joint in double precision over a record's intervals.
///
/// # Errors
/// A parameter that the equations cannot take, or too many stages.
pub fn plant(model: &Model, grid: &Grid, drive: Drive) -> Result<Box<dyn Plant>, BuildError> {
    by_stages!(model.stages.len(), N => {
        let late = acts_late_s(model, grid, drive);
        Ok(Box::new(Built::<f64, N>::new(model, grid, drive, late)?))
    })
}

/// Runs a model on inputs with the step of the drive; `step_s` divides every interval into steps
/// of at most this length, `None` takes one step a sample.
///
/// # Errors
/// A parameter that the equations cannot take, or too many stages.
pub fn simulate(
    model: &Model,
    inputs: &Inputs,
    scalar: ScalarKind,
    step_s: Option<f64>,
    micro_steps: Option<u32>,
) -> Result<Vec<Snapshot>, BuildError> {
    simulate_by(None, model, inputs, scalar, step_s, micro_steps)
}

/// The same by a method of one's own choice.
///
/// # Errors
/// As [`simulate`].
pub fn simulate_by(
    method: Option<Method>,
    model: &Model,
    inputs: &Inputs,
    scalar: ScalarKind,
    step_s: Option<f64>,
    micro_steps: Option<u32>,
) -> Result<Vec<Snapshot>, BuildError> {
    let options = Options { method, step_s, micro_steps, start: None };
    simulate_from(&options, model, inputs, scalar)
}

/// How a model is run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// How it is stepped; `None` leaves it to the joint.
    pub method: Option<Method>,
    /// Longest step, s; `None` takes one step a sample.
    pub step_s: Option<f64>,
    /// Micro-steps in a step; `None` leaves it to the joint.
    pub micro_steps: Option<u32>,
    /// The state to begin with, as [`Layout`] has it; `None` begins at rest.
    pub start: Option<Vec<f64>>,
}

/// Runs a model on inputs from a state.
///
/// # Errors
/// As [`simulate`].
pub fn simulate_from(
    options: &Options,
    model: &Model,
    inputs: &Inputs,
    scalar: ScalarKind,
) -> Result<Vec<Snapshot>, BuildError> {
    if let Some((acting, samples)) = inputs.acting(model) {
        let run = simulate_acting(options, model, &acting, scalar)?;
        return Ok(at_samples(run, &samples));
    }
    simulate_acting(options, model, inputs, scalar)
}

/// The same of inputs that act as they are.
fn simulate_acting(
    options: &Options,
    model: &Model,
    inputs: &Inputs,
    scalar: ScalarKind,
) -> Result<Vec<Snapshot>, BuildError> {
    let mut grid = Grid::new(&inputs.time_s, options.micro_steps);
    grid.method = options.method;
    if let Some(step) = options.step_s {
        let longest = grid.intervals.iter().copied().fold(0.0, f64::max);
        grid.per_interval = ((longest / step - 1e-6).ceil() as u32).max(1);
    }
    by_stages!(model.stages.len(), N => Ok(match scalar {
        ScalarKind::F64 => run::<f64, N>(options, &grid, inputs, model)?,
        ScalarKind::Fixed => run::<Fixed, N>(options, &grid, inputs, model)?,
        ScalarKind::F32 => run::<f32, N>(options, &grid, inputs, model)?,
    }))
}

fn run<S: Scalar, const N: usize>(
    options: &Options,
    grid: &Grid,
    inputs: &Inputs,
    model: &Model,
) -> Result<Vec<Snapshot>, BuildError> {
    let bases = Bases::si(&model.motor, &model.stages);
    let built = Built::<S, N>::new(model, grid, inputs.drive, 0.0)?;
    // An open winding is a current of nothing.
    let open = match inputs.drive_values.iter().any(|value| value.is_nan()) {
        true => Some(Built::<S, N>::new(model, grid, Drive::Current, 0.0)?),
        false => None,
    };
    let mut state = match &options.start {
        Some(flat) => unpack(built.joint(0), flat),
        None => built.joint(0).rest(),
    };
    let mut snapshots = Vec::with_capacity(inputs.time_s.len());
    for k in 0..inputs.time_s.len() {
        let given = inputs.drive_values[k];
        let (joint, drive, value) = match &open {
            Some(open) if given.is_nan() => (open.joint(k), Drive::Current, 0.0),
            _ => (built.joint(k), inputs.drive, given),
        };
        if given.is_nan() {
            joint.set_current(&mut state, 0.0);
        }
        snapshots.push(snapshot(joint, &state, &bases));
        let drive_value = S::from_f64(value);
        let load = S::from_f64(inputs.load_nm.get(k).copied().unwrap_or(0.0));
        if drive == Drive::Current {
            let imposed =
                if given.is_nan() { 0.0 } else { joint.imposed_current(drive_value).to_f64() };
            joint.set_current(&mut state, imposed);
        }
        for _ in 0..grid.per_interval {
            joint.step(&mut state, joint.input(drive_value, load));
        }
    }
    Ok(snapshots)
}

fn snapshot<S: Scalar, const N: usize>(
    joint: &Joint<S, N, EffectSet<S>>,
    state: &State<S, N>,
    bases: &Bases<'_>,
) -> Snapshot {
    let motor_angle_rad = state.angle.to_turns() * std::f64::consts::TAU;
    let mut wound = 0.0;
    let stages = (0..N)
        .map(|stage| {
            let shaft = bases.shaft(stage + 1);
            let deflection = joint.deflection_rad(state, stage);
            wound += deflection;
            StageSnapshot {
                angle_rad: (motor_angle_rad - wound) * shaft,
                speed_rad_per_s: joint.speed_rad_per_s(state, stage + 1) * shaft,
                windup_rad: deflection * shaft,
                bristle: joint.bristle(state, stage + 1).to_f64() * shaft.signum(),
            }
        })
        .collect();
    Snapshot {
        current_a: joint.current_a(state),
        measured_current_a: joint.measured_current_a(state),
        motor_angle_rad,
        motor_speed_rad_per_s: joint.speed_rad_per_s(state, 0),
        motor_bristle: joint.bristle(state, 0).to_f64(),
        stages,
    }
}

/// Micro-steps that a fit of a model takes in an interval of this length.
pub fn micro_steps(model: &Model, interval_s: f64) -> u32 {
    Pace::of(&model.motor, &model.stages, &model.load).coarse_micro_steps(interval_s)
}

/// Inertia of every mass reflected to the motor, kg m², the rotor first.
pub fn inertias(model: &Model) -> Vec<f64> {
    (0..=model.stages.len())
        .map(|mass| reflected_inertia(&model.motor, &model.stages, &model.load, mass))
        .collect()
}

/// Product of the ratios η from the motor to the output.
pub fn output_shaft(model: &Model) -> f64 {
    Bases::si(&model.motor, &model.stages).shaft(model.stages.len())
}
