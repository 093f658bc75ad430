//! The search: refit, look for what is missing, add the best name, and look again.
//!
//! Each round scores every hypothesis by one linear step, refits the most promising ones fully and
//! with their own noise, and keeps the best if it explains more than anything does on replicates of the
//! model, where nothing is missing. At the end every added effect has to prove that it is still
//! needed.

use std::borrow::Cow;

use indicatif::ProgressBar;
use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;
use rayon::prelude::*;

use super::annealed::add_annealed;
use super::bootstrap::stays_ahead;
use super::borne_out::{holds, owed_to_the_rest};
use super::candidates::{self, Scene};
use super::chance::{threshold, told};
use super::constant::Constant;
use super::findings::ScoreRow;
use super::fork::{Second, try_fork};
use super::gate::{PLAIN_TORQUE_EXCESS, Remainder};
use super::hope::try_hope;
use super::hypothesis::{Hypothesis, first_of_each, run_through};
use super::measured::add_measured;
use super::needless::{drop_idle, drop_needless, without};
use super::order::ask_order;
use super::protected::add_protected;
use super::score_test::{Gain, ScoreTest};
use super::settle::{fit_from_elsewhere, is_clean, may_be_stuck, settle};
use super::ways::{add_to_lost, is_futile};
use crate::estimate::coordinates::Coordinate;
use crate::estimate::filter::{Linearisation, Noise};
use crate::estimate::fit::{Fit, Known, Problem};
use crate::estimate::noise;
pub use crate::estimate::refit::LOST;
use crate::estimate::refit::{self, DOUBTED, cost};
use crate::interrupt;
use crate::model::Model;
use crate::plant::BuildError;

/// Most effects that are added.
pub const MOST_EFFECTS: usize = 4;
/// Replicates from which a round's threshold is taken.
const TWINS: u64 = 6;
/// What counts, in units of minus twice the log-likelihood: less is what a friction law slightly other
/// than ours leaves.
pub const LEAST_GAIN: f64 = 60.0;
/// A gain below which an effect has to make the samples that no fit has seen likelier as well.
pub const WEAK: f64 = 5.0 * LEAST_GAIN;
/// Times the expected noise below which nothing is left to explain.
pub const CALM: f64 = 1.5;
/// Most of the noise that a name may leave of a lost base to be followed by another.
pub(super) const HELPS: f64 = 0.8;
/// What a base must be behind a name for its last refinement to be left out.
pub(super) const FAR_BEHIND: f64 = 10.0 * WEAK;
/// What a base must owe to its challengers for the round to be worth another look.
pub const WORTH_ANOTHER: f64 = 20.0;
/// Looks at one round.
const LOOKS: usize = 3;
/// Share of the best short refit's gain from which on a name gets a full one.
const RIVALLING: f64 = 0.2;
/// Hypotheses that get a short refit, and how many of these a full one.
const SHORT: usize = 5;
const FULL: usize = 3;

/// A fitted model and the model that its priors are centred on.
#[derive(Clone, Debug)]
pub struct Stage {
    /// The fit.
    pub fit: Fit,
    /// The priors' centre: the nominal, with the effects at their starts.
    pub origin: Model,
}

impl Stage {
    /// The priors' centre and what a fit moves, with a hypothesis added.
    pub fn widened(&self, hypothesis: &Hypothesis) -> (Model, Vec<Coordinate>) {
        let mut coordinates = self.fit.coordinates.clone();
        coordinates.extend(hypothesis.coordinates(self.fit.model.effects.len()));
        (hypothesis.added(&self.origin), coordinates)
    }
}

/// A name and what its full refit explained.
#[derive(Clone, Debug)]
pub struct Contender {
    /// Kind and place.
    pub name: (Kind, Location),
    /// What it took from minus twice the log-likelihood.
    pub gain: f64,
}

/// One effect added.
#[derive(Clone, Debug)]
pub struct Round {
    /// Its name.
    pub name: (Kind, Location),
    /// What it explained.
    pub gain: f64,
    /// The others that were refitted.
    pub rivals: Vec<Contender>,
    /// The best of them, refitted.
    pub runner_up: Option<Stage>,
    /// Share of the logs drawn from this one in which it stays ahead of that one, and of nothing.
    pub stays_ahead: f64,
}

