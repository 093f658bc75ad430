//! Friction that grows with the torque a mass passes on: the gear loss that catalogues call
//! efficiency.
//!
//! The LuGre level becomes `g(v) (1 + μ |T| / α0)` with T the torque of the stage, spring and
//! damper, or the motor torque for the rotor. Source: Linderoth, Stolt, Robertsson and Johansson (2013), and the
//! gear-loss models M3 to M6 of Duclusaud, Passault and others for servo actuators.

use super::hooks::{Effects, Rubbing};
use super::{ParameterSpec, Place, Spec};
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "load-dependent-friction",
    locations: &[Location::Motor, Location::Stage(0)],
    // μ: friction torque per transmitted torque.
    parameters: &[ParameterSpec { key: "coefficient", default: None, low: 0.0, high: 10.0 }],
    example: (Location::Stage(2), &[("coefficient", 0.15)]),
    table: None,
    remembers: false,
};

/// The law for one mass.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct LoadDependentFriction<S: Scalar> {
    mass: u8,
    per_torque: S::Gain,
}

batch!(LoadDependentFriction<Scalar>: per_torque; mass);

impl<S: Scalar> LoadDependentFriction<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.mass, place.values, place.coulomb, place.torque.abs()))
    }

    /// From the values of [`SPEC`], the mass's Coulomb level and the unit of torque there, both Nm.
    pub fn new(mass: u8, values: &[f64], coulomb: f64, torque: f64) -> Self {
        let coefficient = values.first().copied().unwrap_or(0.0);
        let per_torque = if coulomb > 0.0 { coefficient * torque / coulomb } else { 0.0 };
        Self { mass, per_torque: S::gain(per_torque) }
    }
}

impl<S: Scalar> Effects<S> for LoadDependentFriction<S> {
    fn has_levels(&self) -> bool {
        true
    }

    fn has_level(&self, mass: usize) -> bool {
        mass == usize::from(self.mass)
    }

    #[inline(always)]
    fn inverse_level(&self, mass: usize, at: Rubbing<S>) -> S {
        if mass == usize::from(self.mass) {
            S::ONE.over(S::ONE + at.transmitted.abs().times(self.per_torque))
        } else {
            S::ONE
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::angle::Angle;

    #[test]
    fn the_added_level_is_mu_times_the_torque() {
        let (mu, coulomb) = (0.12, 0.3);
        let law = LoadDependentFriction::<f64>::new(0, &[mu], coulomb, 1.0);
        let at = Rubbing { speed: 1.0, transmitted: -2.0, passed_on: 0.0, angle: Angle::default() };
        let level = coulomb / law.inverse_level(0, at);
        assert!((level - (coulomb + mu * 2.0)).abs() < 1e-12);
    }
}
