//! Lubricant that warms: viscous friction falls with the work it has done.
//!
//! Viscous coefficient times `1 − a Θ`, at least 0.05, with `τ Θ' = (ω/ω_ref)² − Θ`. Source:
//! Bittencourt, Wernholt, Sander-Tavallaey and Brogårdh, "An extended friction model to capture
//! load and temperature effects in robot joints" (2010), reduced to one thermal mass.

use super::hooks::{Effects, Flow, Memory, Relaxation, Relaxations, keep};
use super::{ParameterSpec, Place, Spec};
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Share of the viscous coefficient that is always left.
const LEAST: f64 = 0.05;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "lubricant-warming",
    locations: &[Location::Motor, Location::Stage(0)],
    parameters: &[
        // a: fall of the viscous coefficient after long at the reference speed.
        ParameterSpec { key: "relative_fall", default: None, low: 0.0, high: 1e3 },
        ParameterSpec { key: "time_constant_s", default: None, low: 1e-6, high: 1e9 },
        // Of the mass itself.
        ParameterSpec { key: "reference_speed_rad_per_s", default: None, low: 1e-9, high: 1e9 },
    ],
    example: (
        Location::Motor,
        &[("relative_fall", 0.6), ("time_constant_s", 0.05), ("reference_speed_rad_per_s", 1500.0)],
    ),
    table: None,
    remembers: true,
};

/// The law for one mass.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct LubricantWarming<S: Scalar> {
    mass: u8,
    slot: u8,
    fall: S::Gain,
    per_speed: S::Gain,
    reach: S,
    least: S,
}

batch!(LubricantWarming<Scalar>: fall, per_speed, reach, least; mass, slot);

impl<S: Scalar> LubricantWarming<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.mass, place.slot, place.values, place.speed, place.half_step))
    }

    /// From the values of [`SPEC`], the unit of speed at the mass in rad/s and half a micro-step
    /// in s.
    pub fn new(mass: u8, slot: u8, values: &[f64], speed: f64, half_step: f64) -> Self {
        let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
        Self {
            mass,
            slot,
            fall: S::gain(value(0)),
            per_speed: S::gain(speed / value(2)),
            reach: S::from_f64(half_step / value(1)),
            least: S::from_f64(LEAST),
        }
    }
}

impl<S: Scalar> Effects<S> for LubricantWarming<S> {
    fn has_damping(&self, mass: usize) -> bool {
        mass == usize::from(self.mass)
    }

    fn has_memory(&self) -> bool {
        true
    }

    #[inline(always)]
    fn viscous(&self, mass: usize, _speed: S, memory: &Memory<S>) -> S {
        match memory.get(usize::from(self.slot)) {
            Some(warm) if mass == usize::from(self.mass) => {
                let left = S::ONE - warm.times(self.fall);
                S::choose(left.below(self.least), self.least, left)
            }
            _ => S::ONE,
        }
    }

    #[inline(always)]
    fn relax(&self, flow: &Flow<'_, S>, all: &mut Relaxations<S>) {
        let load = flow.speed(usize::from(self.mass)).times(self.per_speed);
        keep(all, self.slot, Relaxation { reach: self.reach, target: load * load });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn some_viscous_friction_is_always_left() {
        let law = LubricantWarming::<f64>::new(0, 2, &[0.6, 1.0, 10.0], 1.0, 1.0);
        let viscous = |warm| law.viscous(0, 1.0, &[0.0, 0.0, warm, 0.0]);
        assert!((viscous(0.5) - 0.7).abs() < 1e-12);
        assert_eq!(viscous(3.0), LEAST);
        assert_eq!(law.viscous(1, 1.0, &[3.0; 4]), 1.0);
    }

    #[test]
    fn it_warms_by_the_square_of_the_speed() {
        let law = LubricantWarming::<f64>::new(1, 2, &[0.6, 8.0, 10.0], 5.0, 0.5);
        let flow = Flow { current: 0.0, drive: 0.0, speeds: &[9.0, 3.0] };
        let mut all = [None; 4];
        law.relax(&flow, &mut all);
        // Three units of 5 rad/s over 10 rad/s; half a second over eight.
        assert_eq!(all[2], Some(Relaxation { reach: 0.0625, target: 2.25 }));
    }
}