/// What the search found.
#[derive(Clone, Debug)]
pub struct Search {
    /// The refitted nominal.
    pub before: Stage,
    /// The improved model.
    pub after: Stage,
    /// The effects added, in order.
    pub rounds: Vec<Round>,
    /// Every hypothesis of every round by name.
    pub scores: Vec<ScoreRow>,
    /// Orders of the rotor angle that explain something on the refitted nominal, strongest first.
    pub orders: Vec<f64>,
    /// What a score had to exceed, by round.
    pub chance: Vec<f64>,
    /// Kinds that fit, but that a channel contradicts which is not fitted to, and how.
    pub contradictions: Vec<(Kind, String)>,
    /// Kinds that are not on the list.
    pub withdrawn: Vec<Kind>,
    /// Names that a regression is certain of: they stay as long as the log is likelier with them.
    pub(super) measured: Vec<(Kind, Location)>,
    /// Noise that the sensors and the joint's nature lead one to expect.
    pub expected: Noise,
    /// What a constant torque explains where gravity is named.
    pub constant: Option<Constant>,
    /// What the fit cost whose springs were settled last.
    pub(super) settled: Option<f64>,
    /// The best of the weak names that no unseen sample bears out.
    pub(super) hope: Option<(Contender, Stage)>,
    /// Names that unseen samples did not bear out, each with the model that had it.
    pub(super) unconfirmed: Vec<(Contender, Stage)>,
    /// The name that was beaten by a little in the first round.
    pub(super) second: Option<Second>,
    /// Where a person reads what is tried.
    pub(super) bar: ProgressBar,
}

impl Search {
    /// One that has found nothing yet.
    pub(super) fn new(before: Stage, withdrawn: &[Kind], expected: Noise) -> Self {
        Self {
            after: before.clone(),
            before,
            rounds: Vec::new(),
            scores: Vec::new(),
            orders: Vec::new(),
            chance: Vec::new(),
            contradictions: Vec::new(),
            withdrawn: withdrawn.to_vec(),
            measured: Vec::new(),
            expected,
            constant: None,
            settled: None,
            hope: None,
            unconfirmed: Vec::new(),
            second: None,
            bar: ProgressBar::hidden(),
        }
    }

    /// Where the effect of round `k` stands among those of the improved model.
    pub fn place(&self, k: usize) -> usize {
        self.before.origin.effects.len() + k
    }
}

/// Runs the search from the nominal's refit; kinds that are `withdrawn` are not on the list, and effects that
/// were `measured` are asked first.
///
/// # Errors
/// The nominal cannot be built.
pub fn search(
    problem: Problem<'_>,
    nominal: &Model,
    fit: Fit,
    (withdrawn, measured): (&[Kind], &[EffectParameters]),
    bar: &ProgressBar,
) -> Result<Search, BuildError> {
    let expected = noise::expected(nominal, problem.record);
    let before = Stage { fit, origin: nominal.clone() };
    // Contenders are told apart by tens; the model that is left in the end is polished.
    let last = problem;
    let mut search = Search::new(before, withdrawn, expected);
    search.bar = bar.clone();
    add_measured(last.rough(), &mut search, measured)?;
    look(last, &mut search)?;
    if search.rounds.is_empty() && may_be_stuck(&last, &search)? {
        look_from_elsewhere(last, &mut search)?;
    }
    if search.rounds.is_empty() && excess(&search) > LOST {
        try_hope(last, &mut search)?;
    }
    try_fork(last, &mut search)?;
    if interrupt::asked() {
        return Ok(search);
    }
    if !search.rounds.is_empty() {
        prove(last, &mut search)?;
        if search.rounds.is_empty() && !interrupt::asked() {
            // All was owed to a fit of the nominal that was stuck.
            search.before = search.after.clone();
            look_from_elsewhere(last, &mut search)?;
            prove(last, &mut search)?;
        }
    }
    Ok(search)
}

