//! The gap budget: what a refitted nominal misses on samples that no fit has seen, and where it goes.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::blocks::{Blocks, Share};
use super::disturbance::{coordinates, disturbance_of, run_beside, title};
use super::generic::{Predicted, predicted};
use super::shares::{Disturbances, divided};
use super::unseen::Unseen;
use crate::discover::bounds::{DRIVE_RATIO, LOST, TORQUE_RATIO};
use crate::estimate::filter::{Equation, Noise, Walk};
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::record::{Channel, Record};
use crate::estimate::replicate::replicate;
use crate::estimate::{free_run, noise};
use crate::model::Model;
use crate::plant::{BuildError, Layout};
use joint_core::joint::Drive;

/// Bootstrap replicates that tell what white noise alone leaves, and the first of their seeds.
const REPLICATES: u64 = 2;
const SEED: u64 = 300;

/// Shares of what the refitted nominal misses, which add up to one.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(default)]
pub struct Budget {
    /// What the effects explain.
    pub named: f64,
    /// What still follows a coordinate of the joint, and has no name.
    pub unnamed: f64,
    /// One standard error of it.
    pub unnamed_error: f64,
    /// What is correlated in time but follows nothing: disturbance that this log cannot predict.
    pub coloured: f64,
    /// What sensors and white noise leave in the same estimate.
    pub white: f64,
    /// The equation that misses most.
    pub equation: String,
    /// The unit of that equation.
    pub unit: String,
    /// RMS of what the refitted nominal misses of it, in that unit.
    pub rms_before: f64,
    /// The same of the improved model.
    pub rms_after: f64,
    /// What the unnamed part follows; empty where there is none.
    pub unnamed_follows: String,
    /// RMS of the unnamed part over the RMS of what drives that equation: whether it matters. Motor torque
    /// drives a torque, voltage a voltage; `None` where nothing drives it.
    pub unnamed_of_drive: Option<f64>,
    /// RMS of all that is left beside white noise, in the unit of the equation.
    pub rms_left: f64,
    /// The same over the RMS of what drives that equation: to how much the model explains it.
    pub left_of_drive: Option<f64>,
}

/// Free runs of both models over samples that no fit has seen.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FreeRun {
    /// RMS error before and after by log column, in the column's unit.
    pub signals: BTreeMap<String, [f64; 2]>,
    /// `open loop`: from the state at the start of each stretch, by the logged input alone.
    pub mode: &'static str,
    /// Number of stretches.
    pub stretches: usize,
    /// Length of the longest, s.
    pub longest_s: f64,
}

/// What the evidence says.
#[derive(Clone, Debug, Default)]
pub(crate) struct Weighed {
    /// The budget; `None` where no equation could be looked at.
    pub(crate) budget: Option<Budget>,
    /// Share of every effect.
    pub(crate) shares: Vec<Share>,
    /// RMS of all that is left beside white noise over the most that is believed of friction, supply and sensors;
    /// zero where nothing could be looked at.
    pub(crate) over_believable: f64,
    /// White noise that the last mass needs over the most that is believed of friction, where it has one of its own:
    /// it takes what no state can explain.
    pub(crate) white_behind: f64,
    /// Whether the equation is what a sensor shows.
    pub(crate) of_sensor: bool,
}

/// Most that an equation is believed to be disturbed by, RMS in its unit.
fn most_scatter(equation: Equation, expected: &Noise) -> f64 {
    match equation {
        Equation::Voltage => DRIVE_RATIO * expected.drive,
        Equation::Torque(_) => TORQUE_RATIO * expected.torque,
        Equation::Sensor(channel) => LOST * expected.sensors[channel as usize],
        Equation::CurrentBefore => LOST * expected.sensors[Channel::Current as usize],
    }
}

impl Weighed {
    /// Whether more is left than friction, supply and sensors may scatter by: it has a cause that is not known.
    pub(crate) fn is_unbelievable(&self) -> bool {
        self.over_believable > 1.0 || self.white_behind > 1.0
    }
}

