//! A sensor behind a first-order low-pass: the filter of a current's report, of an encoder's chip.
//!
//! It shows `y + λ y'` with `τ y' = x − y`, that is x behind (1 + λ s)/(1 + τ s). The lead λ is how far the
//! report is ahead of the filter: a digital filter, `y ← y + α (x − y)` with the newest x, is ahead of the
//! continuous one of its time constant by half its period, and behind it if what it shows is a period old.
//! For a current the memory is y itself. An angle has no bounds, so an encoder's memory is the filtered speed
//! w, `τ w' = ω − w`, and it shows `q − (τ − λ) w`, the same. Against motion slow beside 1/τ it is a
//! [`sensor_delay`](super::sensor_delay) of τ − λ; only what is faster tells them apart. Where the current is
//! the input, what acts is the filter's inverse, `y + τ y'`, λ later: whoever has the record undoes it
//! there, and a drive takes its command as it is. Source: Oppenheim, Schafer, Discrete-Time Signal Processing
//! (2009), impulse invariance; drives report a filtered current (ODrive, `I_measured_report_filter_k`).

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
    parameters: &[
        // τ.
        ParameterSpec { key: "time_constant_s", default: None, low: 1e-9, high: 1e3 },
        // λ, of which no more than τ counts.
        ParameterSpec { key: "lead_s", default: Some(0.0), low: -1e3, high: 1e3 },
    ],
    example: (Location::Encoder, &[("time_constant_s", 4e-4), ("lead_s", 5e-5)]),
    table: None,
    remembers: true,
};

/// Time constant of the filter that these effects put behind a sensor, s; zero where there is none.
pub fn time_constant_s(effects: &[EffectParameters], sensor: Location) -> f64 {
    own(effects, sensor).map_or(0.0, |effect| effect.values[0])
}

/// How far what a sensor shows is ahead of its filter, s; zero where these effects have none.
pub fn lead_s(effects: &[EffectParameters], sensor: Location) -> f64 {
    own(effects, sensor).map_or(0.0, |effect| lead(&effect.values))
}

fn own(effects: &[EffectParameters], sensor: Location) -> Option<&EffectParameters> {
    effects.iter().find(|own| own.kind == Kind::SensorLag && own.location == sensor)
}

/// λ of these values.
fn lead(values: &[f64]) -> f64 {
    match *values {
        [constant, lead, ..] => lead.max(-constant).min(constant),
        _ => 0.0,
    }
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
    /// λ/τ.
    ahead: S,
}

batch!(SensorLag<Scalar>: turns, reach, ahead; slot, mass, filtered);

impl<S: Scalar> SensorLag<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        let constant = place.values.first().copied()?;
        let lead = lead(place.values);
        let filtered = match place.location {
            Location::CurrentSensor => Filtered::Current,
            Location::OutputEncoder => Filtered::Output,
            _ => Filtered::Motor,
        };
        Some(Self {
            slot: place.slot,
            mass: place.mass,
            filtered,
            turns: S::gain(lag_rad(constant - lead, place.speed) / core::f64::consts::TAU),
            reach: S::from_f64(place.half_step / constant),
            ahead: S::from_f64(lead / constant),
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
        if self.filtered != Filtered::Current {
            return current;
        }
        let filtered = self.remembered(memory);
        filtered + (current - filtered) * self.ahead
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
    fn a_lead_shows_its_share_at_once_and_no_more_than_all() {
        let with = |location, lead: f64| {
            let lag = EffectParameters::new(Kind::SensorLag, location);
            let lag = lag.with("time_constant_s", 0.2).with("lead_s", lead);
            let stages = [Stage { reduction: 8.0, ..Stage::default() }];
            let motor = Motor { torque_constant_nm_per_a: 1.0, ..Motor::default() };
            let bases = Bases::si(&motor, &stages);
            (EffectSet::<f64>::new(&[lag], &Load::default(), &bases).unwrap(), lag)
        };
        let memory = [1.0; MEMORIES];
        for (lead, at_once) in [(0.05, 0.25), (-0.1, -0.5), (9.0, 1.0)] {
            let (current, lag) = with(Location::CurrentSensor, lead);
            let shown = current.shown_current(3.0, &memory);
            assert!((shown - (1.0 + 2.0 * at_once)).abs() < 1e-12, "{lead}: {shown}");
            let sensor = Location::CurrentSensor;
            assert!((lead_s(&[lag], sensor) - 0.2 * at_once).abs() < 1e-12);
            // An encoder is behind an even motion by what the lead leaves.
            let (encoder, _) = with(Location::Encoder, lead);
            let error = encoder.encoder_error(false, Angle::default(), 1.0, &memory);
            let behind = 0.2 * (1.0 - at_once);
            assert!((error * core::f64::consts::TAU + behind).abs() < 1e-12, "{lead}: {error}");
        }
        assert_eq!(lead_s(&[], Location::Encoder), 0.0);
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
