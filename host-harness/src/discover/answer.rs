//! From logs to an answer.
//!
//! The search runs on seven tenths of the record, in blocks; the rest is kept to measure the gap,
//! so that neither a parameter nor a name was chosen on it. The gate then decides whether what was
//! found is all there is.

use std::time::Instant;

use indicatif::ProgressBar;
use joint_core::effect::Kind;
use joint_core::params::Location;

use super::coloured::{beside_disturbance, stands, without_disturbance};
use super::confidence::SEPARATION;
use super::constant::ask_constant;
use super::evidence::{Elsewhere, FreeRun, cannot_tell, mapped};
use super::experiment::{Experiment, experiment};
use super::findings::{Answer, Findings, Gap, Verdict, Whereabouts};
use super::finer::{ask_finer, is_suspect, run_everywhere};
use super::gate::{Remainder, rms};
use super::gear_or_encoder::ask_encoder;
use super::named::named;
use super::next_experiment::advice;
use super::proportion::{answered, keep_borne_out, matters, possible, weighed};
use super::reasons::reasons;
use super::rows::{noise_rows, parameter_rows};
use super::search::{CALM, Search, excess};
use super::shaped::shaped;
use super::timing::search_timed;
use super::undecided::undecided;
use super::whereabouts::locate;
use crate::estimate::filter::Noise;
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::record::{CHANNELS, Channel, JoinError, Record};
use crate::estimate::scout::Scout;
use crate::interrupt;
use crate::log::Log;
use crate::model::Model;
use crate::plant::{BuildError, micro_steps};
use crate::preflight::{self, LEAST_SAMPLES};

/// Blocks of a log, and those that are held out.
const BLOCKS: usize = 10;
const HELD_OUT: [usize; 3] = [3, 6, 9];
/// How many times finer the step is made to say more closely what is missing.
const FINER: u32 = 2;
/// The same where the step may be what is missing.
const FINEST: u32 = 4;
/// Samples that are looked at; longer logs are thinned to stretches.
const MOST_SAMPLES: usize = 60_000;

/// Units of log-likelihood beyond which an experiment is sure to tell two models apart.
const SURE: f64 = 1000.0;

/// Why there is no answer.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DiscoverError {
    /// The model cannot be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The logs do not fit together.
    #[error(transparent)]
    Join(#[from] JoinError),
    /// Another record imposes something else.
    #[error(
        "a record for transfer is driven by another quantity than the logs: all need u_v, or none"
    )]
    Elsewhere,
    /// Too little to learn from.
    #[error("the logs have {0} samples; give at least {LEAST_SAMPLES}")]
    Short(usize),
}

/// Finds what a model misses in logs of its joint.
///
/// # Errors
/// The model cannot be built, or the logs do not fit together or are too short.
pub fn discover(
    nominal: &Model,
    logs: &[Log],
    bar: &ProgressBar,
) -> Result<Findings, DiscoverError> {
    discover_without(nominal, logs, &[], bar)
}

/// The same without some kinds of effects, as if they were not on the list.
///
/// # Errors
/// As [`discover`].
pub fn discover_without(
    nominal: &Model,
    logs: &[Log],
    withdrawn: &[Kind],
    bar: &ProgressBar,
) -> Result<Findings, DiscoverError> {
    discover_beside(nominal, (logs, &[]), withdrawn, bar)
}