/// Weighs what was found. `tested` are the samples that no fit has seen; `noise` designs the filter;
/// `effects` is what unseen samples say of each.
///
/// # Errors
/// A model cannot be built.
pub(crate) fn weigh(
    problem: &Problem<'_>,
    [before, after]: [&Fit; 2],
    walk: Walk,
    [noise, expected]: [&Noise; 2],
    tested: &[bool],
    effects: &[Unseen],
) -> Result<Weighed, BuildError> {
    let record = problem.record;
    let run = |fit: &Fit| run_beside(problem, &fit.model, noise, walk);
    let (old, new) = rayon::join(|| run(before), || run(after));
    let (old, new) = (old?, new?);
    let [missed, left] = [&old, &new].map(|run| disturbance(disturbance_of(run), walk));
    if !missed.iter().chain(&left).all(|value| value.is_finite()) {
        let shares = vec![Share::default(); effects.len()];
        return Ok(Weighed { shares, ..Weighed::default() });
    }
    let blocks = Blocks::of_series(tested, &left);
    let gone = Disturbances { before: blocks.squares(&missed), after: blocks.squares(&left) };
    let named = gone.named();
    let shares = match effects {
        [] => Vec::new(),
        [_] => vec![named],
        _ => {
            let gains = effects.iter().map(|effect| blocks.sums(&effect.series));
            divided(&gone, &gains.collect::<Vec<_>>())
        }
    };
    let white = white(problem, after, walk, [noise, expected], &blocks)?;
    let layout = Layout::of(&after.model);
    let direction: Vec<f64> = new.states.iter().map(|x| x[layout.speed(0)]).collect();
    let coordinates = coordinates(problem, &after.model, &new);
    let weights = weights(&coordinates);
    let unnamed = predicted(&left, &coordinates, &weights, &direction, tested);
    let currents: Vec<f64> = new.states.iter().map(|x| x[Layout::CURRENT]).collect();
    let drive = drive(record, &after.model, walk, tested, &currents);
    let budget = split(&gone, white, unnamed.as_ref(), blocks_length(&blocks), drive);
    let (equation, unit) = title(walk.equation, record.drive, after.model.stages.len());
    let over_believable = budget.rms_left / most_scatter(walk.equation, expected);
    let white_behind = after.noise.output_times(expected) / TORQUE_RATIO;
    let of_sensor = walk.equation.is_of_a_sensor();
    let budget = Some(Budget { equation, unit: unit.to_owned(), ..budget });
    Ok(Weighed { budget, shares, over_believable, white_behind, of_sensor })
}

/// Quantities that laws are proportional to: current, speed, voltage.
fn weights<'a>(coordinates: &[(&'a str, Vec<f64>)]) -> Vec<(&'a str, Vec<f64>)> {
    let of = ["i_a", "motor_speed_rad_per_s", "u_v"];
    coordinates.iter().filter(|(name, _)| of.contains(name)).cloned().collect()
}

/// What an equation is disturbed by; of a sensor about its mean, since nobody knows an encoder's zero
/// better than to a count.
fn disturbance(mut series: Vec<f64>, walk: Walk) -> Vec<f64> {
    if walk.equation.is_of_a_sensor() {
        let mean = series.iter().sum::<f64>() / series.len().max(1) as f64;
        series.iter_mut().for_each(|value| *value -= mean);
    }
    series
}

fn blocks_length(blocks: &Blocks) -> f64 {
    blocks.ranges().iter().map(ExactSizeIterator::len).sum::<usize>().max(1) as f64
}

/// The parts, which add up to one.
fn split(
    gone: &Disturbances,
    white: f64,
    unnamed: Option<&Predicted>,
    samples: f64,
    drive: f64,
) -> Budget {
    let [before, after] = [&gone.before, &gone.after].map(|blocks| blocks.iter().sum::<f64>());
    let named = gone.named().value;
    let mut left = 1.0 - named;
    let mut take = |most: f64| {
        let taken = most.clamp(0.0, left);
        left -= taken;
        taken
    };
    let rest = 1.0 - named;
    let Share { value, error } = unnamed.map_or(Share::default(), |unnamed| unnamed.share);
    let unnamed_share = take(rest * value);
    let white = take(if before > 0.0 { white / before } else { 1.0 });
    let coloured = take(1.0);
    let rms_left = (before * (unnamed_share + coloured) / samples).sqrt();
    let rms_after = (after / samples).sqrt();
    let unnamed_rms = rms_after * (unnamed_share / rest.max(1e-12)).sqrt();
    Budget {
        named,
        unnamed: unnamed_share,
        unnamed_error: rest * error,
        coloured,
        white,
        rms_before: (before / samples).sqrt(),
        rms_after,
        unnamed_follows: unnamed.map_or(String::new(), |unnamed| {
            let own = if unnamed.by_direction { ", by direction of motion" } else { "" };
            match &unnamed.times {
                Some(quantity) => format!("{}, times {quantity}", unnamed.follows),
                None => format!("{}{own}", unnamed.follows),
            }
        }),
        unnamed_of_drive: over(unnamed_rms, drive),
        rms_left,
        left_of_drive: over(rms_left, drive),
        ..Budget::default()
    }
}

