//! What a proposal hands back.

use super::refits::cost_of_base;
use crate::discover::state::rounds::{Contender, Round};
use crate::discover::state::stage::Stage;
use crate::estimate::fit::Fit;

/// What a proposal found.
pub(crate) enum Proposed {
    /// Effects, of which one may be added.
    Effects(Box<Tried>),
    /// Lines that hold together or not at all, and the model with them.
    Lines(Vec<Round>, Box<Stage>),
}

/// Effects that were refitted in full, each on top of the same base.
pub(crate) struct Tried {
    /// The base.
    pub(crate) base: Stage,
    /// What it costs where its noise is refined as that of its challengers is.
    pub(crate) cost: f64,
    /// The base at that noise.
    pub(crate) refined: Fit,
    /// What a score reaches by chance.
    pub(crate) by_chance: f64,
    /// What each gained, and the model with it, the best first.
    pub(crate) contenders: Vec<(Contender, Stage)>,
}

impl Tried {
    /// Effects whose base stands as it is, at a noise that is not refined, and whose scores chance does not tell.
    pub(crate) fn beside(base: Stage, contenders: Vec<(Contender, Stage)>) -> Self {
        let (cost, refined) = (cost_of_base(&base.fit), base.fit.clone());
        Self { base, cost, refined, by_chance: 0.0, contenders }
    }
}
