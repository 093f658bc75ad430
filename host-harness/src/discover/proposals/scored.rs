//! All hypotheses scored on one base.

use joint_core::effect::Kind;

use super::chance::{threshold, told};
use super::score_test::{Gain, ScoreTest};
use crate::discover::candidates::hypothesis::{Hypothesis, first_of_each};
use crate::discover::candidates::{listed, proposed};
use crate::discover::state::rounds::{ScoreRow, title};
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::fit::Problem;

/// What every hypothesis would gain by one linear step.
pub(crate) struct Scored<'a> {
    /// The test that said so.
    pub(crate) test: ScoreTest<'a>,
    /// The best hypothesis of every name and its score, the best first.
    pub(crate) best: Vec<(Hypothesis, Gain)>,
    /// What a score reaches by chance.
    pub(crate) by_chance: f64,
    /// How many hypotheses and lines were tried.
    pub(crate) tried: usize,
    /// Orders of the rotor angle that are worth telling, strongest first.
    orders: Vec<f64>,
}

impl<'a> Scored<'a> {
    /// On a base, with that many replicates; `None` if its curvature is not positive.
    pub(crate) fn on(
        problem: Problem<'a>,
        base: &'a Stage,
        withdrawn: &[Kind],
        replicates: u64,
    ) -> Option<Self> {
        let test = ScoreTest::new(problem, &base.origin, &base.fit, replicates)?;
        let scene = test.scene();
        let (hypotheses, listed) = (proposed(&scene, withdrawn), listed(&scene));
        let ranked = test.ranked(&hypotheses);
        let orders = listed.iter().map(|line| line.start.values[0]);
        let lines: Vec<(f64, Gain)> = orders.zip(test.gains(&listed)).collect();
        let gains = ranked.iter().map(|(_, gain)| gain).chain(lines.iter().map(|(_, gain)| gain));
        let by_chance = threshold(gains);
        let strongest = ranked.first().map_or(0.0, |(_, gain)| gain.real.max(0.0));
        let (orders, tried) = (told(&lines, strongest, by_chance), ranked.len() + lines.len());
        let best = first_of_each(ranked, |(hypothesis, _)| hypothesis.name());
        let best = best.into_iter().map(|(hypothesis, gain)| (hypothesis.clone(), gain)).collect();
        Some(Self { test, best, by_chance, tried, orders })
    }

    /// Writes down in a search what a round scored.
    pub(crate) fn write(&self, search: &mut Search, round: usize) {
        if round == 1 {
            search.orders.clone_from(&self.orders);
        }
        for (hypothesis, gain) in &self.best {
            let name = title(hypothesis.name());
            search.scores.push(ScoreRow { round, name, score: gain.real, refitted: None });
        }
    }
}
