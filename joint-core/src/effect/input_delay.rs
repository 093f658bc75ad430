//! A drive that acts late: its voltage or current is put on `d` seconds after its stamp, `u(t − d)`.
//!
//! The update of a PWM period, a bus between command and current loop, the loop itself. Whoever has the
//! record takes the input of then, whatever part of a sample or number of them the delay is. A drive keeps
//! no past: its step follows the voltage by a first-order lag of the same delay, `d u' = u_k − u`, which is
//! late by as much for all that is slow beside 1/d, and leaves an imposed current alone. Source: Bae and
//! Sul, "A compensation method for time delay of full-digital synchronous frame current regulator of PWM
//! AC drives" (2003).

use super::hooks::{Effects, Flow, Memory, Relaxation, Relaxations, Winding, keep};
use super::{EffectParameters, Kind, ParameterSpec, Place, Spec};
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "input-delay",
    locations: &[Location::Inverter],
    // d; one that acts ahead of its stamp is no delay, but a fit may pass there.
    parameters: &[ParameterSpec { key: "delay_s", default: None, low: -1.0, high: 1.0 }],
    example: (Location::Inverter, &[("delay_s", 1e-4)]),
    table: None,
    remembers: true,
};

/// How late these effects make the input, s.
pub fn delay_s(effects: &[EffectParameters]) -> f64 {
    let own = |effect: &&EffectParameters| effect.kind == Kind::InputDelay;
    effects.iter().filter(own).map(|effect| effect.values[0]).sum()
}

/// The law of the step, with voltages as shares of 2R, that is in units of current.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct InputDelay<S: Scalar> {
    slot: u8,
    reach: S,
}

batch!(InputDelay<Scalar>: reach; slot);

/// Shortest time constant of the step's lag, s.
const SHORTEST_S: f64 = 1e-9;

impl<S: Scalar> InputDelay<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        let delay = place.values.first().copied()?.max(SHORTEST_S);
        Some(Self { slot: place.slot, reach: S::from_f64(place.half_step / delay) })
    }
}

impl<S: Scalar> Effects<S> for InputDelay<S> {
    fn has_drops(&self) -> bool {
        true
    }

    fn has_memory(&self) -> bool {
        true
    }

    #[inline(always)]
    fn voltage_drop(&self, at: Winding<S>, memory: &Memory<S>) -> S {
        at.drive - memory.get(usize::from(self.slot)).copied().unwrap_or(at.drive)
    }

    #[inline(always)]
    fn relax(&self, flow: &Flow<'_, S>, all: &mut Relaxations<S>) {
        keep(all, self.slot, Relaxation { reach: self.reach, target: flow.drive });
    }
}

#[cfg(test)]
mod tests {
    use super::super::EffectSet;
    use super::super::hooks::MEMORIES;
    use super::*;
    use crate::params::{Load, Motor};
    use crate::per_unit::Bases;

    #[test]
    fn the_voltage_of_the_step_is_the_filters_answer_to_a_ramp() {
        let motor =
            Motor { torque_constant_nm_per_a: 1.0, phase_resistance_ohm: 0.5, ..Motor::default() };
        let delay = EffectParameters::new(Kind::InputDelay, Location::Inverter);
        let delay = [delay.with("delay_s", 0.05)];
        let laws = EffectSet::new(&delay, &Load::default(), &Bases::si(&motor, &[])).unwrap();
        let (mut memory, steps) = ([0.0; MEMORIES], 100_000);
        for k in 0..steps {
            let flow = Flow { current: 0.0, drive: f64::from(k) / f64::from(steps), speeds: &[] };
            let mut all = [None; MEMORIES];
            laws.relax(&flow, &mut all);
            let Some(Relaxation { reach, target }) = all[0] else { panic!("its own slot") };
            memory[0] += (target - memory[0]) * reach / f64::from(steps);
        }
        // A ramp of 1 V/s is late by the delay, 0.05 V, once exp(-t/d) is over.
        let at = Winding { current: 0.3, per_drop: 0.0, drive: 1.0 };
        assert!((laws.voltage_drop(at, &memory) - 0.05).abs() < 1e-4);
        assert_eq!(delay_s(&delay), 0.05);
    }
}
