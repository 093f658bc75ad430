//! Finding an effect so large that the nominal cannot be refitted around it: beside a disturbance state.
//!
//! Where what is missing is many times the noise, a refit of the plain model biases every parameter
//! to explain it, and no linear step from there can be believed. So the equation that disagrees
//! most is given a random-walk disturbance along with the refit: it takes what the equation
//! misses, and the parameters stay where they belong. Hypotheses are scored and first fitted beside
//! the disturbance, and only then have to do without it.

use joint_core::effect::Kind;
use rayon::prelude::*;

use super::chance::threshold;
use super::disturbance_regression::{Regressed, regressed};
use super::line_spectrum::lines;
use super::proposed::{Proposed, Tried};
use super::refits::{Refitted, ahead, gained, short, written_refits};
use super::score_test::ScoreTest;
use crate::discover::bounds::{FAR_BEHIND, LEAST_GAIN, MOST_EFFECTS, RIVALLING};
use crate::discover::candidates;
use crate::discover::candidates::cogging;
use crate::discover::candidates::hypothesis::{Hypothesis, first_of_each, run_through};
use crate::discover::checks::bootstrap::stays_ahead;
use crate::discover::checks::noise_ratio::is_as_expected;
use crate::discover::evidence::disturbance::disagreeing;
use crate::discover::state::rounds::{Contender, Name, Round};
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::filter::{Noise, Walk};
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::refit::{self, cost};
use crate::plant::BuildError;

/// How much more process noise than expected the model has beside the disturbance.
const INFLATION: f64 = 2.0;
/// Replicates that tell what a score reaches by chance.
const REPLICATES: u64 = 3;
/// Hypotheses that are fitted beside the disturbance, and rounds of that fit.
const FITTED: usize = 5;
const ROUNDS: usize = 5;
/// Names that a regression of the disturbance tells which are fitted as large as it says.
const REGRESSED: usize = 3;
/// Names that are refitted until they gain nothing more, where none leaves only noise.
const CONVERGED: usize = 3;

/// What the names are asked beside.
struct Beside<'a> {
    base: &'a Stage,
    /// The likeliest disturbances, one for each equation, and the base refitted beside each.
    disturbances: &'a [(Walk, Fit)],
    /// Noise that the log is expected to have, and the noise beside a disturbance.
    expected: Noise,
    wary: Noise,
}

/// The names that explain most beside a disturbance state, refitted without it; or the lines that the disturbance
/// shows, where together they explain more. `known` is what the best fit costs that was found in another way.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn beside_disturbance_state(
    problem: Problem<'_>,
    search: &mut Search,
    round: usize,
    known: Option<f64>,
) -> Result<Option<Proposed>, BuildError> {
    search.tell(round, "fitting the known effects beside a disturbance state");
    let base = search.after.clone();
    let expected = search.expected;
    let wary = Noise { sensors: base.fit.noise.sensors, ..expected.distrusted(INFLATION) };
    let disturbances = disagreeing(&problem.ahead(), &base, &wary, true)?;
    let beside = Beside { base: &base, disturbances: &disturbances, expected, wary };
    let Some(fitted) = beside.fitted(&problem, &search.withdrawn)? else { return Ok(None) };
    let alone = alone(&problem, fitted, &expected, &wary);
    let mut tried = written_refits(&problem, search, round, &base, alone);
    tried.sort_by(|a, b| promise(b, &expected).total_cmp(&promise(a, &expected)));
    let tried = converged(&problem, &base, tried, (&expected, known))?;
    let explained =
        tried.first().is_some_and(|(_, stage)| is_as_expected(&stage.fit.noise, &expected));
    if !explained
        && !search.withdrawn.contains(&cogging::NAME.0)
        && let Some(lines) = beside.lines(&problem, search, &tried)?
    {
        return Ok(Some(lines));
    }
    Ok(Some(Proposed::Effects(Box::new(Tried::beside(base, tried)))))
}

/// Names refitted without the disturbance; of a long record those that are likeliest on a part of it.
fn alone(
    problem: &Problem<'_>,
    fitted: Vec<Refitted>,
    expected: &Noise,
    wary: &Noise,
) -> Vec<Refitted> {
    let near =
        |(name, score, stage): Refitted| Ok((name, score, ahead(problem, stage, expected, wary)?));
    let mut near = run_through(fitted.into_par_iter().map(near));
    if problem.scout.is_none() {
        return near;
    }
    near.sort_by(|a, b| cost(&a.2.fit).total_cmp(&cost(&b.2.fit)));
    near.truncate(CONVERGED);
    let whole = |(name, score, Stage { fit, origin }): Refitted| {
        let fit = refit::finish(problem, &origin, fit, expected)?;
        Ok((name, score, Stage { fit, origin }))
    };
    run_through(near.into_par_iter().map(whole))
}

