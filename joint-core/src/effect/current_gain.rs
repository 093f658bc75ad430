//! A current sensor that shows `(1 + g) i`.
//!
//! Where the voltage is the input it is a matter of the measurement alone; where the current is
//! the input, the winding carries `i / (1 + g)`. It is nearly a symmetry of the model: R and L
//! divided, torques and inertias multiplied by the same factor show the same, so only a known
//! weight or trust in the nominal tells it. Source: the tolerance of any shunt and its amplifier.

use super::hooks::Effects;
use super::{ParameterSpec, Place, Spec};
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "current-gain",
    locations: &[Location::CurrentSensor],
    // g.
    parameters: &[ParameterSpec { key: "relative_gain", default: None, low: -0.9, high: 9.0 }],
    example: (Location::CurrentSensor, &[("relative_gain", 0.1)]),
    table: None,
    remembers: false,
};

/// The law.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct CurrentGain<S: Scalar> {
    shown: S::Gain,
    actual: S::Gain,
}

batch!(CurrentGain<Scalar>: shown, actual);

impl<S: Scalar> CurrentGain<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.values))
    }

    /// From the values of [`SPEC`].
    pub fn new(values: &[f64]) -> Self {
        let factor: f64 = 1.0 + values.first().copied().unwrap_or(0.0);
        Self { shown: S::gain(factor), actual: S::gain(1.0 / factor) }
    }
}

impl<S: Scalar> Effects<S> for CurrentGain<S> {
    #[inline(always)]
    fn measured_current(&self, current: S) -> S {
        current.times(self.shown)
    }

    #[inline(always)]
    fn true_current(&self, measured: S) -> S {
        measured.times(self.actual)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measuring_and_correcting_undo_each_other() {
        let law = CurrentGain::<f64>::new(&[0.12]);
        assert_eq!(law.measured_current(2.0), 2.24);
        assert!((law.true_current(law.measured_current(2.0)) - 2.0).abs() < 1e-12);
    }
}
