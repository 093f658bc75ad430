//! A drive that limits the motor's current by taking voltage off.
//!
//! Voltage and back-EMF alone would let the current settle at `i∞ = (u − k_t ω)/2R`. The drive takes off
//! as much of u as lets it settle at `I tanh(i∞/I)` instead, and the winding follows with its own time
//! constant: `u ↦ u − 2R (i∞ − I tanh(i∞/I))`. Far below the limit nothing is taken, far beyond it the
//! motor is a source of I, and what lies between is as soft as the foldback of drives is. What is taken
//! off follows from voltage and speed alone, so it makes nothing stiffer, however far beyond the limit
//! the voltage asks for. Where the current is the input, I tanh(i/I) flows of the i that is asked for.
//!
//! A kick takes the voltage off for the speed at its middle. The plain kick says where that is, but for
//! what the missing torque leaves it short of: the settled current rises by so much again, to first order
//! in the kick. Source: foldback current limiting, Horowitz and Hill, "The Art of Electronics"; the
//! smooth saturation of torque in models of servo actuators.

use super::hooks::{Effects, Excess};
use super::{ParameterSpec, Place, Spec};
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "current-limit",
    locations: &[Location::Inverter],
    // I: the current that is approached however high the voltage.
    parameters: &[ParameterSpec { key: "limit_a", default: None, low: 1e-9, high: 1e9 }],
    example: (Location::Inverter, &[("limit_a", 0.04)]),
    table: None,
    remembers: false,
};

/// The law.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct CurrentLimit<S: Scalar> {
    limit: S::Gain,
    per_limit: S::Gain,
}

batch!(CurrentLimit<Scalar>: limit, per_limit);

impl<S: Scalar> CurrentLimit<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.values, place.current))
    }

    /// From the values of [`SPEC`] and the unit of current in A.
    pub fn new(values: &[f64], current: f64) -> Self {
        let limit = values.first().copied().unwrap_or(f64::INFINITY) / current;
        Self { limit: S::gain(limit), per_limit: S::gain(1.0 / limit) }
    }
}

impl<S: Scalar> Effects<S> for CurrentLimit<S> {
    fn has_limit(&self) -> bool {
        true
    }

    #[inline(always)]
    fn excess(&self, settled: S) -> Excess<S> {
        let bent = settled.times(self.per_limit).tanh();
        Excess { value: settled - bent.times(self.limit), slope: bent * bent }
    }

    #[inline(always)]
    fn true_current(&self, measured: S) -> S {
        measured.times(self.per_limit).tanh().times(self.limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_of_the_current_is_the_equation_and_the_slope_its_derivative() {
        let (limit, unit) = (3.0, 0.5);
        let law = CurrentLimit::<f64>::new(&[limit], unit);
        for k in -40..=40 {
            let asked = 0.5 * f64::from(k);
            let wanted = limit * (asked / limit).tanh();
            let left = asked / unit - law.excess(asked / unit).value;
            assert!((left * unit - wanted).abs() < 1e-8, "{asked}");
            assert!((law.true_current(asked / unit) * unit - wanted).abs() < 1e-8, "{asked}");
            let of = |moved: f64| law.excess(asked / unit + moved).value;
            let difference = (of(1e-5) - of(-1e-5)) / 2e-5;
            assert!((law.excess(asked / unit).slope - difference).abs() < 1e-4, "{asked}");
        }
    }
}
