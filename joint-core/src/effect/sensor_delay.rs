//! An encoder that is late: a filter in its chip, a bus that polls it, a clock of its own.
//!
//! It shows the angle of `d` seconds ago, `q(t − d)`; several delays of one encoder add ([`delay_s`]).
//! Where the past is not kept that is `q − d ω` ([`lag_rad`]). Whoever has the record takes the angle
//! from it, or shifts it by whole samples and leaves the rest to the lag. Source: any drive with two
//! encoders on different buses.

use super::hooks::{Effects, Memory};
use super::{EffectParameters, Kind, ParameterSpec, Place, Spec};
use crate::angle::Angle;
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "sensor-delay",
    locations: &[Location::Encoder, Location::OutputEncoder],
    parameters: &[ParameterSpec { key: "delay_s", default: None, low: -1.0, high: 1.0 }],
    example: (Location::Encoder, &[("delay_s", 4e-4)]),
    table: None,
    remembers: false,
};

/// How late these effects make an encoder, s.
pub fn delay_s(effects: &[EffectParameters], encoder: Location) -> f64 {
    let own =
        |effect: &&EffectParameters| effect.kind == Kind::SensorDelay && effect.location == encoder;
    effects.iter().filter(own).filter_map(|effect| effect.get("delay_s")).sum()
}

/// What an encoder that is so late shows beside the angle, rad, at a speed in rad/s: `−d ω`.
pub fn lag_rad(delay_s: f64, speed_rad_per_s: f64) -> f64 {
    -delay_s * speed_rad_per_s
}

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
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.behind, place.values, place.speed))
    }

    /// From the values of [`SPEC`]; `speed` is the unit of speed at the encoder's shaft, rad/s.
    pub fn new(output: bool, values: &[f64], speed: f64) -> Self {
        let delay: f64 = values.first().copied().unwrap_or(0.0);
        Self { output, turns: S::gain(lag_rad(delay, speed) / core::f64::consts::TAU) }
    }
}

impl<S: Scalar> Effects<S> for SensorDelay<S> {
    #[inline(always)]
    fn encoder_error(&self, output: bool, _: Angle<S>, speed: S, _: &Memory<S>) -> S {
        if output == self.output { speed.times(self.turns) } else { S::ZERO }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_late_encoder_lags_by_delay_times_speed() {
        let law = SensorDelay::<f64>::new(true, &[1e-3], 2.0);
        let error =
            law.encoder_error(true, Angle::default(), 5.0, &[0.0; 4]) * core::f64::consts::TAU;
        assert!((error + 1e-2).abs() < 1e-12);
        assert_eq!(law.encoder_error(false, Angle::default(), 5.0, &[0.0; 4]), 0.0);
    }

    #[test]
    fn delays_of_one_encoder_add_and_the_other_is_not_late() {
        let late = |encoder, delay| {
            EffectParameters::new(Kind::SensorDelay, encoder).with("delay_s", delay)
        };
        let both = [late(Location::Encoder, 1e-3), late(Location::Encoder, 2e-3)];
        assert_eq!(delay_s(&both, Location::Encoder), 1e-3 + 2e-3);
        assert_eq!(delay_s(&both, Location::OutputEncoder), 0.0);
    }
}