/// Lets every effect that was found prove that it is needed, now and when the springs are settled.
fn prove(last: Problem<'_>, search: &mut Search) -> Result<(), BuildError> {
    let problem = last.rough();
    search.bar.set_message("asking whether each effect is needed");
    let found = search.rounds.len();
    drop_needless(problem, search, false)?;
    if (1..found).contains(&search.rounds.len()) && excess(search) > DOUBTED {
        look(last, search)?;
        drop_needless(problem, search, false)?;
    }
    if search.rounds.is_empty() {
        return Ok(());
    }
    search.bar.set_message("fitting the springs of the gear again");
    if !is_futile(search) {
        let clean = is_clean(&last, search)?;
        settle(&last, search, clean)?;
    }
    drop_needless(last, search, true)
}

/// Looks again from a nominal fitted from elsewhere, where that one is likelier.
fn look_from_elsewhere(last: Problem<'_>, search: &mut Search) -> Result<(), BuildError> {
    search.bar.set_message("fitting the given model from other starts");
    if fit_from_elsewhere(&last, search)? > LEAST_GAIN {
        search.hope = None;
        look(last, search)?;
    }
    Ok(())
}

/// Adds effects until no more is found.
pub(super) fn look(last: Problem<'_>, search: &mut Search) -> Result<(), BuildError> {
    for round in search.rounds.len() + 1..=MOST_EFFECTS {
        search.tell(round, "scoring the known effects");
        let (before, known) = (excess(search), search.rounds.len());
        if interrupt::asked() || !add(last, search, round)? {
            break;
        }
        if known == 0 {
            search.keep_second();
        }
        for k in known..search.rounds.len() {
            ask_order(last.rough(), search, k)?;
        }
        drop_idle(last.rough(), search)?;
        let left = excess(search);
        // Names that leave a model as lost as it was explain nothing; the first may lack company.
        if search.rounds.len() > 1 && left > LOST && left > HELPS * before {
            break;
        }
    }
    Ok(())
}

/// Adds the effect that explains most of what is left, if there is one.
fn add(last: Problem<'_>, search: &mut Search, round: usize) -> Result<bool, BuildError> {
    let problem = last.rough();
    if !search.rounds.is_empty() && doubted(&last, search)? {
        settle(&last, search, false)?;
    }
    let excess = excess(search);
    Ok(excess > LOST && add_to_lost(problem, search, round)?
        || excess <= LOST && add_settled(problem, search, round)?
        // Noise that swallows what is missing hides it from the plain test as well.
        || doubted(&last, search)?
            && (add_annealed(problem, search, round)? || add_protected(problem, search, round)?))
}

/// Whether the noise that a model needs says that something is missing even if no score says what; not of
/// one with effects that leaves what such models may.
fn doubted(problem: &Problem<'_>, search: &Search) -> Result<bool, BuildError> {
    let Search { after: Stage { fit, .. }, expected, .. } = search;
    Ok((DOUBTED..=LOST).contains(&excess(search))
        && (search.rounds.is_empty()
            || !Remainder::of(problem, fit, expected, problem.mask)?.complaints(false).is_empty()))
}

/// How many times the noise that is expected the fit needs.
pub fn excess(search: &Search) -> f64 {
    search.after.fit.noise.times(&search.expected)
}

/// Whether a fit needs little more noise than is expected.
pub fn calm(noise: &Noise, expected: &Noise) -> bool {
    noise.times(expected) < CALM
}

/// Adds the best name; looks again where that only showed that the base could be fitted better.
pub fn add_settled(
    problem: Problem<'_>,
    search: &mut Search,
    round: usize,
) -> Result<bool, BuildError> {
    for _ in 0..LOOKS {
        match add_one(problem, search, round)? {
            Look::Added => return Ok(true),
            Look::Nothing => break,
            Look::BetterBase => {}
        }
    }
    Ok(false)
}

/// What one look at a round gave.
enum Look {
    /// A name.
    Added,
    /// No name.
    Nothing,
    /// No name, but a base that fits so much better that another look is worth it.
    BetterBase,
}

