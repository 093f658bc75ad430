//! Friction that follows the angle: a bent shaft, a seal that is tight on one side.
//!
//! The LuGre level becomes `g(v) (1 + a sin(n q + φ))` with q the mass's own angle. Source: the
//! friction maps of robot joints, Bittencourt and Gunnarsson, "Static friction in a robot joint"
//! (2012).

use super::hooks::{Effects, Rubbing};
use super::{ParameterSpec, Place, Spec};
use crate::angle::Ratio;
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "position-dependent-friction",
    locations: &[Location::Motor, Location::Stage(0)],
    parameters: &[
        ParameterSpec { key: "relative_amplitude", default: None, low: -0.95, high: 0.95 },
        ParameterSpec { key: "phase_rad", default: Some(0.0), low: -1e3, high: 1e3 },
        // Periods per turn of the mass.
        ParameterSpec { key: "order", default: None, low: 0.01, high: 1e5 },
    ],
    example: (Location::Stage(2), &[("relative_amplitude", 0.5), ("order", 24.0)]),
    table: None,
    remembers: false,
};

/// The law for one mass.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct PositionDependentFriction<S: Scalar> {
    mass: u8,
    order: Ratio<S>,
    sine: S,
    cosine: S,
}

batch!(PositionDependentFriction<Scalar>: order, sine, cosine; mass);

impl<S: Scalar> PositionDependentFriction<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.mass, place.values, place.shaft))
    }

    /// From the values of [`SPEC`] and the mass's ratio to the motor.
    pub fn new(mass: u8, values: &[f64], shaft: f64) -> Self {
        let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
        Self {
            mass,
            order: Ratio::new(value(2) * shaft),
            sine: S::from_f64(value(0) * libm::cos(value(1))),
            cosine: S::from_f64(value(0) * libm::sin(value(1))),
        }
    }
}

impl<S: Scalar> Effects<S> for PositionDependentFriction<S> {
    fn has_levels(&self) -> bool {
        true
    }

    fn has_level(&self, mass: usize) -> bool {
        mass == usize::from(self.mass)
    }

    fn has_angled_levels(&self) -> bool {
        true
    }

    #[inline(always)]
    fn inverse_level(&self, mass: usize, at: Rubbing<S>) -> S {
        if mass != usize::from(self.mass) {
            return S::ONE;
        }
        let turns = self.order.of(at.angle);
        let share = self.sine * turns.sin_turns() + self.cosine * turns.cos_turns();
        S::ONE.ratio(S::ONE + share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::angle::Angle;

    #[test]
    fn the_level_follows_the_equation() {
        let law = PositionDependentFriction::<f64>::new(1, &[0.6, 0.5, 2.0], 1.0);
        for k in -10..10 {
            let q = 0.27 * f64::from(k);
            let angle = Angle::from_turns(q / core::f64::consts::TAU);
            let at = Rubbing { speed: 1.0, transmitted: 0.0, passed_on: 0.0, angle };
            let level = 1.0 / law.inverse_level(1, at);
            assert!((level - (1.0 + 0.6 * (2.0 * q + 0.5).sin())).abs() < 1e-8);
            assert_eq!(law.inverse_level(0, at), 1.0);
        }
    }
}
