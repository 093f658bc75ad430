//! The next experiment: of excitations that a bench can run, the one that would tell two rival models
//! apart most surely, ready to be run.
//!
//! Every excitation is run on both models with the log's own noise, and each record is then judged by
//! both filters: what the wrong model loses of the log-likelihood is what the experiment is worth. An
//! excitation is made smaller until the joint stays within the travel that the log has shown.

use std::f64::consts::TAU;

use joint_core::joint::Drive;
use rayon::prelude::*;

use crate::discover::state::stage::Stage;
use crate::estimate::fit::Problem;
use crate::estimate::record::{CHANNELS, Channel, Record};
use crate::estimate::replicate::replicate;
use crate::log::Log;
use crate::model::Model;
use crate::plant::{BuildError, Layout, Plant, plant};

/// Most samples of an experiment.
const SAMPLES: usize = 8000;
/// How much further than in the log the rotor may travel.
const TRAVEL: f64 = 1.2;
/// Times an excitation is made smaller before it is given up.
const SHRINKS: usize = 12;

/// An excitation.
#[derive(Clone, Copy, Debug)]
struct Excitation {
    name: &'static str,
    /// Drive over the largest of the log, from the share of the duration, the duration in s and the
    /// interval in s.
    shape: fn(f64, f64, f64) -> f64,
}

const EXCITATIONS: [Excitation; 6] = [
    Excitation { name: "slow reversals", shape: |x, _, _| 0.4 * triangle(3.0 * x) },
    Excitation {
        name: "fast reversals",
        shape: |x, _, _| (4.0 * triangle(12.0 * x)).clamp(-1.0, 1.0),
    },
    Excitation {
        name: "a staircase through zero",
        shape: |x, _, _| 0.6 * (8.0 * triangle(2.0 * x)).round() / 8.0,
    },
    Excitation {
        name: "a sweep of frequencies",
        shape: |x, duration, interval| {
            let (low, high) = (1.0 / duration, 0.05 / interval);
            let rate = (high / low).ln();
            0.5 * (TAU * low * duration * ((rate * x).exp() - 1.0) / rate).sin()
        },
    },
    Excitation {
        name: "high speed both ways",
        shape: |x, _, _| (3.0 * triangle(x)).clamp(-1.0, 1.0),
    },
    Excitation {
        name: "small reversals on a steady drive",
        shape: |x, _, _| 0.4 + 0.3 * triangle(20.0 * x),
    },
];

/// A triangle wave of period one between -1 and 1, from zero upwards.
fn triangle(x: f64) -> f64 {
    let x = (x + 0.25).rem_euclid(1.0);
    1.0 - 4.0 * (x - 0.5).abs()
}

/// An experiment worth doing.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// The excitation in words.
    pub name: &'static str,
    /// What imposes it.
    pub drive: Drive,
    /// Sample times, s.
    pub time_s: Vec<f64>,
    /// Volts or amperes.
    pub values: Vec<f64>,
    /// Rotor angle that the improved model expects, rad.
    pub expected_rad: Vec<f64>,
    /// Log-likelihood by which the rivals would be told apart, before their refits.
    pub worth: f64,
    /// The same with an encoder behind the last stage, where the log had none.
    pub with_output: Option<f64>,
}

impl Experiment {
    /// As an input that `joint simulate` and a bench take, with the angle that is to be expected.
    pub fn csv(&self) -> String {
        use std::fmt::Write as _;
        let column = if self.drive == Drive::Voltage { "u_v" } else { "i_a" };
        let mut text = format!("t_s,{column},motor_angle_rad\n");
        let rows = self.time_s.iter().zip(&self.values).zip(&self.expected_rad);
        for ((time, value), angle) in rows {
            let _ = writeln!(text, "{time:.6},{value:.5},{angle:.6}");
        }
        text
    }
}

/// The experiment that tells two models apart best.
///
/// # Errors
/// A model cannot be built.
pub(crate) fn experiment(
    record: &Record,
    micro_steps: u32,
    rivals: [&Stage; 2],
) -> Result<Option<Experiment>, BuildError> {
    let largest = record.drive_values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let interval = record.grid.typical_interval();
    let samples = record.len().min(SAMPLES);
    let tried = EXCITATIONS
        .par_iter()
        .map(|excitation| {
            let duration = samples as f64 * interval;
            let at = |k: usize| {
                let share = k as f64 / samples as f64;
                largest * (excitation.shape)(share, duration, interval)
            };
            let mut input = blank(record, interval, (0..samples).map(at).collect(), micro_steps);
            if !stays(&mut input, rivals, travel(record))? {
                return Ok(None);
            }
            Ok(Some((excitation.name, worth(&input, rivals)?, input)))
        })
        .collect::<Result<Vec<_>, BuildError>>()?;
    let best = tried.into_iter().flatten().max_by(|(_, a, _), (_, b, _)| a.total_cmp(b));
    let Some((name, worth, input)) = best else { return Ok(None) };
    let unseen = !record.has(Channel::Output) && !rivals[0].origin.stages.is_empty();
    let with_output = unseen.then(|| {
        let mut seen = input.clone();
        seen.measured.iter_mut().for_each(|row| row[Channel::Output as usize] = 0.0);
        self::worth(&seen, rivals)
    });
    Ok(Some(Experiment {
        name,
        drive: input.drive,
        expected_rad: path(&rivals[0].fit.model, &input)?,
        time_s: input.time_s,
        values: input.drive_values,
        worth,
        with_output: with_output.transpose()?,
    }))
}