fn add_one(problem: Problem<'_>, search: &mut Search, round: usize) -> Result<Look, BuildError> {
    let base = search.after.clone();
    let Some(test) = ScoreTest::new(problem, &base.origin, &base.fit, TWINS) else {
        return Ok(Look::Nothing);
    };
    let scene = Scene::new(&base.fit.model, problem.record, &test);
    let hypotheses: Vec<Hypothesis> = candidates::proposed(&scene, &search.withdrawn);
    let ranked = test.ranked(&hypotheses);
    let listed = candidates::listed(&scene);
    let orders = listed.iter().map(|line| line.start.values[0]);
    let lines: Vec<(f64, Gain)> = orders.zip(test.gains(&listed)).collect();
    let own = ranked.iter().map(|(_, gain)| gain);
    let by_chance = threshold(own.chain(lines.iter().map(|(_, gain)| gain)));
    search.scores.retain(|row| row.round != round);
    if round == 1 {
        let best = ranked.first().map_or(0.0, |(_, gain)| gain.real.max(0.0));
        search.orders = told(&lines, best, by_chance);
    }
    let least =
        |search: &Search, (_, place): (Kind, Location)| by_chance.max(search.least_gain(place));
    let best_of_name = first_of_each(ranked, |(hypothesis, _)| hypothesis.name());
    let first = best_of_name.first().map(|(hypothesis, _)| hypothesis.name());
    search.chance.push(first.map_or(by_chance, |name| least(search, name)));
    let scored = best_of_name.len();
    for (hypothesis, gain) in &best_of_name {
        let name = title(hypothesis.name());
        search.scores.push(ScoreRow { round, name, score: gain.real, refitted: None });
    }

    // Noise that has swallowed what is missing hides half of it and more from a linear step.
    let share = if excess(search) > PLAIN_TORQUE_EXCESS { 0.5 } else { 1.0 };
    // Whether a stage's law explains what it must is for the full refit to say.
    let asked = |name| share * least(search, name).min(by_chance.max(LEAST_GAIN));
    let promising: Vec<(&Hypothesis, f64)> = best_of_name
        .into_iter()
        .filter(|(h, gain)| gain.real > asked(h.name()) * gain.luck())
        .map(|(hypothesis, gain)| (hypothesis, gain.real))
        .take(SHORT)
        .collect();
    search.tell_scored(round, scored, promising.len());
    let short = promising.par_iter().map(|(hypothesis, score)| {
        let (origin, coordinates) = base.widened(hypothesis);
        let start = hypothesis.added(&base.fit.model);
        let (near, noise) = (Some(test.jacobian()), &base.fit.noise);
        let known = Known { near, along: &mut Cow::Owned(Linearisation::default()) };
        let fit = problem.fit_from(known, &origin, &start, &coordinates, noise, 3)?;
        let gain = (cost(&base.fit) - cost(&fit)).max(*score);
        Ok((*hypothesis, Stage { fit, origin }, gain))
    });
    let mut short = run_through(short);
    short.sort_by(|a, b| b.2.total_cmp(&a.2));
    let strongest = short.first().map_or(0.0, |(_, _, gain)| *gain);
    let contending: Vec<_> =
        short.into_iter().filter(|(_, _, gain)| *gain > RIVALLING * strongest).take(FULL).collect();
    let expected = search.expected;
    let full = contending.into_par_iter().map(|(hypothesis, Stage { fit, origin }, _)| {
        let Fit { model, coordinates, noise, .. } = fit;
        let fit = refit::polish(&problem, &origin, &model, &coordinates, &expected, &noise)?;
        Ok((hypothesis, Stage { fit, origin }))
    });
    // The base gets the same last refinement of its noise as its challengers have.
    let refined = || {
        let noise = noise::refine(&problem, &base.fit.model, &expected, &base.fit.noise)?;
        Ok::<_, BuildError>((noise, problem.design(&base.fit.model, &noise)?.deviance))
    };
    let (mut full, refined) = rayon::join(|| run_through(full), refined);
    let (noise, deviance) = refined?;
    full.retain(|(_, stage)| search.believes(&stage.fit.model, problem.record));
    full.sort_by(|a, b| cost(&a.1.fit).total_cmp(&cost(&b.1.fit)));
    let level = (deviance + base.fit.prior).min(cost(&base.fit));
    let contenders: Vec<Contender> = full
        .iter()
        .map(|(h, stage)| Contender { name: h.name(), gain: level - cost(&stage.fit) })
        .collect();
    for contender in &contenders {
        let name = title(contender.name);
        let row = search.scores.iter_mut().find(|row| row.round == round && row.name == name);
        if let Some(row) = row {
            row.refitted = Some(contender.gain);
        }
    }
    let Some((winner, rivals)) = contenders.split_first() else { return Ok(Look::Nothing) };
    let least = least(search, winner.name);
    if winner.gain.is_nan() || winner.gain < least {
        return Ok(Look::Nothing);
    }
    let mut stages = full.into_iter().map(|(_, stage)| stage);
    let Some(won) = stages.next() else { return Ok(Look::Nothing) };
    let plain = Fit { noise, ..base.fit.clone() };
    let weak = search.weak_gain(winner.name.1);
    if winner.gain < weak && !holds(problem, &plain, &won.fit, &search.expected)? {
        search.hope(contenders[0].clone(), won);
        return Ok(Look::Nothing);
    }
    let plain = bared(&problem, &base, &won, least, &search.expected)?;
    let owed = (level - cost(&plain.fit)).max(0.0);
    let (gain, rivals) = (winner.gain, rivals.to_vec());
    let winner = gain - owed;
    if owed > 0.0 {
        if search.rounds.is_empty() {
            search.before = plain.clone();
        }
        let gains = [gain, winner, weak];
        if winner < least
            || owed_to_the_rest(problem, &plain.fit, &won.fit, gains, &search.expected)?
        {
            search.after = plain;
            return Ok(if owed < WORTH_ANOTHER { Look::Nothing } else { Look::BetterBase });
        }
    }
    let less = |rival: Contender| Contender { gain: rival.gain - owed, ..rival };
    let rivals = rivals.into_iter().map(less).collect();
    let runner_up = stages.next();
    let others: Vec<&Fit> = runner_up.iter().map(|stage| &stage.fit).chain([&plain.fit]).collect();
    let stays_ahead = stays_ahead(&won.fit, &others, problem.mask);
    let name = contenders[0].name;
    search.rounds.push(Round { name, gain: winner, rivals, runner_up, stays_ahead });
    search.after = won;
    Ok(Look::Added)
}

