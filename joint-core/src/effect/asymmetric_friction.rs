//! Friction that differs by direction, as worn screws and preloaded bearings have it.
//!
//! The LuGre level becomes `g(v) (1 + a sgn v)` and the viscous coefficient `σ2 (1 + b sgn v)`.
//! Source: the practice of axis identification, for example Janot, Gautier and Brunot, "Data set and
//! reference models of EMPS" (2019), where both parts differ.

use super::hooks::{Effects, Memory, Rubbing};
use super::{ParameterSpec, Place, Spec};
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "asymmetric-friction",
    locations: &[Location::Motor, Location::Stage(0)],
    parameters: &[
        // Relative: the level is this much higher in positive direction.
        ParameterSpec { key: "asymmetry", default: Some(0.0), low: -0.95, high: 0.95 },
        // Relative: the viscous coefficient is this much higher in positive direction.
        ParameterSpec { key: "viscous_asymmetry", default: Some(0.0), low: -0.95, high: 0.95 },
    ],
    example: (Location::Motor, &[("asymmetry", 0.25), ("viscous_asymmetry", 0.3)]),
    table: None,
    remembers: false,
};

/// The law for one mass.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct AsymmetricFriction<S: Scalar> {
    mass: u8,
    inverse_level: [S; 2],
    viscous: [S; 2],
}

batch!(AsymmetricFriction<Scalar>: inverse_level, viscous; mass);

impl<S: Scalar> AsymmetricFriction<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.mass, place.values, place.shaft < 0.0))
    }

    /// From the values of [`SPEC`]; `reversed` where the mass turns against the motor.
    pub fn new(mass: u8, values: &[f64], reversed: bool) -> Self {
        let sign = if reversed { -1.0 } else { 1.0 };
        let value = |k: usize| sign * values.get(k).copied().unwrap_or(0.0);
        let (level, viscous) = (value(0), value(1));
        Self {
            mass,
            inverse_level: [S::from_f64(1.0 / (1.0 + level)), S::from_f64(1.0 / (1.0 - level))],
            viscous: [S::from_f64(1.0 + viscous), S::from_f64(1.0 - viscous)],
        }
    }
}

impl<S: Scalar> Effects<S> for AsymmetricFriction<S> {
    fn has_damping(&self, mass: usize) -> bool {
        mass == usize::from(self.mass)
    }

    fn has_levels(&self) -> bool {
        true
    }

    fn has_level(&self, mass: usize) -> bool {
        mass == usize::from(self.mass)
    }

    #[inline(always)]
    fn inverse_level(&self, mass: usize, at: Rubbing<S>) -> S {
        let [forward, backward] = self.inverse_level;
        if mass != usize::from(self.mass) {
            return S::ONE;
        }
        S::choose(at.speed.below(S::ZERO), backward, forward)
    }

    #[inline(always)]
    fn viscous(&self, mass: usize, speed: S, _memory: &Memory<S>) -> S {
        let [forward, backward] = self.viscous;
        if mass != usize::from(self.mass) {
            return S::ONE;
        }
        S::choose(speed.below(S::ZERO), backward, forward)
    }
}

#[cfg(test)]
mod tests {
    use super::super::hooks::MEMORIES;
    use super::*;
    use crate::angle::Angle;

    #[test]
    fn a_positive_asymmetry_raises_friction_in_positive_direction() {
        let law = AsymmetricFriction::<f64>::new(0, &[0.25, -0.5], false);
        let level = |speed| {
            let at = Rubbing { speed, transmitted: 0.0, passed_on: 0.0, angle: Angle::default() };
            1.0 / law.inverse_level(0, at)
        };
        assert!((level(1.0) - 1.25).abs() < 1e-12 && (level(-1.0) - 0.75).abs() < 1e-12);
        let viscous = |speed| law.viscous(0, speed, &[0.0; MEMORIES]);
        assert_eq!((viscous(1.0), viscous(-1.0)), (0.5, 1.5));
    }
}
