//! Gravity: a torque `−g sin(q + φ)` on the last mass, or on the rotor where there is no stage.
//!
//! The same law as the `[load]` table's gravity, which is built from it; as an effect it is what
//! discovery adds to a joint whose model knows of none. Source: the pendulum.

use super::cogging::Line;
use super::{Motion, ParameterSpec, Spec, Torque};
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "gravity",
    locations: &[Location::Output, Location::Motor],
    parameters: &[
        ParameterSpec { key: "amplitude_nm", default: None, low: -1e9, high: 1e9 },
        ParameterSpec { key: "phase_rad", default: Some(0.0), low: -1e3, high: 1e3 },
    ],
};

/// The law for one mass.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct Gravity<S: Scalar> {
    /// The mass it acts on, 0 at the rotor.
    pub mass: u8,
    line: Line<S>,
}

impl<S: Scalar> Gravity<S> {
    /// From the values of [`SPEC`], with the units of torque (Nm) and deflection (rad) at the mass.
    pub fn new(mass: u8, values: &[f64], torque: f64, angle: f64) -> Self {
        let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
        Self { mass, line: Line::new(1.0, value(0) / torque, value(1), angle) }
    }

    /// Torque on the mass.
    #[inline]
    pub fn torque(&self, at: Motion<S>) -> Torque<S> {
        self.line.torque(at.angle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::angle::Angle;

    #[test]
    fn a_pendulum_is_pulled_back_to_where_it_hangs() {
        let law = Gravity::<f64>::new(0, &[2.0, 0.5], 1.0, 1.0);
        let at =
            |q: f64| Motion { angle: Angle::from_turns(q / core::f64::consts::TAU), speed: 0.0 };
        assert!(law.torque(at(-0.5)).value.abs() < 1e-9);
        assert!((law.torque(at(0.3)).value + 2.0 * 0.8_f64.sin()).abs() < 1e-9);
    }
}