/// The same with other records of the joint, to which nothing is fitted: an effect that they speak against
/// beyond its standard error is only possible.
///
/// # Errors
/// As [`discover`]; or another record is driven by another quantity.
pub fn discover_beside(
    nominal: &Model,
    (logs, others): (&[Log], &[Log]),
    withdrawn: &[Kind],
    bar: &ProgressBar,
) -> Result<Findings, DiscoverError> {
    let began = Instant::now();
    let whole = Record::join(logs, None)?;
    let samples = whole.len();
    if samples < LEAST_SAMPLES {
        return Err(DiscoverError::Short(samples));
    }
    let coarse = whole.thinned(MOST_SAMPLES);
    // The filter corrects every sample, so that one interval need be right, not a whole run.
    let fewest = micro_steps(nominal, coarse.grid.typical_interval());
    let micro_steps = (fewest / 2).max(2).min(fewest);
    let lacking = cannot_tell(&coarse);
    if !lacking.is_empty() {
        return Ok(undecided(nominal, &coarse, lacking, began));
    }
    let mut record = coarse.refined(micro_steps);
    let held_out = held_out(&record);
    let fitted: Vec<f64> = held_out.iter().map(|held| if *held { 0.0 } else { 1.0 }).collect();
    let tested: Vec<f64> = held_out.iter().map(|held| if *held { 1.0 } else { 0.0 }).collect();
    let measured = preflight::measured(nominal, logs);
    let known = (withdrawn, &measured[..]);
    let (timed, mut found) = search_timed(record, &fitted, nominal, known, bar)?;
    record = timed;
    let problem = Problem::new(&record, &fitted);

    bar.set_message("asking whether what is left is noise");
    let mut remainder = Remainder::of(&problem, &found.after.fit, &found.expected, &fitted)?;
    let mut noise = remainder.complaints(found.rounds.is_empty()).is_empty();
    let mut shape = None;
    if (!noise || excess(&found) > CALM)
        && let Some((model, other)) = shaped(problem, nominal, &found, known, bar)?
    {
        (shape, found) = (Some(model), other);
        remainder = Remainder::of(&problem, &found.after.fit, &found.expected, &fitted)?;
        // A shape is another law's near likeness: what it leaves may be a disturbance even if it passes for noise.
        noise = false;
    }
    let given = nominal;
    let nominal = shape.as_ref().unwrap_or(nominal);
    let mut beside = beside_disturbance(problem, &found, noise)?;
    if !noise
        && let Some(other) = &beside
        && let Some(better) = without_disturbance(problem, &found, other)?
    {
        found = better;
        remainder = Remainder::of(&problem, &found.after.fit, &found.expected, &fitted)?;
        noise = remainder.complaints(found.rounds.is_empty()).is_empty();
        beside = beside_disturbance(problem, &found, noise)?;
    }
    if let Some(other) = beside
        && stands(problem, &found, &other)?
    {
        found = other;
        remainder = Remainder::of(&problem, &found.after.fit, &found.expected, &fitted)?;
    }
    let sound = remainder.complaints(false).is_empty() && !is_suspect(&found);
    let finest = record.refined(micro_steps * FINEST);
    let finer = if sound { record.refined(micro_steps * FINER) } else { finest.clone() };
    let mut stepped = micro_steps;
    if !found.rounds.is_empty()
        && !interrupt::asked()
        && let Some(left) = ask_finer(&Problem::new(&finer, &fitted), &mut found, &remainder)?
    {
        remainder = left;
        record = finer;
        stepped *= if sound { FINER } else { FINEST };
    }
    let problem = Problem::new(&record, &fitted);
    if !interrupt::asked() {
        ask_constant(&problem, &mut found)?;
        ask_encoder(&problem, &mut found);
    }

    let names = found.rounds.len();
    let other = |log| Elsewhere::new(log, &record, (MOST_SAMPLES, stepped));
    let others: Vec<_> = others.iter().map(other).collect::<Result<_, _>>()?;
    let noise = remainder.complaints(false).is_empty();
    let unseen = keep_borne_out(&problem, &mut found, (&held_out, &others), noise)?;
    if found.rounds.len() < names {
        remainder = Remainder::of(&problem, &found.after.fit, &found.expected, &fitted)?;
    }
    bar.set_message("locating what is left, and what to measure next");
    let (before, after) = (&found.before.fit, &found.after.fit);
    // Where nothing was found, the gap is counted in noise that is believable, not in noise that
    // hides what is missing.
    let noise = match found.rounds.is_empty() {
        true => believable(&after.noise, &found.expected),
        false => after.noise,
    };
    let run = |fit: &Fit| run_everywhere([&record, &finest], fit, &noise);
    let (run_before, run_after) = rayon::join(|| run(before), || run(after));
    let [(record_before, innovations_before), (record_after, innovations_after)] =
        [run_before?, run_after?];
    let every = vec![1.0; record.len()];
    let everywhere = Problem::new(record_after, &every);
    let orders = orders(&found);
    let first = found.rounds.first().map(|round| round.name.0);
    let along_lines = !found.orders.is_empty() || first == Some(Kind::Cogging);
    // Noise that swallows what is missing would leave no equation to blame for it, and so would a disturbance.
    let calm = believable(&noise, &found.expected).uncoloured();
    let judged = Fit { noise, ..after.clone() };
    let floor = || Remainder::of(&everywhere, &judged, &found.expected, &tested);
    let place = || {
        let scout = Scout::of(record_before, &fitted, nominal);
        let problem = Problem::new(record_before, &fitted).scouted(scout.as_ref());
        locate(&problem, &found.before, &after.model, &calm, &orders, along_lines)
    };
    let next = || decisive(&found, &record, micro_steps);
    let (floor, (disagreement, experiment)) = rayon::join(floor, || rayon::join(place, next));
    let (floor, disagreement, experiment) = (floor?, disagreement?, experiment?);
    let gap = gap(&record, &innovations_before, &innovations_after, &floor, &tested);
    if gap.floor > 0.0 {
        remainder.unseen = gap.after / gap.floor;
    }
    let complaints = remainder.complaints(found.rounds.is_empty());
    let constant = found.constant.is_some_and(|constant| constant.undecided());
    bar.set_message("weighing what was found on samples that no fit has seen");
    let scout = Scout::of(&record, &fitted, nominal);
    let looked_at = Problem::new(&record, &every).scouted(scout.as_ref());
    let walk = disagreement.walk;
    let (weighed, free_run) = weighed(&looked_at, &found, walk, &calm, &held_out, &unseen)?;
    let answer = match answered(!found.rounds.is_empty(), &remainder, &weighed) {
        Answer::Adequate if interrupt::asked() => Answer::Unknown,
        _ if constant => Answer::Unknown,
        answer => answer,
    };
    let (mut gap, mut free_run) = (gap, free_run);
    let matters = weighed.budget.as_ref().is_some_and(matters) && !interrupt::asked();
    let mut rest = match walk.filter(|_| answer == Answer::Unknown && matters) {
        Some(walk) => {
            bar.set_message("laying what has no name into a map");
            mapped(&problem, &found.after, walk, [&calm, &found.expected], &held_out)?
        }
        None => None,
    };
    if let Some(own) = &rest {
        let (_, rows) = run(&own.stage.fit)?;
        let with = self::gap(&record, &innovations_before, &rows, &floor, &tested);
        // A map that no unseen sample is predicted better with stays out.
        if with.after < gap.after {
            free_run = FreeRun::of(&record, [before, &own.stage.fit], &calm, &held_out)?;
            gap = with;
        } else {
            rest = None;
        }
    }
    let covariance = problem.covariance(after);
    let clean = complaints.is_empty() && !constant;
    let effects = named(&found, nominal.effects.len(), clean, (&weighed, &unseen), &covariance);
    let explained = weighed.budget.as_ref().map_or(0.0, |budget| budget.named);
    let unnamed = rest.as_ref().and_then(|rest| rest.told(1.0 - explained));
    let close = found.rounds.first().and_then(|round| {
        let rival = round.rivals.first()?;
        (round.gain - rival.gain < 3.0 * SEPARATION).then_some(rival.name)
    });
    let names: Vec<(Kind, Location)> = found.rounds.iter().map(|round| round.name).collect();
    let equation = disagreement.whereabouts.equation.clone();
    let unseen = blind(nominal, &record);
    let mut next_experiment = advice(answer, &names, close, unseen, constant, &equation);
    if let Some(experiment) = &experiment {
        next_experiment += &told(experiment);
    }
    let mut reasons = reasons(&found, &record, &gap, &complaints);
    reasons.extend(weighed.told());
    let all: usize = logs.iter().map(Log::len).sum();
    if all > samples {
        let silent = all - samples;
        reasons.push(format!("{silent} samples were left out: nothing says what drove the joint"));
    }
    if samples > record.len() {
        reasons.push(format!(
            "of {samples} samples {} were looked at, in stretches over the whole log",
            record.len()
        ));
    }
    let mut doubts: Vec<_> = logs.iter().flat_map(|log| preflight::doubts(nominal, log)).collect();
    doubts.sort();
    doubts.dedup();
    reasons.splice(0..0, doubts);
    if interrupt::asked() {
        reasons.insert(0, "interrupted: this is what was known by then".to_owned());
    }
    let whereabouts = match answer {
        Answer::Adequate => Whereabouts { equation: "none".into(), ..Whereabouts::default() },
        _ => disagreement.whereabouts,
    };
    let verdict = Verdict {
        verdict: answer,
        effects,
        possible: possible(&found, &fitted),
        unnamed: Vec::from_iter(unnamed),
        whereabouts,
        gap,
        budget: weighed.budget,
        free_run,
        next_experiment,
        seconds: began.elapsed().as_secs_f64(),
        reasons,
    };
    Ok(Findings {
        verdict,
        nominal: given.clone(),
        refitted: before.model.clone(),
        improved: rest.map_or_else(|| after.model.clone(), |rest| rest.stage.fit.model),
        time_s: record.time_s.clone(),
        held_out,
        before: shown(&record, &innovations_before),
        after: shown(&record, &innovations_after),
        push: disagreement.push,
        shape: disagreement.shape,
        courses: disagreement.courses,
        angles: disagreement.angles,
        orders,
        parameters: parameter_rows(nominal, before, after, &covariance),
        scores: found.scores.clone(),
        noises: noise_rows(&found, &record),
        left: remainder,
        experiment,
    })
}

