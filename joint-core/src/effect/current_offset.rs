//! A current sensor that shows `i + o`.
//!
//! Where the voltage is the input it is a matter of the measurement alone; where the current is
//! the input, the winding carries `i − o`. Source: the zero-current calibration of any drive.

use super::hooks::Effects;
use super::{ParameterSpec, Place, Spec};
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "current-offset",
    locations: &[Location::CurrentSensor],
    parameters: &[ParameterSpec { key: "offset_a", default: None, low: -1e6, high: 1e6 }],
    example: (Location::CurrentSensor, &[("offset_a", 0.01)]),
    table: None,
    remembers: false,
};

/// The law.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct CurrentOffset<S: Scalar> {
    offset: S,
}

batch!(CurrentOffset<Scalar>: offset);

impl<S: Scalar> CurrentOffset<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.values, place.current))
    }

    /// From the values of [`SPEC`] and the unit of current in A.
    pub fn new(values: &[f64], current: f64) -> Self {
        let offset: f64 = values.first().copied().unwrap_or(0.0);
        Self { offset: S::from_f64(offset / current) }
    }
}

impl<S: Scalar> Effects<S> for CurrentOffset<S> {
    #[inline]
    fn measured_current(&self, current: S) -> S {
        current + self.offset
    }

    #[inline]
    fn true_current(&self, measured: S) -> S {
        measured - self.offset
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measuring_and_correcting_undo_each_other() {
        let law = CurrentOffset::<f64>::new(&[0.5], 2.0);
        assert_eq!(law.measured_current(1.0), 1.25);
        assert_eq!(law.true_current(law.measured_current(1.0)), 1.0);
    }
}
