//! Structural hysteresis: a stage that loses the same work in every cycle, however slow.
//!
//! The stage passes `a ζ/w` beside its spring, with `ζ' = v − |v| ζ/w` and v the speed of the
//! spring's argument: a bristle of width w without a Stribeck curve. Source: the wind-up loops of
//! strain-wave gears, Taghirad and Bélanger, "Modeling and parameter identification of harmonic
//! drive systems" (1998); form after Dahl.

use super::hooks::{Effects, Flow, Memory, Relaxation, Relaxations, Torque, keep};
use super::{ParameterSpec, Place, Spec};
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "structural-hysteresis",
    locations: &[Location::Stage(0)],
    parameters: &[
        ParameterSpec { key: "amplitude_nm", default: None, low: 0.0, high: 1e9 },
        // w, at the stage's output.
        ParameterSpec { key: "width_rad", default: None, low: 1e-9, high: 1e3 },
    ],
    example: (Location::Stage(2), &[("amplitude_nm", 4e-3), ("width_rad", 2e-3)]),
    table: None,
    remembers: true,
};

/// The law for one stage.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct StructuralHysteresis<S: Scalar> {
    stage: u8,
    slot: u8,
    amplitude: S,
    slope: S::Gain,
    per_width: S::Gain,
}

batch!(StructuralHysteresis<Scalar>: amplitude, slope, per_width; stage, slot);

impl<S: Scalar> StructuralHysteresis<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.stage()?, place.slot, place.values, place.own()))
    }

    /// From the values of [`SPEC`], with the units of torque (Nm) and deflection (rad) at the
    /// stage's output, and how far a unit of speed moves in half a micro-step, rad there.
    pub fn new(stage: u8, slot: u8, values: &[f64], [torque, angle, moved]: [f64; 3]) -> Self {
        let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
        Self {
            stage,
            slot,
            amplitude: S::from_f64(value(0) / torque),
            slope: S::gain(angle / value(1)),
            per_width: S::gain(moved / value(1)),
        }
    }
}

impl<S: Scalar> Effects<S> for StructuralHysteresis<S> {
    fn has_stages(&self) -> bool {
        true
    }

    fn has_stage(&self, stage: usize) -> bool {
        stage == usize::from(self.stage)
    }

    fn has_memory(&self) -> bool {
        true
    }

    #[inline(always)]
    fn stage_torque(&self, stage: usize, _felt: S, memory: &Memory<S>) -> Torque<S> {
        match memory.get(usize::from(self.slot)) {
            Some(bent) if stage == usize::from(self.stage) => Torque {
                value: self.amplitude * *bent,
                slope: (self.amplitude * (S::ONE - bent.abs())).times(self.slope),
            },
            _ => Torque::NONE,
        }
    }

    #[inline(always)]
    fn relax(&self, flow: &Flow<'_, S>, all: &mut Relaxations<S>) {
        let stage = usize::from(self.stage);
        let moved = (flow.speed(stage) - flow.speed(stage + 1)).times(self.per_width);
        let target = S::ONE.along(moved);
        keep(all, self.slot, Relaxation { reach: moved.abs(), target });
    }
}

#[cfg(test)]
mod tests {
    use super::super::hooks::MEMORIES;
    use super::*;

    #[test]
    fn its_rate_is_the_equation() {
        let (width, speed) = (0.02, -0.3);
        let law = StructuralHysteresis::<f64>::new(0, 1, &[0.5, width], [1.0, 1.0, 1.0]);
        let bent = 0.4;
        let mut all = [None; MEMORIES];
        law.relax(&Flow { current: 0.0, drive: 0.0, speeds: &[speed, 0.0] }, &mut all);
        let [None, Some(Relaxation { reach, target }), ..] = all else { panic!("{all:?}") };
        let rate = reach * (target - bent) * width;
        assert!((rate - (speed - speed.abs() * bent)).abs() < 1e-12);
    }
}
