//! A sensor behind a first-order low-pass: the filter of a current's report, of an encoder's chip.
//!
//! It shows y with `τ y' = x − y`. For a current the memory is y itself. An angle has no bounds, so an
//! encoder's memory is the filtered speed w, `τ w' = ω − w`, and it shows `q − τ w`, the same y. Against
//! motion slow beside 1/τ it is a [`sensor_delay`](super::sensor_delay) of τ; only what is faster tells
//! them apart. Where the current is the input, what acts is the filter's inverse, `y + τ y'`: whoever
//! has the record undoes it there, and a drive takes its command as it is. Source: any textbook on
//! control; drives report a filtered current (ODrive, `I_measured_report_filter_k`).

use super::hooks::{Effects, Flow, Memory, Relaxation, Relaxations, keep};
use super::sensor_delay::lag_rad;
use super::{EffectParameters, Kind, ParameterSpec, Place, Spec};
use crate::angle::Angle;
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "sensor-lag",
    locations: &[Location::CurrentSensor, Location::Encoder, Location::OutputEncoder],
    // τ.
    parameters: &[ParameterSpec { key: "time_constant_s", default: None, low: 1e-9, high: 1e3 }],
    example: (Location::Encoder, &[("time_constant_s", 4e-4)]),
    table: None,
    remembers: true,
};

/// Time constant of the filter that these effects put behind a sensor, s; zero where there is none.
pub fn time_constant_s(effects: &[EffectParameters], sensor: Location) -> f64 {
    let own =
        |effect: &&EffectParameters| effect.kind == Kind::SensorLag && effect.location == sensor;
    effects.iter().find(own).map_or(0.0, |effect| effect.values[0])
}

/// What is filtered, by the sensor's place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
enum Filtered {
    Current,
    Motor,
    Output,
}

/// The law for one sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct SensorLag<S: Scalar> {
    slot: u8,
    mass: u8,
    filtered: Filtered,
    turns: S::Gain,
    reach: S,
}

batch!(SensorLag<Scalar>: turns, reach; slot, mass, filtered);

impl<S: Scalar> SensorLag<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        let constant = place.values.first().copied()?;
        let filtered = match place.location {
            Location::CurrentSensor => Filtered::Current,
            Location::OutputEncoder => Filtered::Output,
            _ => Filtered::Motor,
        };
        Some(Self {
            slot: place.slot,
            mass: place.mass,
            filtered,
            turns: S::gain(lag_rad(constant, place.speed) / core::f64::consts::TAU),
            reach: S::from_f64(place.half_step / constant),
        })
    }

    fn remembered(&self, memory: &Memory<S>) -> S {
        memory.get(usize::from(self.slot)).copied().unwrap_or(S::ZERO)
    }
}

impl<S: Scalar> Effects<S> for SensorLag<S> {
    fn has_memory(&self) -> bool {
        true
    }

    #[inline(always)]
    fn lagged_current(&self, current: S, memory: &Memory<S>) -> S {
        if self.filtered == Filtered::Current { self.remembered(memory) } else { current }
    }

    #[inline(always)]
    fn encoder_error(&self, output: bool, _: Angle<S>, _: S, memory: &Memory<S>) -> S {
        let own = if output { Filtered::Output } else { Filtered::Motor };
        if self.filtered == own { self.remembered(memory).times(self.turns) } else { S::ZERO }
    }

    #[inline(always)]
    fn relax(&self, flow: &Flow<'_, S>, all: &mut Relaxations<S>) {
        let target = match self.filtered {
            Filtered::Current => flow.current,
            Filtered::Motor | Filtered::Output => flow.speed(usize::from(self.mass)),
        };
        keep(all, self.slot, Relaxation { reach: self.reach, target });
    }
}

#[cfg(test)]
mod tests {
    use super::super::EffectSet;
    use super::super::hooks::MEMORIES;
    use super::*;
    use crate::params::{Load, Motor, Stage};
    use crate::per_unit::Bases;

    fn laws(location: Location, constant: f64) -> EffectSet<f64> {
        let stages = [Stage { reduction: 8.0, ..Stage::default() }];
        let motor = Motor { torque_constant_nm_per_a: 1.0, ..Motor::default() };
        let lag = EffectParameters::new(Kind::SensorLag, location);
        let lag = lag.with("time_constant_s", constant);
        EffectSet::new(&[lag], &Load::default(), &Bases::si(&motor, &stages)).unwrap()
    }

    /// What is remembered after half a second of the same motion.
    fn followed(laws: &EffectSet<f64>, flow: &Flow<'_, f64>) -> Memory<f64> {
        let (mut memory, steps) = ([0.0; MEMORIES], 100_000);
        for _ in 0..steps {
            let mut all = [None; MEMORIES];
            laws.relax(flow, &mut all);
            let Some(Relaxation { reach, target }) = all[0] else { panic!("its own slot") };
            memory[0] += (target - memory[0]) * reach * 0.5 / f64::from(steps);
        }
        memory
    }

    #[test]
    fn the_shown_current_is_the_filters_answer_to_a_step() {
        let laws = laws(Location::CurrentSensor, 0.2);
        let memory = followed(&laws, &Flow { current: 3.0, drive: 0.0, speeds: &[9.0] });
        // 1 - exp(-2.5); a hundred thousand Euler steps are right to 1e-4.
        let shown = laws.shown_current(3.0, &memory);
        assert!((shown - 3.0 * 0.917_915).abs() < 3e-4, "{shown}");
        assert_eq!(laws.encoder_error(false, Angle::default(), 9.0, &memory), 0.0);
    }

    #[test]
    fn an_encoder_shows_the_filters_answer_to_a_ramp() {
        let laws = laws(Location::OutputEncoder, 0.2);
        // At 8 rad/s of the motor the output turns at 1 rad/s; the filter's answer to the ramp t is
        // t - tau (1 - exp(-t/tau)).
        let memory = followed(&laws, &Flow { current: 0.0, drive: 0.0, speeds: &[80.0, 8.0] });
        let error = |output| laws.encoder_error(output, Angle::default(), 8.0, &memory);
        let shown = error(true) * core::f64::consts::TAU;
        assert!((shown + 0.2 * 0.917_915).abs() < 3e-5, "{shown}");
        assert_eq!((error(false), laws.shown_current(3.0, &memory)), (0.0, 3.0));
    }

    #[test]
    fn the_time_constant_is_that_of_the_sensor_s_own_filter() {
        let lag = |location, tau| {
            EffectParameters::new(Kind::SensorLag, location).with("time_constant_s", tau)
        };
        let effects = [
            EffectParameters::new(Kind::SensorDelay, Location::Encoder).with("delay_s", 9.0),
            lag(Location::CurrentSensor, 2.0),
            lag(Location::Encoder, 3.0),
        ];
        let sensors = [Location::Encoder, Location::CurrentSensor, Location::OutputEncoder];
        assert_eq!(sensors.map(|it| time_constant_s(&effects, it)), [3.0, 2.0, 0.0]);
    }
}