impl Beside<'_> {
    /// The most promising names beside the likeliest disturbance, and those that a regression of it tells; `None`
    /// where none can be asked.
    fn fitted(
        &self,
        problem: &Problem<'_>,
        withdrawn: &[Kind],
    ) -> Result<Option<Vec<Refitted>>, BuildError> {
        let Some((walk, protected)) = self.disturbances.first() else { return Ok(None) };
        let part = problem.ahead();
        let beside = part.pushed(*walk);
        let Some(test) = ScoreTest::new(beside, &self.base.origin, protected, REPLICATES) else {
            return Ok(None);
        };
        let hypotheses = candidates::proposed(&test.scene(), withdrawn);
        let mut fitted = self.scored(&beside, &test, protected, &hypotheses);
        let told = regressed(&part, self.disturbances, &self.wary, &hypotheses)?;
        for Regressed { hypothesis, start, beside, .. } in told.into_iter().take(REGRESSED) {
            let name = hypothesis.name();
            if fitted.iter().any(|(known, ..)| *known == name) {
                continue;
            }
            let (origin, coordinates) = self.base.widened(hypothesis);
            let fit = Fit { model: start, coordinates, ..beside.clone() };
            fitted.push((name, 0.0, Stage { fit, origin }));
        }
        Ok(Some(fitted))
    }

    /// The names that score beyond chance, fitted beside the disturbance; those far behind the best are left out.
    fn scored(
        &self,
        beside: &Problem<'_>,
        test: &ScoreTest<'_>,
        protected: &Fit,
        hypotheses: &[Hypothesis],
    ) -> Vec<Refitted> {
        let mut ranked = test.ranked(hypotheses);
        let least = threshold(ranked.iter().map(|(_, gain)| gain)).max(LEAST_GAIN);
        ranked.retain(|(_, gain)| gain.real > least);
        let mut promising = first_of_each(ranked, |(hypothesis, _)| hypothesis.name());
        promising.truncate(FITTED);
        let fitted = promising.into_par_iter().map(|(hypothesis, score)| {
            let (start, near) = (hypothesis.added(&protected.model), Some(test.jacobian()));
            let own = (self.base, hypothesis);
            let stage = short(beside, own, (&start, near), &self.wary, ROUNDS)?;
            let gain = cost(protected) - cost(&stage.fit);
            Ok((gain, (hypothesis.name(), score.real, stage)))
        });
        let mut fitted = run_through(fitted);
        let strongest = fitted.iter().map(|(gain, _)| *gain).fold(0.0, f64::max);
        fitted.retain(|(gain, _)| *gain >= RIVALLING * strongest);
        fitted.into_iter().map(|(_, fitted)| fitted).collect()
    }

    /// The lines of the likeliest disturbance of the joint, where they gain more than the best of the names that were
    /// `tried`, each by what counts.
    fn lines(
        &self,
        problem: &Problem<'_>,
        search: &Search,
        tried: &[(Contender, Stage)],
    ) -> Result<Option<Proposed>, BuildError> {
        let base = self.base;
        let alone = tried.first().map_or(0.0, |(winner, _)| winner.gain.max(0.0));
        let of_the_joint =
            self.disturbances.iter().find(|(walk, _)| !walk.equation.is_of_a_sensor());
        let Some((walk, beside)) = of_the_joint.or(self.disturbances.first()) else {
            return Ok(None);
        };
        let most = MOST_EFFECTS - search.rounds.len();
        let noises = [&self.expected, &self.wary];
        let found = lines(problem, base, (*walk, beside), noises, most, &search.withdrawn)?;
        let Some(stage) = found else { return Ok(None) };
        let added = &stage.origin.effects[base.origin.effects.len()..];
        let gain = cost(&base.fit) - cost(&stage.fit);
        let enough = gain > alone + LEAST_GAIN * added.len() as f64;
        if !enough {
            return Ok(None);
        }
        let names: Vec<_> = added.iter().map(|line| (line.kind, line.location)).collect();
        let rivals = tried.iter().map(|(contender, _)| contender.clone());
        let rivals: Vec<_> = rivals.filter(|rival| !names.contains(&rival.name)).collect();
        let stays_ahead = stays_ahead(&stage.fit, &[&base.fit], problem.mask);
        let gain = gain / names.len() as f64;
        let round = |name: &Name| Round {
            name: *name,
            gain,
            rivals: rivals.clone(),
            runner_up: None,
            stays_ahead,
        };
        let rounds = names.iter().map(round).collect();
        Ok(Some(Proposed::Lines(rounds, Box::new(stage))))
    }
}

/// What a name promises: what it has gained, or where it is still far from a fit how little noise it
/// asks for.
fn promise((contender, stage): &(Contender, Stage), expected: &Noise) -> f64 {
    let gain = contender.gain;
    if gain.is_finite() && gain > 0.0 { gain } else { -stage.fit.noise.times(expected) }
}

/// The names refitted until they gain nothing more, the best first: beside a disturbance a name may have
/// looked better than it holds without. One that leaves nothing to explain ends this; one that polishing leaves far
/// behind what is `known` is not refitted from other springs.
fn converged(
    problem: &Problem<'_>,
    base: &Stage,
    tried: Vec<(Contender, Stage)>,
    (expected, known): (&Noise, Option<f64>),
) -> Result<Vec<(Contender, Stage)>, BuildError> {
    let far_behind = |fit: &Fit| known.is_some_and(|known| cost(fit) - known > FAR_BEHIND);
    let mut done: Vec<(Contender, Stage)> = Vec::new();
    let mut explained = false;
    for (contender, Stage { fit, origin }) in tried {
        if explained || done.len() == CONVERGED {
            done.push((contender, Stage { fit, origin }));
            continue;
        }
        let fit = refit::converge_unless(far_behind, problem, &origin, fit, expected)?;
        explained = is_as_expected(&fit.noise, expected);
        let gain = gained(&base.fit, &fit);
        done.push((Contender { gain, ..contender }, Stage { fit, origin }));
    }
    done.sort_by(|a, b| promise(b, expected).total_cmp(&promise(a, expected)));
    Ok(done)
}
