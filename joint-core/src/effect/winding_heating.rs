//! A winding that warms: its resistance rises with the square of the current it has carried.
//!
//! `R (1 + a Θ)` with `τ Θ' = (i/I_ref)² − Θ`, cold at the start: one thermal mass. Source: the
//! thermal model of any servo motor's data sheet; copper gains 0.39 % per kelvin.

use super::hooks::{Effects, Flow, Memory, Relaxation, Relaxations, Winding, keep};
use super::{ParameterSpec, Place, Spec};
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "winding-heating",
    locations: &[Location::Motor],
    parameters: &[
        // a: rise of the resistance after long at the reference current.
        ParameterSpec { key: "relative_rise", default: None, low: 0.0, high: 1e3 },
        ParameterSpec { key: "time_constant_s", default: None, low: 1e-6, high: 1e9 },
        ParameterSpec { key: "reference_current_a", default: None, low: 1e-12, high: 1e12 },
    ],
    example: (
        Location::Motor,
        &[("relative_rise", 0.25), ("time_constant_s", 0.05), ("reference_current_a", 0.07)],
    ),
    table: None,
    remembers: true,
};

/// The law.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct WindingHeating<S: Scalar> {
    slot: u8,
    rise: S::Gain,
    per_current: S::Gain,
    reach: S,
}

batch!(WindingHeating<Scalar>: rise, per_current, reach; slot);

impl<S: Scalar> WindingHeating<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.slot, place.values, place.current, place.half_step))
    }

    /// From the values of [`SPEC`], the unit of current in A and half a micro-step in s.
    pub fn new(slot: u8, values: &[f64], current: f64, half_step: f64) -> Self {
        let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
        Self {
            slot,
            rise: S::gain(value(0)),
            per_current: S::gain(current / value(2)),
            reach: S::from_f64(half_step / value(1)),
        }
    }
}

impl<S: Scalar> Effects<S> for WindingHeating<S> {
    fn has_drops(&self) -> bool {
        true
    }

    fn has_memory(&self) -> bool {
        true
    }

    #[inline(always)]
    fn voltage_drop(&self, at: Winding<S>, memory: &Memory<S>) -> S {
        let warm = memory.get(usize::from(self.slot)).copied().unwrap_or(S::ZERO);
        at.drop_of(warm.times(self.rise))
    }

    #[inline(always)]
    fn relax(&self, flow: &Flow<'_, S>, all: &mut Relaxations<S>) {
        let load = flow.current.times(self.per_current);
        keep(all, self.slot, Relaxation { reach: self.reach, target: load * load });
    }
}

#[cfg(test)]
mod tests {
    use super::super::hooks::MEMORIES;
    use super::*;

    #[test]
    fn at_the_reference_current_it_tends_to_one() {
        let law = WindingHeating::<f64>::new(0, &[0.25, 0.5, 4.0], 2.0, 1.0);
        let mut all = [None; MEMORIES];
        law.relax(&Flow { current: -2.0, drive: 0.0, speeds: &[] }, &mut all);
        assert_eq!(all[0], Some(Relaxation { reach: 2.0, target: 1.0 }));
        let at = Winding { current: 3.0, per_drop: 0.0, drive: 0.0 };
        assert!((law.voltage_drop(at, &[1.0; 4]) - 0.75).abs() < 1e-12);
    }
}
