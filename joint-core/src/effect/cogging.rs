//! Cogging: the magnets' pull on the teeth, a torque on the rotor that depends on its angle alone.
//!
//! `T = −(a sin(n q + φ) + b sin(2 n q + ψ))`, the same at every current and speed. Orders are the
//! least common multiple of slots and magnet poles, with the slot or pole number where the machine
//! is not perfect; one effect holds an order and its double, further orders are further effects.
//! Source: Hanselman, "Brushless Permanent Magnet Motor Design", chapter on cogging torque.

use super::hooks::{Effects, Memory, Motion, Torque};
use super::{ParameterSpec, Place, Spec};
use crate::angle::{Angle, Ratio};
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "cogging",
    locations: &[Location::Motor],
    parameters: &[
        // Periods per turn of the rotor; at the lowest a constant, all but for ever.
        ParameterSpec { key: "order", default: None, low: 1e-4, high: 1e5 },
        ParameterSpec { key: "amplitude_nm", default: None, low: -1e9, high: 1e9 },
        ParameterSpec { key: "phase_rad", default: Some(0.0), low: -1e3, high: 1e3 },
        // The double order's share.
        ParameterSpec { key: "second_amplitude_nm", default: Some(0.0), low: -1e9, high: 1e9 },
        ParameterSpec { key: "second_phase_rad", default: Some(0.0), low: -1e3, high: 1e3 },
    ],
    example: (
        Location::Motor,
        &[("order", 6.0), ("amplitude_nm", 8e-6), ("second_amplitude_nm", 2e-6)],
    ),
    table: None,
    remembers: false,
};

/// A torque that follows one order of an angle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub(super) struct Line<S: Scalar> {
    order: Ratio<S>,
    sine: S,
    cosine: S,
    slope: S::Gain,
}

batch!(Line<Scalar>: order, sine, cosine, slope);

impl<S: Scalar> Line<S> {
    /// `−amplitude · sin(order · q + phase)` with q of a mass behind the ratio `shaft`; `angle` is the
    /// unit of the deflections in rad at this mass, in which the slope is given.
    pub(super) fn new(order: f64, amplitude: f64, phase: f64, [shaft, angle]: [f64; 2]) -> Self {
        Self {
            order: Ratio::new(order * shaft),
            sine: S::from_f64(-amplitude * libm::cos(phase)),
            cosine: S::from_f64(-amplitude * libm::sin(phase)),
            slope: S::gain(order * angle),
        }
    }

    #[inline(always)]
    pub(super) fn torque(&self, angle: Angle<S>) -> Torque<S> {
        let turns = self.order.of(angle);
        let (sin, cos) = (turns.sin_turns(), turns.cos_turns());
        Torque {
            value: self.sine * sin + self.cosine * cos,
            slope: (self.sine * cos - self.cosine * sin).times(self.slope),
        }
    }
}

/// The law: an order and its double.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct Cogging<S: Scalar> {
    first: Line<S>,
    second: Line<S>,
}

batch!(Cogging<Scalar>: first, second);

impl<S: Scalar> Cogging<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.values, place.torque, place.angle))
    }

    /// From the values of [`SPEC`], with the units of torque (Nm) and deflection (rad).
    pub fn new(values: &[f64], torque: f64, angle: f64) -> Self {
        let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
        Self {
            first: Line::new(value(0), value(1) / torque, value(2), [1.0, angle]),
            second: Line::new(2.0 * value(0), value(3) / torque, value(4), [1.0, angle]),
        }
    }
}

impl<S: Scalar> Effects<S> for Cogging<S> {
    fn has_torque(&self, mass: usize) -> bool {
        mass == 0
    }

    #[inline(always)]
    fn torque(&self, mass: usize, at: Motion<S>, _memory: &Memory<S>) -> Torque<S> {
        if mass != 0 {
            return Torque::NONE;
        }
        self.first.torque(at.angle).plus(self.second.torque(at.angle))
    }
}

#[cfg(test)]
mod tests {
    use super::super::hooks::MEMORIES;
    use super::*;

    #[test]
    fn the_torque_is_the_equation_and_the_slope_its_derivative() {
        let (n, a, phase, b, second) = (6.0, 0.3, 0.7, 0.1, -0.4);
        let law = Cogging::<f64>::new(&[n, a, phase, b, second], 1.0, 1.0);
        let torque = |q: f64| {
            let turns = q / core::f64::consts::TAU;
            let at = Motion { angle: Angle::from_turns(turns), speed: 0.0 };
            law.torque(0, at, &[0.0; MEMORIES])
        };
        for k in -20..20 {
            let q = 0.37 * f64::from(k);
            let exact = -(a * (n * q + phase).sin() + b * (2.0 * n * q + second).sin());
            assert!((torque(q).value - exact).abs() < 1e-9);
            let difference = torque(q + 1e-5).value - torque(q - 1e-5).value;
            assert!((torque(q).slope - difference / 2e-5).abs() < 1e-4);
        }
    }
}
