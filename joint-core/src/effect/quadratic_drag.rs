//! Drag that grows with the square of the speed: a fan on the shaft, oil that is thrown about.
//!
//! Rotor torque `−c ω |ω|`. Source: windage of rotating discs, any textbook of fluid mechanics.

use super::hooks::Effects;
use super::{ParameterSpec, Place, Spec};
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "quadratic-drag",
    locations: &[Location::Motor],
    parameters: &[ParameterSpec { key: "coefficient_nm_s2", default: None, low: 0.0, high: 1e9 }],
    example: (Location::Motor, &[("coefficient_nm_s2", 2e-12)]),
    table: None,
    remembers: false,
};

/// The law.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct QuadraticDrag<S: Scalar> {
    coefficient: S,
}

batch!(QuadraticDrag<Scalar>: coefficient);

impl<S: Scalar> QuadraticDrag<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.values, place.torque, place.speed))
    }

    /// From the values of [`SPEC`], the units of torque (Nm) and speed (rad/s).
    pub fn new(values: &[f64], torque: f64, speed: f64) -> Self {
        let coefficient: f64 = values.first().copied().unwrap_or(0.0);
        Self { coefficient: S::from_f64(coefficient * speed * speed / torque) }
    }
}

impl<S: Scalar> Effects<S> for QuadraticDrag<S> {
    fn has_damping(&self, mass: usize) -> bool {
        mass == 0
    }

    #[inline(always)]
    fn drag(&self, mass: usize, speed: S) -> S {
        if mass == 0 { self.coefficient * speed.abs() } else { S::ZERO }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twice_the_speed_is_four_times_the_torque() {
        let law = QuadraticDrag::<f64>::new(&[0.5], 2.0, 4.0);
        let torque = |speed: f64| law.drag(0, speed) * speed;
        assert!((torque(1.0) - 0.5 * 16.0 / 2.0).abs() < 1e-12);
        assert_eq!(torque(-2.0), -4.0 * torque(1.0));
    }
}
