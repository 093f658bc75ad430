//! Gear loss with another efficiency where the motor drives the load than where the load drives the
//! motor.
//!
//! The LuGre level becomes `g(v) (1 + μ |T| / α0)` with T the torque of the stage, spring and damper,
//! and `μ = μ₁` where T acts along the motion, so that power flows to the load, `μ = μ₂` where it acts
//! against it. In steady motion the mass behind the spring then passes on `(1 − μ₁)|T|`, and the spring
//! feels `|T| = |T_load|/(1 + μ₂)` of a load that drives: the mesh has the efficiencies
//! `η₁ = 1 − μ₁` and `η₂ = 1/(1 + μ₂)`. Equal coefficients are load-dependent friction.
//!
//! A level above zero cannot make the bristle give power, whichever way it changes, so the law is as
//! passive as LuGre friction is. Where T changes its sign both levels are α0; where v does, the level
//! jumps and the friction does not, since the bristle moves on from where it is. Source: Giberti,
//! Cinquemani and Legnani, "A practical approach to the selection of the motor-reducer unit in electric
//! drive systems" (2011), direct and reverse efficiency; the gear-loss models M5 and M6 of Duclusaud,
//! Passault and others for servo actuators.

use super::hooks::{Effects, Rubbing};
use super::{ParameterSpec, Place, Spec};
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "drive-efficiency",
    locations: &[Location::Stage(0)],
    parameters: &[
        // μ₁ = 1 − η₁: friction torque per torque of the stage where that acts along the motion.
        ParameterSpec { key: "driving", default: None, low: 0.0, high: 10.0 },
        // μ₂ = 1/η₂ − 1: the same where it acts against it.
        ParameterSpec { key: "driven", default: None, low: 0.0, high: 10.0 },
    ],
    example: (Location::Stage(2), &[("driving", 0.1), ("driven", 0.25)]),
    table: None,
    remembers: false,
};

/// The law for the mass behind one stage.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct DriveEfficiency<S: Scalar> {
    mass: u8,
    driving: S::Gain,
    driven: S::Gain,
}

batch!(DriveEfficiency<Scalar>: driving, driven; mass);

impl<S: Scalar> DriveEfficiency<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.mass, place.values, place.coulomb, place.torque.abs()))
    }

    /// From the values of [`SPEC`], the mass's Coulomb level and the unit of torque there, both Nm.
    pub fn new(mass: u8, values: &[f64], coulomb: f64, torque: f64) -> Self {
        let per_torque = |k: usize| {
            let coefficient = values.get(k).copied().unwrap_or(0.0);
            S::gain(if coulomb > 0.0 { coefficient * torque / coulomb } else { 0.0 })
        };
        Self { mass, driving: per_torque(0), driven: per_torque(1) }
    }
}

impl<S: Scalar> Effects<S> for DriveEfficiency<S> {
    fn has_levels(&self) -> bool {
        true
    }

    fn has_level(&self, mass: usize) -> bool {
        mass == usize::from(self.mass)
    }

    #[inline(always)]
    fn inverse_level(&self, mass: usize, at: Rubbing<S>) -> S {
        if mass != usize::from(self.mass) {
            return S::ONE;
        }
        let load = at.transmitted.abs();
        let is_driven = at.transmitted.along(at.speed).below(S::ZERO);
        let share = S::choose(is_driven, load.times(self.driven), load.times(self.driving));
        S::ONE.over(S::ONE + share)
    }
}

#[cfg(test)]
mod tests {
    use super::super::load_dependent_friction::LoadDependentFriction;
    use super::*;
    use crate::angle::Angle;

    fn at(speed: f64, transmitted: f64) -> Rubbing<f64> {
        Rubbing { speed, transmitted, passed_on: 0.0, angle: Angle::default() }
    }

    #[test]
    fn the_sign_of_the_power_chooses_the_coefficient() {
        let (driving, driven, coulomb) = (0.1, 0.4, 0.3);
        let law = DriveEfficiency::<f64>::new(1, &[driving, driven], coulomb, 1.0);
        for (speed, torque, mu) in
            [(1.0, 2.0, driving), (-1.0, -2.0, driving), (1.0, -2.0, driven), (-1.0, 2.0, driven)]
        {
            let level = coulomb / law.inverse_level(1, at(speed, torque));
            assert!((level - (coulomb + mu * 2.0)).abs() < 1e-12, "{speed} {torque}");
        }
        assert_eq!(law.inverse_level(0, at(1.0, 2.0)), 1.0);
        // Nothing jumps where the torque turns.
        assert_eq!(law.inverse_level(1, at(1.0, 0.0)), law.inverse_level(1, at(1.0, -0.0)));
    }

    #[test]
    fn equal_coefficients_are_load_dependent_friction_to_the_bit() {
        let even = DriveEfficiency::<f64>::new(1, &[0.23, 0.23], 0.3, 0.7);
        let plain = LoadDependentFriction::<f64>::new(1, &[0.23], 0.3, 0.7);
        for k in -20..=20 {
            for speed in [-2.0, -1e-9, 0.0, 1e-9, 2.0] {
                let at = at(speed, 0.17 * f64::from(k));
                assert_eq!(even.inverse_level(1, at), plain.inverse_level(1, at));
            }
        }
    }
}
