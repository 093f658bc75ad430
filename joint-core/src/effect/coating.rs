//! A coating at the joint: an elastic skin that is bent with the output and gives some of it back
//! late.
//!
//! Torque on the output `−(k q + k3 q³ + h ζ/w)`, with `ζ' = ω − |ω| ζ/w`: elastic, cubic, and a
//! relaxation loop of height h and width w. Source: the paper's coating block; form of the loop
//! after Dahl.

use super::hooks::{Effects, Flow, Memory, Motion, Relaxation, Relaxations, Torque, keep};
use super::{ParameterSpec, Place, Spec};
use crate::angle::Ratio;
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "coating",
    locations: &[Location::Output],
    parameters: &[
        ParameterSpec { key: "stiffness_nm_per_rad", default: None, low: 0.0, high: 1e12 },
        ParameterSpec { key: "hysteresis_nm", default: Some(0.0), low: 0.0, high: 1e9 },
        // w.
        ParameterSpec { key: "width_rad", default: Some(0.02), low: 1e-9, high: 1e3 },
        ParameterSpec {
            key: "cubic_stiffness_nm_per_rad3",
            default: Some(0.0),
            low: -1e12,
            high: 1e12,
        },
    ],
    example: (
        Location::Output,
        &[
            ("stiffness_nm_per_rad", 0.06),
            ("hysteresis_nm", 6e-3),
            ("cubic_stiffness_nm_per_rad3", 0.1),
        ],
    ),
    table: None,
    remembers: true,
};

/// The law.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct Coating<S: Scalar> {
    mass: u8,
    slot: u8,
    shaft: Ratio<S>,
    linear: S::Gain,
    cubic: S::Gain,
    loop_height: S,
    slope: S::Gain,
    cubic_slope: S::Gain,
    loop_slope: S::Gain,
    per_width: S::Gain,
}

batch!(Coating<Scalar>: shaft, linear, cubic, loop_height, slope, cubic_slope, loop_slope, per_width; mass, slot);

impl<S: Scalar> Coating<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.mass, place.slot, place.values, place.shaft, place.own()))
    }

    /// From the values of [`SPEC`], with the output's ratio to the motor, the units of torque (Nm) and
    /// angle (rad) there, and how far a unit of speed moves in half a micro-step, rad there.
    pub fn new(
        mass: u8,
        slot: u8,
        values: &[f64],
        shaft: f64,
        [torque, angle, moved]: [f64; 3],
    ) -> Self {
        let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
        let turn = core::f64::consts::TAU;
        let (linear, cubic) = (value(0) / torque, value(3) / torque);
        Self {
            mass,
            slot,
            shaft: Ratio::new(shaft),
            linear: S::gain(linear * turn),
            cubic: S::gain(cubic * turn * turn * turn),
            loop_height: S::from_f64(value(1) / libm::fabs(torque)),
            slope: S::gain(linear * angle),
            cubic_slope: S::gain(3.0 * cubic * turn * turn * angle),
            loop_slope: S::gain(libm::fabs(angle) / value(2)),
            per_width: S::gain(libm::fabs(moved) / value(2)),
        }
    }
}

impl<S: Scalar> Effects<S> for Coating<S> {
    fn has_torque(&self, mass: usize) -> bool {
        mass == usize::from(self.mass)
    }

    fn has_memory(&self) -> bool {
        true
    }

    #[inline(always)]
    fn torque(&self, mass: usize, at: Motion<S>, memory: &Memory<S>) -> Torque<S> {
        let bent = match memory.get(usize::from(self.slot)) {
            Some(bent) if mass == usize::from(self.mass) => *bent,
            _ => return Torque::NONE,
        };
        let turns = self.shaft.wide(at.angle);
        let square = turns * turns;
        let value =
            turns.times(self.linear) + (turns * square).times(self.cubic) + self.loop_height * bent;
        let slope = S::ONE.times(self.slope)
            + square.times(self.cubic_slope)
            + (self.loop_height * (S::ONE - bent.abs())).times(self.loop_slope);
        Torque { value: -value, slope: -slope }
    }

    #[inline(always)]
    fn relax(&self, flow: &Flow<'_, S>, all: &mut Relaxations<S>) {
        let moved = flow.speed(usize::from(self.mass)).times(self.per_width);
        let target = S::ONE.along(moved);
        keep(all, self.slot, Relaxation { reach: moved.abs(), target });
    }
}

#[cfg(test)]
mod tests {
    use super::super::hooks::MEMORIES;
    use super::*;
    use crate::angle::Angle;

    #[test]
    fn the_torque_is_the_equation_at_any_number_of_turns() {
        let (k, h, w, k3) = (0.2, 0.1, 0.02, 0.01);
        let law = Coating::<f64>::new(1, 0, &[k, h, w, k3], 1.0, [1.0; 3]);
        let mut memory = [0.0; MEMORIES];
        memory[0] = -0.7;
        for q in [-9.0, -0.4, 0.0, 2.0] {
            let turns = q / core::f64::consts::TAU;
            let at = Motion { angle: Angle::from_turns(turns), speed: 0.0 };
            let torque = law.torque(1, at, &memory);
            assert!((torque.value + k * q + k3 * q * q * q - 0.7 * h).abs() < 1e-9);
            let slope = k + 3.0 * k3 * q * q + 0.3 * h / w;
            assert!((torque.slope + slope).abs() < 1e-9);
        }
    }

    #[test]
    fn its_loop_follows_the_way_over_the_width() {
        let law = Coating::<f64>::new(1, 0, &[0.2, 0.1, 0.5, 0.0], 1.0, [1.0, 1.0, -0.25]);
        for (speed, target) in [(3.0, 1.0), (-3.0, -1.0)] {
            let flow = Flow { current: 0.0, drive: 0.0, speeds: &[9.0, speed] };
            let mut all = [None; MEMORIES];
            law.relax(&flow, &mut all);
            let reach = 3.0 * 0.25 / 0.5;
            assert_eq!(all[0], Some(Relaxation { reach, target }));
        }
    }
}
