//! What was found weighed in proportion, the answer, and everything that is told beside it.

use std::time::Instant;

use indicatif::ProgressBar;
use joint_core::effect::Kind;
use joint_core::params::Location;

use super::decision::{answered, matters, weighed};
use super::explained::Stepped;
use super::findings::{Answer, Findings, Gap, Verdict, Whereabouts};
use super::gap::shown;
use super::located::Located;
use super::named::named;
use super::next_experiment::{advice, blind, told};
use super::possible::{possible, unnamed};
use super::reasons::{reasons, unbelievable};
use super::rows::{noise_rows, parameter_rows};
use super::split::Split;
use crate::discover::bounds::SEPARATION;
use crate::discover::checks::confirmed::Witnessed;
use crate::discover::checks::goodness_of_fit::Remainder;
use crate::discover::error::DiscoverError;
use crate::discover::evidence::budget::{FreeRun, Weighed};
use crate::discover::evidence::rest::{Rest, mapped};
use crate::discover::state::constant::Constant;
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::finer::finer;
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::scout::Scout;
use crate::interrupt;
use crate::log::Log;
use crate::model::Model;
use crate::plant::BuildError;
use crate::preflight;

/// What is to be concluded from.
pub(crate) struct Conclusion<'a> {
    /// The model as it was given.
    pub(crate) given: &'a Model,
    /// The same with the shape of friction that the joint has.
    pub(crate) nominal: &'a Model,
    /// What was found.
    pub(crate) found: &'a Search,
    /// The record that it was found in.
    pub(crate) stepped: &'a Stepped,
    /// Which of its samples no fit has seen.
    pub(crate) split: &'a Split,
    /// Where a person reads what is done.
    pub(crate) bar: &'a ProgressBar,
}

/// The evidence in proportion.
struct Evidence {
    weighed: Weighed,
    free_run: FreeRun,
    gap: Gap,
    answer: Answer,
    /// What repeats without a name, as a map.
    rest: Option<Rest>,
}

