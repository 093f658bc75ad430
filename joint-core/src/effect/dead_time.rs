//! Inverter dead time: a voltage V is lost against the current's sign.
//!
//! `u ↦ u − V tanh(i / i_s)`; the softening i_s is where the switching ripple makes the current
//! cross zero within a period. Near zero current the loss acts like a resistance V/i_s, which may
//! be far stiffer than the step, so the law is asked for the current without loss and for how much
//! of a held drop is missing from it at the end of the interval, and solves for the current that
//! fits both. Source: Jeong and Park, "The analysis and compensation of dead-time effects in PWM
//! inverters" (1991).

use super::hooks::{Effects, Memory, Winding};
use super::{ParameterSpec, Place, Spec};
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "dead-time",
    locations: &[Location::Inverter],
    parameters: &[
        ParameterSpec { key: "voltage_v", default: None, low: 0.0, high: 1e4 },
        // i_s; zero is a sharp sign.
        ParameterSpec { key: "softening_a", default: Some(0.0), low: 0.0, high: 1e4 },
    ],
    example: (Location::Inverter, &[("voltage_v", 0.15), ("softening_a", 3e-3)]),
    table: None,
    remembers: false,
};

/// The law, with voltages as shares of 2R, that is in units of current.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct DeadTime<S: Scalar> {
    drop: S,
    softening: S,
    per_softening: S::Gain,
}

batch!(DeadTime<Scalar>: drop, softening, per_softening);

impl<S: Scalar> DeadTime<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.values, place.resistance, place.current))
    }

    /// From the values of [`SPEC`], the winding's 2R in ohm and the unit of current in A.
    pub fn new(values: &[f64], resistance: f64, current: f64) -> Self {
        let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
        let drop = if resistance > 0.0 { value(0) / (resistance * current) } else { 0.0 };
        // A softening below a thousandth of the drop is a sharp sign for every purpose.
        let softening = (value(1) / current).max(1e-3 * drop).max(1e-12);
        Self {
            drop: S::from_f64(drop),
            softening: S::from_f64(softening),
            per_softening: S::gain(1.0 / softening),
        }
    }

    #[inline(always)]
    fn drop(&self, current: S, per_drop: S) -> S {
        let lost = self.drop * per_drop;
        if !S::anywhere(S::ZERO.below(lost)) {
            return self.drop * current.times(self.per_softening).tanh();
        }
        // i + lost·sat(i/i_s) = current has this solution; one step of Halley's method brings tanh in.
        let reach = lost + self.softening;
        let within = current.abs().below(reach);
        let share = S::choose(within, current, S::ZERO).ratio(reach);
        let share = S::choose(within, share, S::ONE.along(current));
        let flowing = current - lost * share;
        let bent = flowing.times(self.per_softening).tanh();
        let steepness = lost.times(self.per_softening) * (S::ONE - bent * bent);
        let (off, slope) = (flowing + lost * bent - current, S::ONE + steepness);
        let curved = off.times(self.per_softening) * bent * steepness.over(slope);
        self.drop * (flowing - off.over(slope + curved)).times(self.per_softening).tanh()
    }
}

impl<S: Scalar> Effects<S> for DeadTime<S> {
    fn has_drops(&self) -> bool {
        true
    }

    #[inline(always)]
    fn voltage_drop(&self, at: Winding<S>, _memory: &Memory<S>) -> S {
        self.drop(at.current, at.per_drop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_no_sensitivity_it_is_the_equation() {
        let law = DeadTime::<f64>::new(&[0.5, 0.02], 2.0, 1.0);
        for current in [-1.0, -0.01, 0.0, 0.015, 2.0] {
            assert!((law.drop(current, 0.0) - 0.25 * (current / 0.02_f64).tanh()).abs() < 1e-9);
        }
    }

    #[test]
    fn a_stiff_drop_is_solved_to_a_fiftieth_of_itself_at_every_current() {
        let law = DeadTime::<f64>::new(&[0.5, 0.02], 2.0, 1.0);
        for k in -100..=100 {
            let current = 0.01 * f64::from(k);
            let drop = law.drop(current, 0.9);
            let flowing = current - 0.9 * drop;
            let exact = 0.25 * (flowing / 0.02).tanh();
            assert!((drop - exact).abs() < 0.005, "{current}: {drop} against {exact}");
        }
    }
}
