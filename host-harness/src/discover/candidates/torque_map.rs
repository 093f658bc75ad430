//! Torque map: what repeats along an angle or a speed and has no name. It is no hypothesis of the search,
//! which would find it wherever it looks; a map is fitted to a disturbance when every name has been asked.

use super::card::{Axis, Benchmark, EffectCard, Residual};
use super::rules::Rules;

pub(super) const CARD: EffectCard = EffectCard {
    words: "a torque without a name, told as a table",
    residual: Residual::Torque,
    axis: Axis::MotorAngle,
    experiment: "repeat the motion at half the speed and with another load: what stays where it was follows \
         the angle, what moves or grows has a cause that the table does not say",
    reference: None,
    rules: Rules::NONE,
    benchmark: Benchmark::Left(
        "a table has no name that could be right, and stands in for any that is",
    ),
    propose: |_| Vec::new(),
};
