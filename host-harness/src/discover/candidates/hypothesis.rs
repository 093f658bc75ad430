//! A hypothesis: an effect at a place, with a start and what of it is free.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;
use rayon::prelude::*;

use crate::estimate::coordinates::Coordinate;
use crate::model::Model;
use crate::plant::BuildError;

/// One free value of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Free {
    /// A value by its place among the effect's parameters: scale at which it matters, and one
    /// sigma of its prior in scales.
    Value {
        /// Place of the value.
        value: usize,
        /// Scale.
        scale: f64,
        /// Prior.
        sigma: f64,
    },
    /// An amplitude and the phase that follows it.
    Phasor {
        /// Place of the amplitude.
        amplitude: usize,
        /// Scale.
        scale: f64,
        /// Prior.
        sigma: f64,
    },
}

/// The trials that could be run: a name whose model cannot be built on the way has lost, and the others
/// go on.
pub fn run_through<T: Send>(trials: impl ParallelIterator<Item = Result<T, BuildError>>) -> Vec<T> {
    trials.filter_map(Result::ok).collect()
}

/// Of a ranking those that are the first of their name.
pub fn first_of_each<T>(ranked: Vec<T>, name: impl Fn(&T) -> (Kind, Location)) -> Vec<T> {
    let mut known = Vec::new();
    let mut first = ranked;
    first.retain(|entry| {
        let name = name(entry);
        let new = !known.contains(&name);
        known.push(name);
        new
    });
    first
}

/// An effect that may be what is missing.
#[derive(Clone, Debug, PartialEq)]
pub struct Hypothesis {
    /// The effect at the values where its test starts; zero size for an effect that the model is
    /// differentiable in there.
    pub start: EffectParameters,
    /// What of it is free.
    pub free: Vec<Free>,
}

impl Hypothesis {
    /// What it would be called.
    pub fn name(&self) -> (Kind, Location) {
        (self.start.kind, self.start.location)
    }

    /// Whether the effect at its start changes nothing.
    pub fn starts_at_nothing(&self) -> bool {
        self.free.iter().all(|free| match *free {
            Free::Value { value, .. } => self.start.values[value] == 0.0,
            Free::Phasor { amplitude, .. } => self.start.values[amplitude] == 0.0,
        })
    }

    /// A model with the effect added at its start.
    pub fn added(&self, model: &Model) -> Model {
        let mut model = model.clone();
        model.effects.push(self.start);
        model
    }

    /// Coordinates of the effect as the model's effect number `effect`.
    pub fn coordinates(&self, effect: usize) -> Vec<Coordinate> {
        let mut all = Vec::new();
        for free in &self.free {
            match *free {
                Free::Value { value, scale, sigma } => {
                    all.push(Coordinate::Effect { effect, value, scale, sigma });
                }
                Free::Phasor { amplitude, scale, sigma } => {
                    for sine in [false, true] {
                        all.push(Coordinate::Phasor { effect, amplitude, sine, scale, sigma });
                    }
                }
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_that_cannot_be_built_has_lost() {
        let trials = [Ok(1), Err(BuildError::TooManyStages(9)), Ok(3)];
        assert_eq!(run_through(trials.into_par_iter()), [1, 3]);
    }

    #[test]
    fn of_each_name_the_first_is_kept() {
        let (motor, stage) = (Location::Motor, Location::Stage(1));
        let ranked = vec![(Kind::Cogging, motor, 1), (Kind::Backlash, stage, 2)];
        let again = vec![(Kind::Cogging, motor, 3), (Kind::Backlash, Location::Stage(2), 4)];
        let first = first_of_each([ranked, again].concat(), |(kind, place, _)| (*kind, *place));
        assert_eq!(first.iter().map(|(.., k)| *k).collect::<Vec<_>>(), [1, 2, 4]);
    }
}