impl Conclusion<'_> {
    /// The findings; `left` is what the improved model leaves on samples that were fitted to, `unseen` what the others
    /// say of each effect. The logs have so many samples whose input is known.
    ///
    /// # Errors
    /// A model cannot be built.
    pub(crate) fn findings(
        &self,
        located: Located<'_>,
        mut left: Remainder,
        unseen: &[Witnessed],
        logs: (&[Log], usize),
        began: Instant,
    ) -> Result<Findings, DiscoverError> {
        let Self { given, nominal, found, stepped, split, .. } = self;
        let (record, fitted) = (&stepped.record, &split.fitted);
        let gap = located.gap();
        if gap.floor > 0.0 {
            left.unseen = gap.after / gap.floor;
        }
        let complaints = left.complaints(found.rounds.is_empty());
        let Evidence { weighed, free_run, gap, answer, rest } =
            self.evidence(&located, &left, gap, unseen)?;
        let covariance = Problem::new(record, fitted).covariance(&found.after.fit);
        let after = &self.settled()?;
        // A nominal that lacks something is off by more than its steps.
        let before = if found.rounds.is_empty() { after } else { &found.before.fit };
        let clean = complaints.is_empty() && self.constant().is_none();
        let effects =
            named((found, after), nominal.effects.len(), clean, (&weighed, unseen), &covariance);
        let explained = weighed.budget.as_ref().map_or(0.0, |budget| budget.named);
        let unnamed = rest.as_ref().and_then(|rest| unnamed(rest, 1.0 - explained));
        let next_experiment = self.advice(answer, &located);
        let mut reasons = self.reasons(&gap, &complaints, logs);
        reasons.extend(unbelievable(&weighed));
        let disagreement = located.disagreement;
        let whereabouts = match answer {
            Answer::Adequate => Whereabouts { equation: "none".into(), ..Whereabouts::default() },
            _ => disagreement.whereabouts,
        };
        let verdict = Verdict {
            verdict: answer,
            effects,
            possible: possible(found, fitted),
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
            nominal: (*given).clone(),
            refitted: record.timed(before.model.clone()),
            improved: record
                .timed(rest.map_or_else(|| after.model.clone(), |rest| rest.stage.fit.model)),
            time_s: record.time_s.clone(),
            held_out: split.held_out.clone(),
            before: shown(record, &located.before),
            after: shown(record, &located.after),
            disturbance: disagreement.disturbance,
            shape: disagreement.shape,
            courses: disagreement.courses,
            angles: disagreement.angles,
            orders: located.orders,
            parameters: parameter_rows(nominal, before, after, &covariance),
            scores: found.scores.clone(),
            noises: noise_rows(found, record),
            left,
            experiment: located.experiment,
        })
    }

    /// The improved model with the values of the finest steps.
    fn settled(&self) -> Result<Fit, BuildError> {
        let Self { found, stepped, split, bar, .. } = self;
        bar.set_message("taking the values at finer steps");
        let Stage { fit, origin } = &found.after;
        finer(&Problem::new(&stepped.finest, &split.fitted), origin, fit)
    }

    /// The kind that cannot be told from a constant torque, if one was named: gravity.
    fn constant(&self) -> Option<Kind> {
        let undecided = self.found.constant.filter(Constant::undecided);
        undecided.map(|constant| constant.of)
    }

    /// What was found in proportion, the answer, and a map of what has no name where that matters.
    fn evidence(
        &self,
        located: &Located<'_>,
        left: &Remainder,
        gap: Gap,
        unseen: &[Witnessed],
    ) -> Result<Evidence, BuildError> {
        let Self { nominal, found, split, bar, .. } = self;
        let record = &self.stepped.record;
        bar.set_message("weighing what was found on samples that no fit has seen");
        let every = vec![1.0; record.len()];
        let scout = Scout::of(record, &split.fitted, nominal);
        let looked_at = Problem::new(record, &every).scouted(scout.as_ref());
        let (walk, held_out) = (located.disagreement.walk, &split.held_out);
        let (weighed, free_run) =
            weighed(&looked_at, found, walk, &located.calm, held_out, unseen)?;
        let answer = match answered(!found.rounds.is_empty(), left, &weighed) {
            Answer::Adequate if interrupt::asked() => Answer::Unknown,
            _ if self.constant().is_some() => Answer::Unknown,
            answer => answer,
        };
        let matters = weighed.budget.as_ref().is_some_and(matters) && !interrupt::asked();
        let walk = walk.filter(|_| answer == Answer::Unknown && matters);
        let plain = Evidence { weighed, free_run, gap, answer, rest: None };
        let Some(walk) = walk else { return Ok(plain) };
        bar.set_message("laying what has no name into a map");
        let problem = Problem::new(record, &split.fitted);
        let noises = [&located.calm, &found.expected];
        let Some(rest) = mapped(&problem, &found.after, walk, noises, held_out)? else {
            return Ok(plain);
        };
        // A map that no unseen sample is predicted better with stays out.
        Ok(match located.with_map(&rest, &plain.gap)? {
            Some((gap, free_run)) => Evidence { free_run, gap, rest: Some(rest), ..plain },
            None => plain,
        })
    }

    /// What to measure next, in a sentence.
    fn advice(&self, answer: Answer, located: &Located<'_>) -> String {
        let found = self.found;
        let close = found.rounds.first().and_then(|round| {
            let rival = round.rivals.first()?;
            (round.gain - rival.gain < 3.0 * SEPARATION).then_some(rival.name)
        });
        let names: Vec<(Kind, Location)> = found.rounds.iter().map(|round| round.name).collect();
        let equation = &located.disagreement.whereabouts.equation;
        let blind = blind(self.nominal, &self.stepped.record);
        let mut text = advice(answer, &names, close, blind, self.constant(), equation);
        if let Some(experiment) = &located.experiment {
            text += &told(experiment);
        }
        text
    }

    /// Why the answer is what it is, and what of the logs was not looked at.
    fn reasons(
        &self,
        gap: &Gap,
        complaints: &[String],
        (logs, samples): (&[Log], usize),
    ) -> Vec<String> {
        let record = &self.stepped.record;
        let mut reasons = reasons(self.found, (self.given, record), gap, complaints);
        let all: usize = logs.iter().map(Log::len).sum();
        if all > samples {
            let silent = all - samples;
            reasons
                .push(format!("{silent} samples were left out: nothing says what drove the joint"));
        }
        if samples > record.len() {
            reasons.push(format!(
                "of {samples} samples {} were looked at, in stretches over the whole log",
                record.len()
            ));
        }
        let doubts = logs.iter().flat_map(|log| preflight::doubts(self.nominal, log));
        let mut doubts: Vec<_> = doubts.collect();
        doubts.sort();
        doubts.dedup();
        reasons.splice(0..0, doubts);
        if interrupt::asked() {
            reasons.insert(0, "interrupted: this is what was known by then".to_owned());
        }
        reasons
    }
}
