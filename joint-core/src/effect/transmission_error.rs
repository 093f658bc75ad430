//! Transmission error: teeth that are not where they should be.
//!
//! The spring of a stage feels `η q_in − q_out + a sin(n q_in + φ)`, and the input side feels the
//! spring's torque times the derivative of that, so that the error does no work of its own; the
//! damper sees the turning of the shafts alone. Source: Munro, "A review of the theory and measurement of gear transmission error" (1990).

use super::hooks::{Effects, Felt};
use super::{ParameterSpec, Place, Spec};
use crate::angle::{Angle, Ratio};
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "transmission-error",
    locations: &[Location::Stage(0)],
    parameters: &[
        // At the stage's output.
        ParameterSpec { key: "amplitude_rad", default: None, low: -1.0, high: 1.0 },
        ParameterSpec { key: "phase_rad", default: Some(0.0), low: -1e3, high: 1e3 },
        // Periods per turn of the stage's input.
        ParameterSpec { key: "order", default: None, low: 0.01, high: 1e5 },
    ],
    example: (Location::Stage(2), &[("amplitude_rad", 3e-4), ("order", 2.0), ("phase_rad", 0.3)]),
    table: None,
    remembers: false,
};

/// The law for one stage.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct TransmissionError<S: Scalar> {
    stage: u8,
    order: Ratio<S>,
    sine: S,
    cosine: S,
    leverage: S::Gain,
}

batch!(TransmissionError<Scalar>: order, sine, cosine, leverage; stage);

impl<S: Scalar> TransmissionError<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.stage()?, place.values, place.angle, place.input_angle?))
    }

    /// From the values of [`SPEC`]; `angle` is the unit of the stage's deflection in rad at its
    /// output, `input` that at its input.
    pub fn new(stage: u8, values: &[f64], angle: f64, input: f64) -> Self {
        let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
        let (amplitude, order, phase) = (value(0) / angle, value(2), value(1));
        Self {
            stage,
            order: Ratio::new(order),
            sine: S::from_f64(amplitude * libm::cos(phase)),
            cosine: S::from_f64(amplitude * libm::sin(phase)),
            leverage: S::gain(order * input),
        }
    }
}

impl<S: Scalar> Effects<S> for TransmissionError<S> {
    fn has_stages(&self) -> bool {
        true
    }

    fn has_stage(&self, stage: usize) -> bool {
        stage == usize::from(self.stage)
    }

    #[inline(always)]
    fn stage(&self, stage: usize, deflection: S, input: Angle<S>) -> Felt<S> {
        if stage != usize::from(self.stage) {
            return Felt { deflection, contact: S::ONE, leverage: S::ONE };
        }
        let turns = self.order.of(input);
        let (sin, cos) = (turns.sin_turns(), turns.cos_turns());
        let slope = (self.sine * cos - self.cosine * sin).times(self.leverage);
        Felt {
            deflection: deflection + self.sine * sin + self.cosine * cos,
            contact: S::ONE,
            leverage: S::ONE + slope,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_leverage_is_the_derivative_of_the_argument() {
        let (reduction, order) = (16.0, 3.0);
        let law = TransmissionError::<f64>::new(0, &[1e-3, 0.3, order], 1.0 / reduction, 1.0);
        let felt = |q: f64| law.stage(0, q, Angle::from_turns(q / core::f64::consts::TAU));
        for k in -10..10 {
            let q = 0.23 * f64::from(k);
            let argument = q / reduction + 1e-3 * (order * q + 0.3).sin();
            assert!((felt(q).deflection / reduction - argument).abs() < 1e-10);
            let difference = felt(q + 1e-4).deflection - felt(q - 1e-4).deflection;
            assert!((felt(q).leverage - difference / 2e-4).abs() < 1e-5);
        }
    }
}