/// The experiment that would tell the name from its best rival, or from nothing where it has none.
fn decisive(
    found: &Search,
    record: &Record,
    micro_steps: u32,
) -> Result<Option<Experiment>, BuildError> {
    if interrupt::asked() {
        return Ok(None);
    }
    let Some(round) = found.rounds.last() else { return Ok(None) };
    let rival = round.runner_up.as_ref().unwrap_or(&found.before);
    experiment(record, micro_steps, [&found.after, rival])
}

/// An experiment in a sentence. What tells two models apart beyond doubt is told no closer: parameters that
/// may still move would take most of it.
fn told(experiment: &Experiment) -> String {
    let units = |worth: f64| match worth > SURE {
        true => format!("more than {SURE:.0}"),
        false => format!("{worth:.0}"),
    };
    let mut text = format!(
        "; the input in next_experiment.csv ({}) would separate the best two models by {} units of log-likelihood",
        experiment.name,
        units(experiment.worth),
    );
    if let Some(seen) = experiment.with_output {
        text += &format!(", with an encoder behind the last stage by {}", units(seen));
    }
    text
}

/// Orders of the rotor angle: those of the lines that were added, the strongest first, then what
/// else explained something.
fn orders(found: &Search) -> Vec<f64> {
    let effects = found.after.fit.model.effects.iter();
    let mut lines: Vec<[f64; 2]> = effects
        .filter(|effect| effect.kind == Kind::Cogging)
        .map(|effect| [effect.values[0], effect.values[1].abs()])
        .collect();
    lines.sort_by(|a, b| b[1].total_cmp(&a[1]));
    let mut orders: Vec<f64> = lines.iter().map(|[order, _]| *order).collect();
    for order in &found.orders {
        if !orders.iter().any(|known| (known - order).abs() < 0.5) {
            orders.push(*order);
        }
    }
    orders
}

