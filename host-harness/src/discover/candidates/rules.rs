//! What checks ask of one kind alone; of most there is nothing to ask.

use joint_core::effect::EffectParameters;

use super::hypothesis::Hypothesis;
use crate::estimate::record::Record;
use crate::model::Model;

/// What checks ask of a kind.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Whether no joint can have the effect with these values.
    pub impossible: fn(&EffectParameters, &Model, &Record) -> bool,
    /// How a channel that is never fitted to contradicts it, in a sentence; `None` where none does.
    pub contradiction: fn(&EffectParameters, &Model, &Record) -> Option<String>,
    /// Moves a model's parameters to what they would be without it, where it is a symmetry of the model.
    pub loss: fn(&EffectParameters, &mut Model),
    /// What shows the same in many records, to be fitted in its place; `None` where nothing does in this one.
    pub alike: fn(&EffectParameters, &Model, &Record) -> Option<Alike>,
    /// How its order is asked again, if it is a line.
    pub line: Line,
}

/// What shows the same as an effect.
#[derive(Clone, Debug)]
pub struct Alike {
    /// It, without a size, and what of it is free.
    pub hypothesis: Hypothesis,
    /// It, as large as shows what the effect does.
    pub start: EffectParameters,
    /// Whether it is a constant torque on the rotor, by the place of that among its values, and no effect of its own.
    pub constant: Option<usize>,
}

/// What is special about a kind's lines.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Whether it is a torque of the rotor: it has a double, and one of order one may be gravity's.
    pub is_rotor_torque: bool,
    /// Whether its order counts along the shaft before its place.
    pub is_of_input: bool,
    /// The only orders that it may have; any where there are none.
    pub orders: &'static [f64],
}

impl Rules {
    /// Nothing.
    pub const NONE: Self = Self {
        impossible: |_, _, _| false,
        contradiction: |_, _, _| None,
        loss: |_, _| {},
        alike: |_, _, _| None,
        line: Line::ANY,
    };
}

impl Line {
    /// One of any order.
    pub const ANY: Self = Self { is_rotor_torque: false, is_of_input: false, orders: &[] };
}
