//! Where a model and a log disagree, how far on samples that no fit has seen, and what to measure next.

use super::experiment::Experiment;
use super::explained::Stepped;
use super::findings::Gap;
use super::gap::{believable, gap, run_everywhere};
use super::next_experiment::decisive;
use super::split::Split;
use super::whereabouts::{Disagreement, locate};
use crate::discover::candidates::cogging;
use crate::discover::checks::goodness_of_fit::Remainder;
use crate::discover::evidence::budget::FreeRun;
use crate::discover::evidence::rest::Rest;
use crate::discover::state::search::Search;
use crate::estimate::abreast::Rows;
use crate::estimate::filter::Noise;
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::scout::Scout;
use crate::model::Model;
use crate::plant::BuildError;

/// What was found along a whole record.
pub(crate) struct Located<'a> {
    stepped: &'a Stepped,
    split: &'a Split,
    found: &'a Search,
    /// The noise that the gap is counted in.
    noise: Noise,
    /// The same where it may not swallow what is missing.
    pub(crate) calm: Noise,
    /// Innovations of the refitted nominal and of the improved model.
    pub(crate) before: Rows,
    pub(crate) after: Rows,
    /// What bootstrap replicates leave on unseen samples.
    floor: Remainder,
    /// Orders of the rotor angle that were named, or that explained something.
    pub(crate) orders: Vec<f64>,
    /// Where the refitted nominal and the log disagree.
    pub(crate) disagreement: Disagreement,
    /// What to run next.
    pub(crate) experiment: Option<Experiment>,
}

impl<'a> Located<'a> {
    /// Of what was found; the experiment takes as many micro-steps as the search did.
    ///
    /// # Errors
    /// A model cannot be built.
    pub(crate) fn of(
        (stepped, split): (&'a Stepped, &'a Split),
        found: &'a Search,
        nominal: &Model,
        micro_steps: u32,
    ) -> Result<Self, BuildError> {
        let (before, after) = (&found.before.fit, &found.after.fit);
        // Where nothing was found, the gap is counted in noise that is believable, not in noise that
        // hides what is missing.
        let noise = match found.rounds.is_empty() {
            true => believable(&after.noise, &found.expected),
            false => after.noise,
        };
        let records = [&stepped.record, &stepped.finest];
        let run = |fit: &Fit| run_everywhere(records, fit, &noise);
        let (run_before, run_after) = rayon::join(|| run(before), || run(after));
        let [(record_before, rows_before), (record_after, rows_after)] = [run_before?, run_after?];
        let every = vec![1.0; stepped.record.len()];
        let everywhere = Problem::new(record_after, &every);
        let orders = orders(found);
        let first = found.rounds.first().map(|round| round.name.0);
        let along_lines = !found.orders.is_empty() || first == Some(cogging::NAME.0);
        // Noise that swallows what is missing would leave no equation to blame for it, and so would a disturbance.
        let calm = believable(&noise, &found.expected).uncoloured();
        let judged = Fit { noise, ..after.clone() };
        let floor = || Remainder::of(&everywhere, &judged, &found.expected, &split.tested);
        let place = || {
            let scout = Scout::of(record_before, &split.fitted, nominal);
            let problem = Problem::new(record_before, &split.fitted).scouted(scout.as_ref());
            locate(&problem, &found.before, &after.model, &calm, &orders, along_lines)
        };
        let next = || decisive(found, &stepped.record, micro_steps);
        let (floor, (disagreement, experiment)) = rayon::join(floor, || rayon::join(place, next));
        let (floor, disagreement, experiment) = (floor?, disagreement?, experiment?);
        let (before, after) = (rows_before, rows_after);
        Ok(Self {
            stepped,
            split,
            found,
            noise,
            calm,
            before,
            after,
            floor,
            orders,
            disagreement,
            experiment,
        })
    }

    /// How far predictions miss.
    pub(crate) fn gap(&self) -> Gap {
        self.gap_of(&self.after)
    }

    /// The gap and the free run with a map, if samples that no fit has seen are predicted the better for it.
    ///
    /// # Errors
    /// The model cannot be built.
    pub(crate) fn with_map(
        &self,
        rest: &Rest,
        gap: &Gap,
    ) -> Result<Option<(Gap, FreeRun)>, BuildError> {
        let Self { stepped: Stepped { record, finest, .. }, split, found, .. } = self;
        let (_, rows) = run_everywhere([record, finest], &rest.stage.fit, &self.noise)?;
        let with = self.gap_of(&rows);
        let nearer = with.after < gap.after;
        if !nearer {
            return Ok(None);
        }
        let models = [&found.before.fit, &rest.stage.fit];
        let free_run = FreeRun::of(record, models, &self.calm, &split.held_out)?;
        Ok(Some((with, free_run)))
    }

    fn gap_of(&self, after: &Rows) -> Gap {
        gap(&self.stepped.record, &self.before, after, &self.floor, &self.split.tested)
    }
}

/// Orders of the rotor angle: those of the lines that were added, the strongest first, then what
/// else explained something.
fn orders(found: &Search) -> Vec<f64> {
    let mut orders = cogging::orders_in(&found.after.fit.model);
    for order in &found.orders {
        if !orders.iter().any(|known| (known - order).abs() < 0.5) {
            orders.push(*order);
        }
    }
    orders
}