/// A base refitted from where a model with one more effect stands: a name may owe its gain to a better
/// fit of all the rest, and then the base is to have that fit as well. Behind gears friction has many
/// hollows, and the refit of the nominal, or a name as long as it was missing, may have led into a wrong
/// one: there the base is refitted from elsewhere too, where the name explains the `least` that it must.
pub fn bared(
    problem: &Problem<'_>,
    base: &Stage,
    won: &Stage,
    least: f64,
    expected: &Noise,
) -> Result<Stage, BuildError> {
    let start = without(&won.fit.model, base.fit.model.effects.len());
    let (moved, noise) = (&base.fit.coordinates, &won.fit.noise);
    let origin = &base.origin;
    // A name that is large is not owed to a hollow.
    let small = base.fit.noise.times(expected) <= LOST || !base.fit.model.effects.is_empty();
    let rugged = !origin.stages.is_empty();
    let far = |fit: &Fit| cost(fit) - cost(&won.fit) > FAR_BEHIND;
    let mut fit = refit::polish_unless(far, problem, origin, &start, moved, expected, noise)?;
    if rugged && small && cost(&fit) - cost(&won.fit) > least {
        let again = refit::cooled(problem, origin, &base.fit, expected)?;
        if cost(&again) < cost(&fit) {
            fit = again;
        }
    }
    Ok(Stage { fit, origin: base.origin.clone() })
}

/// A name as it is shown.
pub fn title((kind, location): (Kind, Location)) -> String {
    format!("{} ({location})", kind.spec().kind)
}