/// A record with the log's channels and nothing in them yet.
fn blank(record: &Record, interval: f64, drive_values: Vec<f64>, micro_steps: u32) -> Record {
    let time_s: Vec<f64> = (0..drive_values.len()).map(|k| k as f64 * interval).collect();
    let row: [f64; CHANNELS] =
        Channel::ALL.map(|channel| if record.has(channel) { 0.0 } else { f64::NAN });
    let log = Log { time_s, motor_angle_rad: vec![0.0; drive_values.len()], ..Log::default() };
    let mut blank = Record::new(&log, Some(micro_steps));
    blank.drive = record.drive;
    blank.measured = vec![row; drive_values.len()];
    blank.drive_values = drive_values;
    blank
}

/// How far the rotor goes from where the log begins, rad, to either side.
fn travel(record: &Record) -> f64 {
    let angles = record.measured.iter().map(|row| row[Channel::Motor as usize]);
    let mut finite = angles.filter(|angle| angle.is_finite());
    let first = finite.next().unwrap_or(0.0);
    TRAVEL * finite.fold(0.0_f64, |most, angle| most.max((angle - first).abs()))
}

/// Makes an excitation small enough for both models to stay within a travel; false where that does not
/// help.
fn stays(input: &mut Record, rivals: [&Stage; 2], travel: f64) -> Result<bool, BuildError> {
    let [one, other] = rivals.map(|rival| plant(&rival.fit.model, &input.grid, input.drive));
    let plants = [one?, other?];
    for _ in 0..SHRINKS {
        let mut both = plants.iter().zip(rivals);
        let within = both.all(|(plant, rival)| {
            angles(plant.as_ref(), &rival.fit.model, input).all(|angle| angle.abs() <= travel)
        });
        if within {
            return Ok(true);
        }
        input.drive_values.iter_mut().for_each(|value| *value *= 0.8);
    }
    Ok(false)
}

/// The rotor's angle along an excitation, rad.
fn path(model: &Model, input: &Record) -> Result<Vec<f64>, BuildError> {
    let plant = plant(model, &input.grid, input.drive)?;
    Ok(angles(&*plant, model, input).collect())
}

/// The same as far as somebody asks.
fn angles(plant: &dyn Plant, model: &Model, input: &Record) -> impl Iterator<Item = f64> {
    let mut state = vec![0.0; Layout::of(model).len()];
    input.drive_values.iter().enumerate().map(move |(k, value)| {
        let here = state[Layout::ANGLE];
        plant.propagate(k, &mut state, *value, 0.0);
        here
    })
}

/// What the wrong model loses on records of either, on average, in log-likelihood.
fn worth(input: &Record, rivals: [&Stage; 2]) -> Result<f64, BuildError> {
    let lost = |[right, wrong]: [&Stage; 2]| {
        let record = replicate(&right.fit.model, input, &right.fit.noise, 7)?;
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask);
        let own = problem.design(&right.fit.model, &right.fit.noise)?.deviance;
        let other = problem.design(&wrong.fit.model, &wrong.fit.noise)?.deviance;
        Ok::<_, BuildError>((other - own) / 2.0)
    };
    let [one, other] = rivals;
    let (lost_by_other, lost_by_one) = rayon::join(|| lost(rivals), || lost([other, one]));
    Ok((lost_by_other? + lost_by_one?) / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_excitation_keeps_within_the_largest_drive() {
        for excitation in EXCITATIONS {
            for k in 0..1000 {
                let value = (excitation.shape)(f64::from(k) / 1000.0, 2.0, 1e-3);
                assert!(value.abs() <= 1.0, "{} at {k}: {value}", excitation.name);
            }
        }
    }

    #[test]
    fn a_triangle_starts_at_zero_upwards_and_comes_back() {
        let at = |x: f64| (triangle(x) * 1e12).round() / 1e12;
        assert_eq!([at(0.0), at(0.25), at(0.5), at(0.75)], [0.0, 1.0, 0.0, -1.0]);
    }
}
