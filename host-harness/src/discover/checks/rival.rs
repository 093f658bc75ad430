//! A name's rivals: what else was fitted in its place, the best first.

use joint_core::effect::EffectParameters;

use crate::discover::state::rounds::{Contender, Round};
use crate::discover::state::stage::Stage;
use crate::estimate::coordinates::Coordinate;
use crate::estimate::filter::Noise;
use crate::estimate::fit::Problem;
use crate::estimate::refit;
use crate::model::Model;
use crate::plant::BuildError;

impl Stage {
    /// The fit with another effect in the place of the model's effect number `place`: the one that its
    /// priors are centred on and the one that it begins with, of which `own` coordinates are free.
    ///
    /// # Errors
    /// The model cannot be built.
    pub(crate) fn instead(
        &self,
        problem: &Problem<'_>,
        expected: &Noise,
        place: usize,
        [centre, start]: [EffectParameters; 2],
        own: &[Coordinate],
    ) -> Result<Self, BuildError> {
        let Self { fit, origin } = self;
        let replaced = |model: &Model, effect: EffectParameters| {
            let mut model = model.clone();
            model.effects[place] = effect;
            model
        };
        let others = fit.coordinates.iter().filter(|moved| moved.effect() != Some(place));
        let moved: Vec<Coordinate> = others.chain(own).copied().collect();
        let (origin, start) = (replaced(origin, centre), replaced(&fit.model, start));
        let fit = refit::polish(problem, &origin, &start, &moved, expected, &fit.noise)?;
        Ok(Self { fit, origin })
    }
}

impl Round {
    /// Gives the name to a rival, with which the log is the likelier; the name that it had, fitted `before`, is that one's
    /// rival, and the new one stays `ahead` of it in that share of the logs drawn anew.
    pub(crate) fn renamed(&mut self, to: Contender, before: Stage, ahead: f64) {
        let Contender { name, gain } = to;
        self.rivals.retain(|known| known.name != name);
        let own = Contender { name: self.name, gain: self.gain };
        (self.name, self.gain) = (name, gain);
        self.rivalled(own, before, |_| ahead);
    }

    /// Takes in a rival unless its name is there already and explains as much; the best one's fit is kept
    /// for the next experiment, and the name stays `ahead` of it in that share of the logs drawn anew.
    pub(crate) fn rivalled(
        &mut self,
        contender: Contender,
        fitted: Stage,
        ahead: impl FnOnce(&Stage) -> f64,
    ) {
        self.rivals.retain(|known| known.name != contender.name || known.gain > contender.gain);
        if self.rivals.iter().any(|known| known.name == contender.name) {
            return;
        }
        let place = self.rivals.partition_point(|known| known.gain > contender.gain);
        self.rivals.insert(place, contender);
        if place == 0 {
            self.stays_ahead = self.stays_ahead.min(ahead(&fitted));
            self.runner_up = Some(fitted);
        }
    }
}
