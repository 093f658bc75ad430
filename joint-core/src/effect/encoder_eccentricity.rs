//! An encoder whose disc does not turn about its middle: it shows `q + a sin(n q + φ)`.
//!
//! Order one is a disc off its centre, order two a tilted one. The joint moves as ever; only what is
//! seen of it changes. Source: the error budget of any encoder's data sheet.

use super::hooks::{Effects, Memory};
use super::{ParameterSpec, Place, Spec};
use crate::angle::{Angle, Ratio};
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "encoder-eccentricity",
    locations: &[Location::Encoder, Location::OutputEncoder],
    parameters: &[
        ParameterSpec { key: "amplitude_rad", default: None, low: -1.0, high: 1.0 },
        ParameterSpec { key: "phase_rad", default: Some(0.0), low: -1e3, high: 1e3 },
        // Periods per turn of the encoder.
        ParameterSpec { key: "order", default: Some(1.0), low: 0.01, high: 1e5 },
    ],
    example: (Location::Encoder, &[("amplitude_rad", 0.02)]),
    table: None,
    remembers: false,
};

/// The law for one encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct EncoderEccentricity<S: Scalar> {
    output: bool,
    order: Ratio<S>,
    sine: S,
    cosine: S,
}

batch!(EncoderEccentricity<Scalar>: order, sine, cosine; output);

impl<S: Scalar> EncoderEccentricity<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.behind, place.values))
    }

    /// From the values of [`SPEC`].
    pub fn new(output: bool, values: &[f64]) -> Self {
        let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
        let turns = value(0) / core::f64::consts::TAU;
        Self {
            output,
            order: Ratio::new(value(2)),
            sine: S::from_f64(turns * libm::cos(value(1))),
            cosine: S::from_f64(turns * libm::sin(value(1))),
        }
    }
}

impl<S: Scalar> Effects<S> for EncoderEccentricity<S> {
    #[inline(always)]
    fn encoder_error(&self, output: bool, angle: Angle<S>, _: S, _: &Memory<S>) -> S {
        if output != self.output {
            return S::ZERO;
        }
        let turns = self.order.of(angle);
        self.sine * turns.sin_turns() + self.cosine * turns.cos_turns()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_the_equation() {
        let law = EncoderEccentricity::<f64>::new(false, &[0.02, 0.3, 1.0]);
        for k in -10..10 {
            let q = 0.41 * f64::from(k);
            let angle = Angle::from_turns(q / core::f64::consts::TAU);
            let turns = law.encoder_error(false, angle, 0.0, &[0.0; 4]);
            let error = turns * core::f64::consts::TAU;
            assert!((error - 0.02 * (q + 0.3).sin()).abs() < 1e-9);
        }
        assert_eq!(law.encoder_error(true, Angle::from_turns(0.2), 0.0, &[0.0; 4]), 0.0);
    }
}
