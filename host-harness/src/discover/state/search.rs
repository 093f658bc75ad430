//! The state of a search.

use indicatif::ProgressBar;
use joint_core::effect::Kind;

use super::constant::Constant;
use super::rounds::{Contender, Name, Round, ScoreRow, title};
use super::stage::Stage;
use crate::discover::evidence::slope::Slope;
use crate::estimate::filter::Noise;
use crate::estimate::refit::cost;

/// What a search found.
#[derive(Clone, Debug)]
pub(crate) struct Search {
    /// The refitted nominal.
    pub(crate) before: Stage,
    /// The improved model.
    pub(crate) after: Stage,
    /// The effects added, in order.
    pub(crate) rounds: Vec<Round>,
    /// Every hypothesis of every round by name.
    pub(crate) scores: Vec<ScoreRow>,
    /// Orders of the rotor angle that explain something on the refitted nominal, strongest first.
    pub(crate) orders: Vec<f64>,
    /// What a score had to exceed, by round.
    pub(crate) chance: Vec<f64>,
    /// Kinds that fit, but that a channel contradicts which is not fitted to, and how.
    pub(crate) contradictions: Vec<(Kind, String)>,
    /// Kinds that are not on the list.
    pub(crate) withdrawn: Vec<Kind>,
    /// Names that a regression is certain of: they stay as long as the log is likelier with them.
    pub(crate) measured: Vec<Name>,
    /// Noise that the sensors and the joint's nature lead one to expect.
    pub(crate) expected: Noise,
    /// What a constant torque explains where gravity is named.
    pub(crate) constant: Option<Constant>,
    /// What the fit cost that was refitted from several starts last.
    pub(crate) settled: Option<f64>,
    /// The best of the weak names that no unseen sample confirms: a deferred hypothesis.
    pub(crate) deferred: Option<(Contender, Stage)>,
    /// Names that unseen samples did not confirm.
    pub(crate) unconfirmed: Vec<Unconfirmed>,
    /// The name that was beaten by a little in the first round.
    pub(crate) close_second: Option<CloseSecond>,
    /// Where a person reads what is tried.
    pub(crate) bar: ProgressBar,
}

/// A name that unseen samples did not confirm.
#[derive(Clone, Debug)]
pub(crate) struct Unconfirmed {
    /// The name.
    pub(crate) contender: Contender,
    /// The model that had it.
    pub(crate) stage: Stage,
    /// How much of it the logs' own unseen samples bear out.
    pub(crate) slope: Slope,
    /// The t of what it gains there.
    pub(crate) unseen_t: f64,
    /// That of the other records; `None` where there are none.
    pub(crate) transfer_t: Option<f64>,
}

/// A name that was beaten by a little, and the model with it.
#[derive(Clone, Debug)]
pub(crate) struct CloseSecond {
    /// The name.
    pub(crate) contender: Contender,
    /// The one that beat it.
    pub(crate) first: Contender,
    /// The model with it.
    pub(crate) stage: Stage,
}

impl Search {
    /// How many hypotheses were tried at once, at most.
    pub(crate) fn tried(&self) -> usize {
        let of = |round: usize| self.scores.iter().filter(|row| row.round == round).count();
        self.scores.iter().map(|row| of(row.round)).max().unwrap_or(0)
    }

    /// One that has found nothing yet.
    pub(crate) fn new(before: Stage, withdrawn: &[Kind], expected: Noise) -> Self {
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
            deferred: None,
            unconfirmed: Vec::new(),
            close_second: None,
            bar: ProgressBar::hidden(),
        }
    }

    /// Where the effect of round `k` stands among those of the improved model.
    pub(crate) fn place(&self, k: usize) -> usize {
        self.before.origin.effects.len() + k
    }

    /// How many times the noise that is expected the fit needs.
    pub(crate) fn noise_ratio(&self) -> f64 {
        self.after.fit.noise.times(&self.expected)
    }

    /// Keeps what speaks against a kind, once.
    pub(crate) fn contradicted(&mut self, against: (Kind, String)) {
        if !self.contradictions.iter().any(|(kind, _)| *kind == against.0) {
            self.contradictions.push(against);
        }
    }

    /// Keeps a weak name that the unseen samples do not confirm, if it is the best of its like.
    pub(crate) fn defer(&mut self, contender: Contender, stage: Stage) {
        let best = |(_, best): &(Contender, Stage)| cost(&stage.fit) < cost(&best.fit);
        if self.deferred.as_ref().is_none_or(best) && self.rounds.is_empty() {
            self.deferred = Some((contender, stage));
        }
    }

    /// Writes down what the full refits of a round gained.
    pub(crate) fn write_refits<'c>(
        &mut self,
        round: usize,
        contenders: impl Iterator<Item = &'c Contender>,
    ) {
        for contender in contenders {
            let name = title(contender.name);
            let row = self.scores.iter_mut().find(|row| row.round == round && row.name == name);
            if let Some(row) = row {
                row.refitted = Some(contender.gain);
            }
        }
    }
}
