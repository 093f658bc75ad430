//! An encoder that is late: a filter in its chip, a bus that polls it, a clock of its own.
//!
//! It shows the angle of `d` seconds ago. Here, where the past is not kept, that is `q − d ω`;
//! whoever has the record shifts it by whole samples first. Source: any drive with two encoders on
//! different buses.

use super::hooks::Effects;
use super::{ParameterSpec, Spec};
use crate::batch::batch;
use crate::angle::Angle;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "sensor-delay",
    locations: &[Location::Encoder, Location::OutputEncoder],
    parameters: &[ParameterSpec { key: "delay_s", default: None, low: -1.0, high: 1.0 }],
};

/// The law for one encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct SensorDelay<S: Scalar> {
    output: bool,
    turns: S::Gain,
}

batch!(SensorDelay<Scalar>: turns; output);

impl<S: Scalar> SensorDelay<S> {
    /// From the values of [`SPEC`]; `speed` is the unit of speed at the encoder's shaft, rad/s.
    pub fn new(output: bool, values: &[f64], speed: f64) -> Self {
        let delay: f64 = values.first().copied().unwrap_or(0.0);
        Self { output, turns: S::gain(-delay * speed / core::f64::consts::TAU) }
    }
}

impl<S: Scalar> Effects<S> for SensorDelay<S> {
    #[inline(always)]
    fn encoder_error(&self, output: bool, _angle: Angle<S>, speed: S) -> S {
        if output == self.output { speed.times(self.turns) } else { S::ZERO }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_late_encoder_lags_by_delay_times_speed() {
        let law = SensorDelay::<f64>::new(true, &[1e-3], 2.0);
        let error = law.encoder_error(true, Angle::default(), 5.0) * core::f64::consts::TAU;
        assert!((error + 1e-2).abs() < 1e-12);
        assert_eq!(law.encoder_error(false, Angle::default(), 5.0), 0.0);
    }
}
