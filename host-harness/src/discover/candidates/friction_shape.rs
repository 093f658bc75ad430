//! The shape of friction: it is found with the nominal's refit, not searched for by name.

use super::card::{Axis, Benchmark, EffectCard, Residual};

pub(super) const CARD: EffectCard = EffectCard {
    words: "friction of another shape: it creeps below breakaway, or thins with the speed",
    residual: Residual::Torque,
    axis: Axis::MotorSpeed,
    experiment: "run at many constant speeds, from creeping to the highest, in both directions",
    reference: None,
    benchmark: Benchmark::Left("it is the friction of a joint in which nothing is missing"),
    propose: |_| Vec::new(),
};
