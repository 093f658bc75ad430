//! What a search found goes on beside what may look like a missing effect and is none, and at finer steps.

use indicatif::ProgressBar;
use joint_core::effect::{EffectParameters, Kind};

use super::split::Split;
use crate::discover::bounds::CALM;
use crate::discover::checks::confirmed::{Witnessed, keep_confirmed};
use crate::discover::checks::finer_steps::{ask_finer, is_suspect};
use crate::discover::checks::goodness_of_fit::Remainder;
use crate::discover::error::DiscoverError;
use crate::discover::evidence::elsewhere::Elsewhere;
use crate::discover::nuisances::coloured::{beside_disturbance, stands, without_disturbance};
use crate::discover::nuisances::friction_shape::shaped;
use crate::discover::state::search::Search;
use crate::estimate::fit::Problem;
use crate::estimate::record::Record;
use crate::interrupt;
use crate::log::Log;
use crate::model::Model;
use crate::plant::BuildError;

/// How many times finer the step is made to say more closely what is missing.
pub(crate) const FINER: u32 = 2;
/// The same where the step may be what is missing.
const FINEST: u32 = 4;

/// What was found, and what it leaves.
pub(crate) struct Explained {
    /// The nominal with friction of another shape, where the joint has it.
    pub(crate) shape: Option<Model>,
    /// What was found.
    pub(crate) found: Search,
    /// What that leaves.
    pub(crate) left: Remainder,
}

impl Explained {
    /// What a search found goes on with friction of another shape and beside a coloured disturbance.
    ///
    /// # Errors
    /// A model cannot be built.
    pub(crate) fn of(
        problem: Problem<'_>,
        nominal: &Model,
        found: Search,
        known: (&[Kind], &[EffectParameters]),
        bar: &ProgressBar,
    ) -> Result<Self, BuildError> {
        bar.set_message("asking whether what is left is noise");
        let left = remainder(&problem, &found)?;
        let mut own = Self { shape: None, found, left };
        let mut noise = own.leaves_noise();
        if (!noise || own.found.noise_ratio() > CALM)
            && let Some((model, other)) = shaped(problem, nominal, &own.found, known, bar)?
        {
            own.shape = Some(model);
            own.take(&problem, other)?;
            // A shape is another law's near likeness: what it leaves may be a disturbance even if it passes for noise.
            noise = false;
        }
        let mut beside = beside_disturbance(problem, &own.found, noise)?;
        if !noise
            && let Some(other) = &beside
            && let Some(better) = without_disturbance(problem, &own.found, other)?
        {
            own.take(&problem, better)?;
            beside = beside_disturbance(problem, &own.found, own.leaves_noise())?;
        }
        if let Some(other) = beside
            && stands(problem, &own.found, &other)?
        {
            own.take(&problem, other)?;
        }
        Ok(own)
    }

    /// Whether the nominal is all there is though a score is beyond chance that no disturbance has part in.
    pub(crate) fn hides_something(&self) -> bool {
        let Search { rounds, scores, chance, after, .. } = &self.found;
        let best = scores.iter().map(|row| row.score).fold(0.0, f64::max);
        let beyond = chance.first().is_some_and(|chance| best > *chance);
        rounds.is_empty() && beyond && !after.fit.noise.is_disturbed() && self.leaves_noise()
    }

    /// Whether what is left is noise.
    fn leaves_noise(&self) -> bool {
        self.left.complaints(self.found.rounds.is_empty()).is_empty()
    }

    /// Takes what another search found.
    fn take(&mut self, problem: &Problem<'_>, found: Search) -> Result<(), BuildError> {
        self.left = remainder(problem, &found)?;
        self.found = found;
        Ok(())
    }

    /// Goes on at finer steps than `micro_steps` where that explains something by itself.
    ///
    /// # Errors
    /// A model cannot be built.
    pub(crate) fn step(
        &mut self,
        record: Record,
        micro_steps: u32,
        split: &Split,
    ) -> Result<Stepped, BuildError> {
        self.found.bar.set_message("asking whether finer steps explain what is left");
        let sound = self.left.complaints(false).is_empty() && !is_suspect(&self.found);
        let finest = record.refined(micro_steps * FINEST);
        let finer = if sound { record.refined(micro_steps * FINER) } else { finest.clone() };
        if !self.found.rounds.is_empty()
            && !interrupt::asked()
            && let Some(left) =
                ask_finer(&Problem::new(&finer, &split.fitted), &mut self.found, &self.left)?
        {
            self.left = left;
            let micro_steps = micro_steps * if sound { FINER } else { FINEST };
            return Ok(Stepped { record: finer, finest, micro_steps });
        }
        Ok(Stepped { record, finest, micro_steps })
    }

    /// Takes effects back that samples which no fit has seen do not bear out, or other records of at most so many
    /// samples; what they say of the rest.
    ///
    /// # Errors
    /// A model cannot be built, or another record is driven by another quantity.
    pub(crate) fn confirm(
        &mut self,
        (record, micro_steps): (&Record, u32),
        split: &Split,
        (others, most_samples): (&[Log], usize),
    ) -> Result<Vec<Witnessed>, DiscoverError> {
        self.found.bar.set_message("asking each effect on samples that no fit has seen");
        let problem = Problem::new(record, &split.fitted);
        let names = self.found.rounds.len();
        let like = (most_samples, micro_steps);
        let others = others.iter().map(|log| Elsewhere::new(log, record, like));
        let others: Vec<_> = others.collect::<Result<_, _>>()?;
        let noise = self.left.complaints(false).is_empty();
        let found = &mut self.found;
        let unseen = keep_confirmed(&problem, found, (&split.held_out, &others), noise)?;
        if found.rounds.len() < names {
            self.left = remainder(&problem, found)?;
        }
        Ok(unseen)
    }
}

/// A record at the steps that it is judged at.
pub(crate) struct Stepped {
    /// The record.
    pub(crate) record: Record,
    /// The same at the finest steps.
    pub(crate) finest: Record,
    /// How many micro-steps the record has.
    pub(crate) micro_steps: u32,
}

/// What a search leaves on the samples fitted to.
fn remainder(problem: &Problem<'_>, found: &Search) -> Result<Remainder, BuildError> {
    Remainder::of(problem, &found.after.fit, &found.expected, problem.mask)
}
