//! The shape of friction: it is found with the nominal's refit, not searched for by name.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::card::{Axis, Benchmark, EffectCard, Residual};
use super::rules::Rules;
use crate::model::Model;

pub(super) const CARD: EffectCard = EffectCard {
    words: "friction of another shape: it creeps below breakaway, or thins with the speed",
    residual: Residual::Torque,
    axis: Axis::MotorSpeed,
    experiment: "run at many constant speeds, from creeping to the highest, in both directions",
    reference: None,
    rules: Rules::NONE,
    benchmark: Benchmark::Left("it is the friction of a joint in which nothing is missing"),
    propose: |_| Vec::new(),
};

/// The effect at a place, without a size.
pub(crate) fn at(place: Location) -> EffectParameters {
    EffectParameters::new(Kind::FrictionShape, place)
}

/// Those that a model has.
pub(crate) fn shapes_in(model: &Model) -> impl Iterator<Item = &EffectParameters> {
    model.effects.iter().filter(|effect| effect.kind == Kind::FrictionShape)
}
