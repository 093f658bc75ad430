//! A fitted model with what its priors are centred on.

use crate::discover::candidates::hypothesis::Hypothesis;
use crate::estimate::coordinates::Coordinate;
use crate::estimate::fit::Fit;
use crate::model::Model;

/// A fitted model and the model that its priors are centred on.
#[derive(Clone, Debug)]
pub(crate) struct Stage {
    /// The fit.
    pub(crate) fit: Fit,
    /// The priors' centre: the nominal, with the effects at their starts.
    pub(crate) origin: Model,
}

impl Stage {
    /// The priors' centre and what a fit moves, with a hypothesis added.
    pub(crate) fn widened(&self, hypothesis: &Hypothesis) -> (Model, Vec<Coordinate>) {
        let mut coordinates = self.fit.coordinates.clone();
        coordinates.extend(hypothesis.coordinates(self.fit.model.effects.len()));
        (hypothesis.added(&self.origin), coordinates)
    }
}
