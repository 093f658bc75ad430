//! Play in a stage: the spring's argument passes a dead zone of total width b at the output side.
//!
//! `x ↦ x − b/2 sgn x` outside `|x| ≤ b/2`, zero inside; the stage's damping acts only in contact.
//! Source: the dead-zone model of Nordin and Gutman, "Controlling mechanical systems with backlash"
//! (Automatica, 2002).

use super::hooks::{Effects, Felt};
use super::{ParameterSpec, Place, Spec};
use crate::angle::Angle;
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "backlash",
    locations: &[Location::Stage(0)],
    // Total width of the dead zone at the stage's output, rad.
    parameters: &[ParameterSpec { key: "width_rad", default: None, low: 0.0, high: 1.0 }],
    example: (Location::Stage(2), &[("width_rad", 2e-4)]),
    table: None,
    remembers: false,
};

/// The law for one stage.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct Backlash<S: Scalar> {
    stage: u8,
    half_width: S,
}

batch!(Backlash<Scalar>: half_width; stage);

impl<S: Scalar> Backlash<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.stage()?, place.values, place.angle.abs()))
    }

    /// From the values of [`SPEC`]; `angle` is the unit of the stage's deflection in rad.
    pub fn new(stage: u8, values: &[f64], angle: f64) -> Self {
        let width: f64 = values.first().copied().unwrap_or(0.0);
        Self { stage, half_width: S::from_f64(width / (2.0 * angle)) }
    }
}

impl<S: Scalar> Effects<S> for Backlash<S> {
    fn has_stages(&self) -> bool {
        true
    }

    fn has_stage(&self, stage: usize) -> bool {
        stage == usize::from(self.stage)
    }

    #[inline(always)]
    fn stage(&self, stage: usize, deflection: S, _input: Angle<S>) -> Felt<S> {
        if stage != usize::from(self.stage) {
            return Felt { deflection, contact: S::ONE, leverage: S::ONE };
        }
        let (above, below) =
            (self.half_width.below(deflection), deflection.below(-self.half_width));
        let chosen =
            |above_it, below_it| S::choose(above, above_it, S::choose(below, below_it, S::ZERO));
        Felt {
            deflection: chosen(deflection - self.half_width, deflection + self.half_width),
            contact: chosen(S::ONE, S::ONE),
            leverage: S::ONE,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_contact_lines_lie_one_width_apart() {
        let law = Backlash::<f64>::new(0, &[0.2], 1.0);
        let felt = |deflection| law.stage(0, deflection, Angle::default());
        assert_eq!((felt(0.05).deflection, felt(0.05).contact), (0.0, 0.0));
        assert!((felt(0.3).deflection - 0.2).abs() < 1e-12);
        assert!((felt(-0.3).deflection + 0.2).abs() < 1e-12);
    }
}
