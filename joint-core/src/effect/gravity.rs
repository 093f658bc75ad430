//! Gravity: a torque `−g sin(q + φ)` on the last mass, or on the rotor where there is no stage.
//!
//! The same law as the `[load]` table's gravity, which is built from it; as an effect it is what
//! discovery adds to a joint whose model knows of none. Source: the pendulum.

use super::cogging::Line;
use super::hooks::{Effects, Memory, Motion, Torque};
use super::{ParameterSpec, Place, Spec};
use crate::batch::batch;
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
    example: (Location::Output, &[("amplitude_nm", 5e-3), ("phase_rad", 0.4)]),
    table: None,
    remembers: false,
};

/// The law for one mass.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct Gravity<S: Scalar> {
    mass: u8,
    line: Line<S>,
}

batch!(Gravity<Scalar>: line; mass);

impl<S: Scalar> Gravity<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.mass, place.values, place.torque, [place.shaft, place.angle]))
    }

    /// From the values of [`SPEC`], with the unit of torque (Nm) at the mass, its ratio to the motor and the unit of
    /// deflection (rad) there.
    pub fn new(mass: u8, values: &[f64], torque: f64, at: [f64; 2]) -> Self {
        let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
        Self { mass, line: Line::new(1.0, value(0) / torque, value(1), at) }
    }
}

impl<S: Scalar> Effects<S> for Gravity<S> {
    fn has_torque(&self, mass: usize) -> bool {
        mass == usize::from(self.mass)
    }

    #[inline(always)]
    fn torque(&self, mass: usize, at: Motion<S>, _memory: &Memory<S>) -> Torque<S> {
        if mass == usize::from(self.mass) { self.line.torque(at.angle) } else { Torque::NONE }
    }
}

#[cfg(test)]
mod tests {
    use super::super::hooks::MEMORIES;
    use super::*;
    use crate::angle::Angle;

    #[test]
    fn a_pendulum_is_pulled_back_to_where_it_hangs() {
        let law = Gravity::<f64>::new(0, &[2.0, 0.5], 1.0, [1.0; 2]);
        let torque = |q: f64| {
            let turns = q / core::f64::consts::TAU;
            let at = Motion { angle: Angle::from_turns(turns), speed: 0.0 };
            law.torque(0, at, &[0.0; MEMORIES]).value
        };
        assert!(torque(-0.5).abs() < 1e-9);
        assert!((torque(0.3) + 2.0 * 0.8_f64.sin()).abs() < 1e-9);
    }
}
