//! An eddy-current brake: a drag that grows with the speed up to a critical one, and falls beyond it.
//!
//! Rotor torque `−2 T_k (ω/ω_k) / (1 + (ω/ω_k)²)`: at ω_k it is T_k, the most there is. Source: Wouterse,
//! "Critical torque and speed of eddy current brake with widely separated soft iron poles", IEE
//! Proceedings B 138 (1991).

use super::hooks::Effects;
use super::{ParameterSpec, Place, Spec};
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "eddy-brake",
    locations: &[Location::Motor],
    parameters: &[
        ParameterSpec { key: "critical_torque_nm", default: None, low: 0.0, high: 1e9 },
        ParameterSpec { key: "critical_speed_rad_per_s", default: None, low: 1e-9, high: 1e9 },
    ],
    example: (
        Location::Motor,
        &[("critical_torque_nm", 5e-6), ("critical_speed_rad_per_s", 200.0)],
    ),
    table: None,
    remembers: false,
};

/// The law.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct EddyBrake<S: Scalar> {
    slow: S,
    per_speed: S::Gain,
}

batch!(EddyBrake<Scalar>: slow, per_speed);

impl<S: Scalar> EddyBrake<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.values, place.torque, place.speed))
    }

    /// From the values of [`SPEC`], the units of torque (Nm) and speed (rad/s).
    pub fn new(values: &[f64], torque: f64, speed: f64) -> Self {
        let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
        let ratio = speed / value(1);
        Self { slow: S::from_f64(2.0 * value(0) / torque * ratio), per_speed: S::gain(ratio) }
    }
}

impl<S: Scalar> Effects<S> for EddyBrake<S> {
    fn has_damping(&self, mass: usize) -> bool {
        mass == 0
    }

    #[inline(always)]
    fn drag(&self, mass: usize, speed: S) -> S {
        if mass != 0 {
            return S::ZERO;
        }
        let ratio = speed.times(self.per_speed);
        self.slow.over(S::ONE + ratio * ratio)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_torque_is_the_equation_and_falls_beyond_the_critical_speed() {
        let law = EddyBrake::<f64>::new(&[0.3, 20.0], 2.0, 4.0);
        let torque = |speed: f64| 2.0 * law.drag(0, speed / 4.0) * speed / 4.0;
        assert!((torque(20.0) - 0.3).abs() < 1e-12);
        assert!((torque(-60.0) + 0.3 * 6.0 / 10.0).abs() < 1e-12);
        assert_eq!(law.drag(1, 1.0), 0.0);
    }
}
