//! What moves in a joint, and what acts on it.
//!
//! Masses count from 0 at the rotor. Everything is per-unit and reflected to the motor.

use crate::angle::{Angle, Turns};

/// Most effects of one joint that remember something.
pub const MEMORIES: usize = 4;

/// What effects remember: temperatures over their reference, bent shares of a hysteresis.
pub type Memory<S> = [S; MEMORIES];

/// The bristle of one mass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Bristle<S> {
    /// ζ = σ0 z / α0: bristle torque over Coulomb level.
    pub zeta: S,
    /// 1 − ∂ż/∂v = sgn(v) ζ (ρ + v ρ') at the end of the last flow: what a faster motion slips, beside
    /// what it bends.
    pub(crate) slipping: S,
    /// What the rotor's ζ has lost by rounding.
    pub(crate) lost: S,
}

/// One mass: its speed and bristle, and the force and damping it was last found under.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Mass<S> {
    /// Speed, reflected to the motor.
    pub speed: S,
    /// Friction state.
    pub bristle: Bristle<S>,
    pub(crate) force: S,
    pub(crate) damping: S,
}

/// One stage: the spring's deflection and the mass behind it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StageState<S> {
    /// Deflection of the spring, reflected to the motor.
    pub deflection: S,
    /// The mass behind it.
    pub mass: Mass<S>,
    /// What rounding has taken of the deflection; see
    /// [`Deflection::drifted`](crate::gear::Deflection::drifted).
    pub(crate) lost: S,
}

/// All that moves in a joint of `N` stages.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S::Whole: serde::Serialize",
        deserialize = "S::Whole: serde::Deserialize<'de>"
    ))
)]
pub struct State<S: Turns, const N: usize> {
    /// Current in the two conducting phases.
    pub current: S,
    /// Rotor angle.
    pub angle: Angle<S>,
    /// The rotor.
    pub rotor: Mass<S>,
    /// The stages, from the motor on.
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    pub stages: [StageState<S>; N],
    /// What effects remember.
    pub memory: Memory<S>,
}

/// What acts on a joint for one step, per-unit: made by
/// [`Joint::input`](crate::joint::Joint::input).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Input<S> {
    pub(crate) drive: S,
    pub(crate) load: S,
}

/// One of something for every mass.
pub(crate) struct Each<T, const N: usize> {
    pub(crate) rotor: T,
    pub(crate) masses: [T; N],
}

impl<S: Turns, const N: usize> Each<S, N> {
    #[inline(always)]
    pub(crate) fn of(state: &State<S, N>, of: impl Fn(&Mass<S>) -> S) -> Self {
        let mut masses = [S::ZERO; N];
        for (value, stage) in masses.iter_mut().zip(&state.stages) {
            *value = of(&stage.mass);
        }
        Self { rotor: of(&state.rotor), masses }
    }
}

impl<S: Turns, const N: usize> State<S, N> {
    /// The mass of this number; `None` for one that is not there.
    pub(crate) fn mass(&self, mass: usize) -> Option<&Mass<S>> {
        match mass.checked_sub(1) {
            None => Some(&self.rotor),
            Some(k) => self.stages.get(k).map(|stage| &stage.mass),
        }
    }

    /// The same to change it.
    pub(crate) fn mass_mut(&mut self, mass: usize) -> Option<&mut Mass<S>> {
        match mass.checked_sub(1) {
            None => Some(&mut self.rotor),
            Some(k) => self.stages.get_mut(k).map(|stage| &mut stage.mass),
        }
    }

    /// The mass that carries the load.
    #[inline(always)]
    pub(crate) fn last(&mut self) -> &mut Mass<S> {
        match self.stages.last_mut() {
            Some(stage) => &mut stage.mass,
            None => &mut self.rotor,
        }
    }
}
