//! A spring that stiffens more than the model says: `k3 x³` beside a stage's spring.
//!
//! Source: equation (1) of the paper, for the stages whose cubic term nobody measured.

use super::hooks::{Effects, Memory, Torque};
use super::{ParameterSpec, Place, Spec};
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "hardening-stiffness",
    locations: &[Location::Stage(0)],
    // At the stage's output.
    parameters: &[ParameterSpec {
        key: "cubic_stiffness_nm_per_rad3",
        default: None,
        low: 0.0,
        high: 1e18,
    }],
    example: (Location::Stage(2), &[("cubic_stiffness_nm_per_rad3", 1.5e5)]),
    table: None,
    remembers: false,
};

/// The law for one stage.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct HardeningStiffness<S: Scalar> {
    stage: u8,
    cubic: S::Gain,
}

batch!(HardeningStiffness<Scalar>: cubic; stage);

impl<S: Scalar> HardeningStiffness<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.stage()?, place.values, place.torque, place.angle))
    }

    /// From the values of [`SPEC`], with the units of torque (Nm) and deflection (rad) at the
    /// stage's output.
    pub fn new(stage: u8, values: &[f64], torque: f64, angle: f64) -> Self {
        let cubic: f64 = values.first().copied().unwrap_or(0.0);
        Self { stage, cubic: S::gain(cubic * angle * angle * angle / torque) }
    }
}

impl<S: Scalar> Effects<S> for HardeningStiffness<S> {
    fn has_stages(&self) -> bool {
        true
    }

    fn has_stage(&self, stage: usize) -> bool {
        stage == usize::from(self.stage)
    }

    #[inline(always)]
    fn stage_torque(&self, stage: usize, felt: S, _memory: &Memory<S>) -> Torque<S> {
        if stage != usize::from(self.stage) {
            return Torque::NONE;
        }
        let square = felt * felt;
        let three = S::ONE + S::ONE + S::ONE;
        Torque {
            value: (felt * square).times(self.cubic),
            slope: (three * square).times(self.cubic),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::hooks::MEMORIES;
    use super::*;

    #[test]
    fn it_is_a_cubic_spring() {
        let law = HardeningStiffness::<f64>::new(1, &[5.0], 2.0, 0.5);
        let torque = law.stage_torque(1, -2.0, &[0.0; MEMORIES]);
        assert!((torque.value * 2.0 + 5.0).abs() < 1e-12);
        assert!((torque.slope * 2.0 / 0.5 - 15.0).abs() < 1e-12);
    }
}