/// A remainder over what drives its equation.
fn over(rms: f64, drive: f64) -> Option<f64> {
    (drive > 0.0).then(|| rms / drive)
}

/// Squares of the disturbance that is estimated where there is none but white noise: on bootstrap
/// replicates of the improved model with the noise that it has beside a disturbance.
fn white(
    problem: &Problem<'_>,
    after: &Fit,
    walk: Walk,
    [noise, expected]: [&Noise; 2],
    blocks: &Blocks,
) -> Result<f64, BuildError> {
    let beside = problem.ahead().rough().pushed(walk);
    let own = noise::refine(&beside, &after.model, expected, &after.noise.uncoloured())?;
    let mut sum = 0.0;
    for seed in SEED..SEED + REPLICATES {
        let replicate = replicate(&after.model, problem.record, &own, seed)?;
        let problem = Problem { record: &replicate, scout: None, ..*problem };
        let run = run_beside(&problem, &after.model, noise, walk)?;
        let series = disturbance(disturbance_of(&run), walk);
        let squares: f64 = blocks.squares(&series).iter().sum();
        // A replicate that has diverged says nothing.
        sum += if squares.is_finite() { squares } else { 0.0 };
    }
    Ok(sum / REPLICATES as f64)
}

/// RMS over the tested samples of what drives the equation: motor torque, voltage, or the sensor's
/// own signal about its mean. `currents` are those of the filter: they stand in where none was measured.
fn drive(record: &Record, model: &Model, walk: Walk, tested: &[bool], currents: &[f64]) -> f64 {
    let channel = |channel: Channel| -> Vec<f64> {
        record.measured.iter().map(|row| row[channel as usize]).collect()
    };
    let (values, scale) = match (walk.equation, record.drive) {
        (Equation::Voltage, _) => (record.drive_values.clone(), 1.0),
        (Equation::Torque(_), Drive::Voltage) => {
            let measured = channel(Channel::Current);
            let known = measured.iter().zip(currents);
            let either = known.map(|(own, state)| if own.is_finite() { *own } else { *state });
            (either.collect(), model.motor.torque_constant_nm_per_a)
        }
        (Equation::Torque(_), Drive::Current) => {
            (record.drive_values.clone(), model.motor.torque_constant_nm_per_a)
        }
        (Equation::Sensor(of), _) => (channel(of), 1.0),
        (Equation::CurrentBefore, _) => (channel(Channel::Current), 1.0),
    };
    let seen = || values.iter().zip(tested).filter(|(v, t)| **t && v.is_finite()).map(|(v, _)| v);
    let count = seen().count().max(1) as f64;
    let mean = match walk.equation {
        Equation::Sensor(_) => seen().sum::<f64>() / count,
        _ => 0.0,
    };
    scale * (seen().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt()
}

impl FreeRun {
    /// Of two models over the stretches of samples that no fit has seen.
    ///
    /// # Errors
    /// A model cannot be built.
    pub(crate) fn of(
        record: &Record,
        [before, after]: [&Fit; 2],
        noise: &Noise,
        tested: &[bool],
    ) -> Result<Self, BuildError> {
        let stretches = free_run::stretches(record, tested);
        let run = |fit: &Fit| free_run::errors(&fit.model, record, noise, &stretches);
        let (old, new) = rayon::join(|| run(before), || run(after));
        let (old, new) = (old?, new?);
        let signals = Channel::ALL
            .into_iter()
            .filter_map(|channel| {
                let c = channel as usize;
                Some((channel.column().to_owned(), [old[c]?, new[c]?]))
            })
            .collect();
        let length = |range: &std::ops::Range<usize>| {
            record.time_s[range.end - 1] - record.time_s[range.start]
        };
        let longest_s = stretches.iter().map(length).fold(0.0, f64::max);
        Ok(Self { signals, mode: "open loop", stretches: stretches.len(), longest_s })
    }

    /// Error after over that before, the geometric mean of the signals.
    pub(crate) fn factor(&self) -> f64 {
        let logs = self.signals.values().map(|[before, after]| (after / before).ln());
        (logs.sum::<f64>() / self.signals.len().max(1) as f64).exp()
    }
}

#[cfg(test)]
mod tests;
