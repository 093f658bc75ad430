//! Torque ripple: motor constants that follow the rotor angle.
//!
//! `k_t` and `k_e` times `1 + a cos(n q + φ)`: power balance makes the ripple of the torque and of
//! the back-EMF one and the same. Unlike cogging it grows with the current. Source: Jahns and Soong,
//! "Pulsating torque minimization techniques for permanent magnet AC motor drives" (1996).

use super::hooks::{Constants, Effects};
use super::{ParameterSpec, Place, Spec};
use crate::angle::{Angle, Ratio};
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "torque-ripple",
    locations: &[Location::Motor],
    parameters: &[
        ParameterSpec { key: "relative_amplitude", default: None, low: -0.95, high: 0.95 },
        ParameterSpec { key: "phase_rad", default: Some(0.0), low: -1e3, high: 1e3 },
        // Periods per turn of the rotor.
        ParameterSpec { key: "order", default: None, low: 0.01, high: 1e5 },
    ],
    example: (Location::Motor, &[("relative_amplitude", 0.1), ("order", 6.0), ("phase_rad", 0.3)]),
    table: None,
    remembers: false,
};

/// The law.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct TorqueRipple<S: Scalar> {
    order: Ratio<S>,
    cosine: S,
    sine: S,
}

batch!(TorqueRipple<Scalar>: order, cosine, sine);

impl<S: Scalar> TorqueRipple<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.values))
    }

    /// From the values of [`SPEC`].
    pub fn new(values: &[f64]) -> Self {
        let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
        Self {
            order: Ratio::new(value(2)),
            cosine: S::from_f64(value(0) * libm::cos(value(1))),
            sine: S::from_f64(-value(0) * libm::sin(value(1))),
        }
    }
}

impl<S: Scalar> Effects<S> for TorqueRipple<S> {
    fn has_constants(&self) -> bool {
        true
    }

    #[inline(always)]
    fn constants(&self, angle: Angle<S>, _current: S) -> Constants<S> {
        let turns = self.order.of(angle);
        let share = self.cosine * turns.cos_turns() + self.sine * turns.sin_turns();
        Constants { torque: share, back_emf: share }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn torque_and_back_emf_share_the_equation() {
        let law = TorqueRipple::<f64>::new(&[0.05, 0.4, 6.0]);
        for k in -10..10 {
            let q = 0.31 * f64::from(k);
            let at = law.constants(Angle::from_turns(q / core::f64::consts::TAU), 1.0);
            assert!((at.torque - 0.05 * (6.0 * q + 0.4).cos()).abs() < 1e-9);
            assert_eq!(at.torque, at.back_emf);
        }
    }
}
