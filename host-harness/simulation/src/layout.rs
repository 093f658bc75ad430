//! A joint's state as a plain vector.

use joint_core::effect::Kind;

use crate::model::Model;

/// Most stages a model has.
pub const MAX_STAGES: usize = 6;

/// Whether a joint that is stepped along a record has a memory for effects of this kind: what the input
/// was before, the record says.
pub fn remembers(kind: Kind) -> bool {
    kind.remembers() && kind != Kind::InputDelay
}

/// Where each quantity stands in a plant's state vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Number of stages.
    pub stages: usize,
    /// Number of effects that remember something.
    pub memories: usize,
}

impl Layout {
    /// Of a model.
    pub fn of(model: &Model) -> Self {
        let remembering = model.effects.iter().filter(|effect| remembers(effect.kind));
        Self { stages: model.stages.len(), memories: remembering.count() }
    }

    /// Current, A.
    pub const CURRENT: usize = 0;
    /// Rotor angle, rad.
    pub const ANGLE: usize = 1;

    /// Length of the vector.
    pub const fn len(self) -> usize {
        4 + 3 * self.stages + self.memories
    }

    /// Always false: there is a rotor.
    pub const fn is_empty(self) -> bool {
        false
    }

    /// Deflection of a stage's spring, stages from 0.
    pub const fn deflection(self, stage: usize) -> usize {
        2 + stage
    }

    /// Speed of a mass, 0 at the rotor.
    pub const fn speed(self, mass: usize) -> usize {
        2 + self.stages + mass
    }

    /// Bristle of a mass.
    pub const fn bristle(self, mass: usize) -> usize {
        3 + 2 * self.stages + mass
    }

    /// What an effect remembers, in the order of the model's effects that do.
    pub const fn memory(self, slot: usize) -> usize {
        4 + 3 * self.stages + slot
    }
}