/// Noise that is at most twice what is expected.
fn believable(noise: &Noise, expected: &Noise) -> Noise {
    Noise {
        drive: noise.drive.min(2.0 * expected.drive),
        torque: noise.torque.min(2.0 * expected.torque),
        output: noise.output.min(2.0 * expected.output),
        ..*noise
    }
}

/// Whether there are stages that no sensor looks behind.
fn blind(model: &Model, record: &Record) -> bool {
    !model.stages.is_empty() && !record.has(Channel::Output)
}

/// Which samples no fit sees, nor any choice but that of a weak name: whole blocks of every log.
fn held_out(record: &Record) -> Vec<bool> {
    let mut held = vec![false; record.len()];
    for (number, start) in record.starts.iter().enumerate() {
        let end = record.starts.get(number + 1).copied().unwrap_or(record.len());
        for (k, held) in held.iter_mut().enumerate().take(end).skip(*start) {
            *held = HELD_OUT.contains(&((k - start) * BLOCKS / (end - start)));
        }
    }
    held
}

fn gap(
    record: &Record,
    before: &[[f64; CHANNELS]],
    after: &[[f64; CHANNELS]],
    floor: &Remainder,
    mask: &[f64],
) -> Gap {
    let signals = Channel::ALL
        .into_iter()
        .filter(|channel| record.has(*channel))
        .map(|channel| {
            let c = channel as usize;
            let own = |rows| rms(rows, mask, Some(c));
            (channel.column().to_owned(), [own(before), own(after), floor.floor[c]])
        })
        .collect();
    Gap {
        before: rms(before, mask, None),
        after: rms(after, mask, None),
        floor: floor.floor_all,
        unit: "noise sigmas, held-out part",
        signals,
    }
}

/// Innovations for show: NaN where nothing is measured.
fn shown(record: &Record, rows: &[[f64; CHANNELS]]) -> Vec<[f64; CHANNELS]> {
    rows.iter()
        .zip(&record.measured)
        .map(|(row, measured)| {
            std::array::from_fn(|c| if measured[c].is_finite() { row[c] } else { f64::NAN })
        })
        .collect()
}
