//! Torque saturation: iron that carries no more flux, so that k_t falls with the current.
//!
//! `k_t / (1 + (i/I)²)`; the back-EMF, which the magnets make alone, stays. Source: the torque
//! curves of any servo motor's data sheet near its peak current.

use super::hooks::{Constants, Effects};
use super::{ParameterSpec, Place, Spec};
use crate::angle::Angle;
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "torque-saturation",
    locations: &[Location::Motor],
    // I: the current at which half the torque constant is left.
    parameters: &[ParameterSpec { key: "current_a", default: None, low: 1e-12, high: 1e12 }],
    example: (Location::Motor, &[("current_a", 0.4)]),
    table: None,
    remembers: false,
};

/// The law.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct TorqueSaturation<S: Scalar> {
    per_current: S::Gain,
}

batch!(TorqueSaturation<Scalar>: per_current);

impl<S: Scalar> TorqueSaturation<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.values, place.current))
    }

    /// From the values of [`SPEC`] and the unit of current in A.
    pub fn new(values: &[f64], current: f64) -> Self {
        let knee = values.first().copied().unwrap_or(f64::INFINITY);
        Self { per_current: S::gain(current / knee) }
    }
}

impl<S: Scalar> Effects<S> for TorqueSaturation<S> {
    fn has_constants(&self) -> bool {
        true
    }

    #[inline(always)]
    fn constants(&self, _angle: Angle<S>, current: S) -> Constants<S> {
        let relative = current.times(self.per_current);
        let square = relative * relative;
        Constants { torque: -square.over(S::ONE + square), back_emf: S::ZERO }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_the_constant_is_left_at_the_knee() {
        let law = TorqueSaturation::<f64>::new(&[3.0], 1.5);
        let at = law.constants(Angle::default(), -2.0);
        assert!((at.torque + 0.5).abs() < 1e-12 && at.back_emf == 0.0);
    }
}
