//! Friction's course along the travel. With up to 32 free values it is no hypothesis for a linear step: the
//! lines of position-dependent friction are asked in its place, and a course is put into a model by hand.

use super::card::{Axis, Benchmark, EffectCard, Residual};
use super::rules::Rules;

pub(super) const CARD: EffectCard = EffectCard {
    words: "friction with a course of its own along the travel, in each direction",
    residual: Residual::Torque,
    axis: Axis::OutputAngle,
    experiment: "pass the whole travel slowly at constant speed, several times in each direction: the current \
         of each direction is its course, and what both share half the weight's",
    reference: None,
    rules: Rules::NONE,
    benchmark: Benchmark::Left(
        "its knots are as many as the travel has places; no size is typical of it",
    ),
    propose: |_| Vec::new(),
};
