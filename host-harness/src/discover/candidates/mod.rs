//! What the host knows of each effect: one card per kind, in a file of its own.
//!
//! A card proposes hypotheses and says how large the effect is in a benchmark, in which residual it
//! shows, and which experiment tells it. Whether a hypothesis holds is decided elsewhere and the same
//! way for all. To add one: a file beside these, named as the effect's row in
//! [`joint_core::for_every_effect`].

mod card;
mod scene;

pub use card::{Axis, Bench, Benchmark, EffectCard, Residual};
pub(super) use cogging::listed;
pub use scene::Scene;

use joint_core::effect::Kind;
use rayon::prelude::*;

use super::hypothesis::Hypothesis;

/// Declares the module of every effect, and the table of their cards.
macro_rules! cards {
    ($($module:ident :: $name:ident,)+) => {
        $(pub(super) mod $module;)+

        /// Every card, in the order of [`Kind::ALL`].
        static CARDS: &[(Kind, EffectCard)] = &[$((Kind::$name, $module::CARD),)+];
    };
}

joint_core::for_every_effect!(cards);

/// The card of a kind.
pub fn card(kind: Kind) -> &'static EffectCard {
    &CARDS[kind as usize].1
}

/// What all candidates propose, but for kinds that are withdrawn.
pub fn proposed(scene: &Scene<'_>, withdrawn: &[Kind]) -> Vec<Hypothesis> {
    let all = CARDS.par_iter().flat_map_iter(|(_, card)| (card.propose)(scene));
    all.filter(|hypothesis| !withdrawn.contains(&hypothesis.start.kind)).collect()
}
