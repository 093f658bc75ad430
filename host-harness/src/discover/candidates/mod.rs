//! What the host knows of each effect: one card per kind, in a file of its own.
//!
//! A card proposes hypotheses and says how large the effect is in a benchmark, in which residual it
//! shows, and which experiment tells it. Whether a hypothesis holds is decided elsewhere and the same
//! way for all. To add one: a file beside these, named as the effect's row in
//! [`joint_core::for_every_effect`].

mod card;
pub(crate) mod channels;
pub mod hidden;
pub mod hypothesis;
pub(crate) mod orders;
pub mod rules;
mod scene;

pub use card::{Axis, Bench, Benchmark, EffectCard, Residual};
pub(crate) use cogging::listed;
pub use scene::Scene;

use joint_core::effect::Kind;
use rayon::prelude::*;

use self::hypothesis::Hypothesis;

/// Declares the module of every effect, and the table of their cards.
macro_rules! cards {
    ($($module:ident :: $name:ident,)+) => {
        $(pub(crate) mod $module;)+

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

#[cfg(test)]
mod tests {
    use joint_core::effect::EffectParameters;
    use joint_core::params::Location;

    use super::*;
    use crate::demo::actuator;
    use crate::discover::proposals::score_test::ScoreTest;
    use crate::discover::trial;
    use crate::estimate::fit::Problem;
    use crate::estimate::record::Record;

    #[test]
    fn every_card_proposes_its_own_kind_and_no_other() {
        let mut nominal = actuator();
        // One law is asked where another was found.
        let found = EffectParameters::new(Kind::LoadDependentFriction, Location::Stage(1));
        nominal.effects.push(found.with("coefficient", 0.02));
        let record = Record::new(&trial::log(&nominal, trial::line(42.0), 8.0), None);
        let mask = vec![1.0; record.measured.len()];
        let problem = Problem::new(&record, &mask).rough();
        let base = trial::fitted(&problem, &nominal, &[]);
        let test = ScoreTest::new(problem, &base.origin, &base.fit, 1).unwrap();
        let scene = test.scene();
        for &kind in Kind::ALL {
            let (name, proposed) = (kind.spec().kind, (card(kind).propose)(&scene));
            assert_eq!(CARDS[kind as usize].0, kind, "{name}: its card stands in another's place");
            // As many values as knots are fitted, not searched for, and so is the shape of friction.
            let fitted = kind.has_table() || kind == Kind::FrictionShape;
            assert_eq!(proposed.is_empty(), fitted, "{name}: {proposed:?}");
            let foreign = proposed.iter().find(|hypothesis| hypothesis.start.kind != kind);
            assert!(foreign.is_none(), "{name}: its card proposes {foreign:?}");
            let free = proposed.iter().all(|hypothesis| !hypothesis.free.is_empty());
            assert!(free, "{name}: its card leaves nothing free");
        }
    }
}
