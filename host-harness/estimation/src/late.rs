//! Channels that are late, put back to when they were true.
//!
//! A measurement that shows the past belongs to a past state. Shifted by whole samples it is taken
//! there at once; what is left is less than half a sample, which the encoder's law covers with the
//! speed. A current has no speed that is known so well: what is left of its delay is a share of the way from the sample
//! before to this one, over which the drive holds its voltage, so that the filter keeps the sample before as a state
//! ([`Equation::CurrentBefore`](crate::filter::Equation::CurrentBefore)).
//!
//! What acts on the joint is not always what its log says at that sample either ([`joint_simulation::acting`]).

use std::borrow::Cow;

use joint_core::effect::sensor_delay::delay_s;
use joint_core::joint::Drive;
use joint_core::params::Location;

use super::record::{CHANNELS, Channel, Record};
use joint_simulation::acting::{acts_late_s, filtered_s, switch, switched, unfiltered};
use joint_simulation::encoders::current_reached;
use joint_simulation::model::Model;

/// A record's measurements by the sample at which they were true.
#[derive(Clone, Debug)]
pub struct Late<'a> {
    /// Measurements; NaN where the shift leaves none.
    pub measured: Cow<'a, [[f64; CHANNELS]]>,
    /// Time by which an encoder's measurement is ahead of its sample's state, without the delay itself: what the shift
    /// has undone, s.
    pub by: [f64; CHANNELS],
    /// Share of the current of the sample before in what is shown of one that is late by parts of a sample.
    pub before: f64,
    /// The same in samples.
    pub samples: [isize; CHANNELS],
    /// By sample: what acts over the interval after it, before and after the drive switches; empty where
    /// that is the record's own value.
    drives: Vec<[f64; 2]>,
}

impl<'a> Late<'a> {
    /// Of a record, by the delays of a model.
    pub fn of(model: &Model, record: &'a Record) -> Self {
        let mut late = Self {
            measured: Cow::Borrowed(&record.measured),
            by: [0.0; CHANNELS],
            before: 0.0,
            samples: [0; CHANNELS],
            drives: drives(model, record),
        };
        let interval = record.grid.typical_interval();
        let current = current_late_s(model, record);
        let part = part_of_a_sample(current, interval);
        if part > 0.0 {
            late.before = 1.0 - current_reached(&model.motor, (1.0 - part) * interval, interval);
        }
        for (channel, delay) in [
            (Channel::Current, current - part * interval),
            (Channel::Motor, delay_s(&model.effects, Location::Encoder)),
            (Channel::Output, delay_s(&model.effects, Location::OutputEncoder)),
        ] {
            let c = channel as usize;
            let samples = (delay / interval).round();
            let samples = if samples.abs() < record.len() as f64 { samples } else { 0.0 };
            if channel != Channel::Current {
                late.by[c] = samples * interval;
            }
            if samples != 0.0 {
                late.samples[c] = samples as isize;
                shift(late.measured.to_mut(), record, c, samples as isize);
            }
        }
        late
    }
}

impl Late<'_> {
    /// What acts over the interval after sample `k` of a record, before and after the drive switches.
    #[inline(always)]
    pub(super) fn drives(&self, record: &Record, k: usize) -> [f64; 2] {
        self.drives.get(k).copied().unwrap_or_else(|| [record.drive_values[k]; 2])
    }
}

/// How late a record shows the current beside the voltage that drives the joint, s; one that is the input is late by what
/// acts.
fn current_late_s(model: &Model, record: &Record) -> f64 {
    match record.drive {
        Drive::Voltage if record.has(Channel::Current) => model.sensor.current_delay_s,
        _ => 0.0,
    }
}

/// What a delay is beyond whole samples, as a share of one.
fn part_of_a_sample(delay_s: f64, interval: f64) -> f64 {
    let samples = delay_s / interval;
    // What is less than a file's digits is rounding.
    let part = samples - (samples + 1e-6).floor();
    if part > 1e-6 { part } else { 0.0 }
}

/// Whether a record shows the current late by parts of a sample.
pub fn is_between_samples(model: &Model, record: &Record) -> bool {
    part_of_a_sample(current_late_s(model, record), record.grid.typical_interval()) > 0.0
}

/// What acts where that is not the record's own values; a joint's past ends where its log begins.
fn drives(model: &Model, record: &Record) -> Vec<[f64; 2]> {
    let (constant, delay) =
        (filtered_s(model, record.drive), acts_late_s(model, &record.grid, record.drive));
    if constant == 0.0 && delay == 0.0 {
        return Vec::new();
    }
    let share = switch(delay, record.grid.typical_interval());
    let ends = record.starts.iter().skip(1).copied().chain([record.len()]);
    let logs = record.starts.iter().zip(ends).map(|(start, end)| *start..end);
    logs.flat_map(|log| {
        let (time_s, shown) = (&record.time_s[log.clone()], &record.drive_values[log]);
        let values = match constant > 0.0 {
            true => Cow::Owned(unfiltered(shown, time_s, constant)),
            false => Cow::Borrowed(shown),
        };
        match delay == 0.0 {
            true => values.iter().map(|value| [*value; 2]).collect(),
            false => switched(&values, time_s, delay, share),
        }
    })
    .collect()
}

/// Moves a channel towards the start of each of its logs.
fn shift(measured: &mut [[f64; CHANNELS]], record: &Record, c: usize, samples: isize) {
    for (number, start) in record.starts.iter().enumerate() {
        let end = record.starts.get(number + 1).copied().unwrap_or(record.len());
        for (k, row) in measured.iter_mut().enumerate().take(end).skip(*start) {
            let from = k.checked_add_signed(samples).filter(|from| (*start..end).contains(from));
            row[c] = from.map_or(f64::NAN, |from| record.measured[from][c]);
        }
    }
}

#[cfg(test)]
mod tests {
    use joint_core::effect::{EffectParameters, Kind};

    use super::*;
    use crate::filter::Observer;
    use crate::fit::Problem;
    use crate::noise::expected;
    use joint_simulation::demo::actuator;
    use joint_simulation::log::Log;
    use joint_simulation::plant::{Inputs, Layout, ScalarKind, plant, simulate};

    #[test]
    fn a_measured_current_acts_around_its_sample_and_one_that_acts_late_around_later() {
        let mut model = actuator();
        let log = Log {
            time_s: (0..4).map(|k| f64::from(k) * 1e-3).collect(),
            current_a: Some(vec![1.0, 2.0, 3.0, 4.0]),
            motor_angle_rad: vec![0.0; 4],
            ..Log::default()
        };
        let record = Record::new(&log, None);
        let drives = |model: &Model, record: &Record| Late::of(model, record).drives(record, 1);
        assert_eq!(drives(&model, &record), [2.0, 2.0]);
        assert_eq!(drives(&model, &record.centred()), [2.0, 3.0]);
        assert_eq!(drives(&model, &record.centred().commanded()), [2.0, 2.0]);
        let late = EffectParameters::new(Kind::InputDelay, Location::Inverter);
        model.effects.push(late.with("delay_s", 0.75e-3));
        // A quarter of an interval late in all.
        let [before, after] = drives(&model, &record.centred());
        assert!((before - 1.0).abs() + (after - 2.0).abs() < 1e-9, "{before} {after}");
    }

    #[test]
    fn a_current_that_a_log_shows_late_is_taken_to_when_it_flowed_and_an_input_is_not() {
        let mut model = actuator();
        model.sensor.current_delay_s = 2e-3;
        let mut log = Log {
            time_s: (0..4).map(|k| f64::from(k) * 1e-3).collect(),
            voltage_v: Some(vec![0.5; 4]),
            current_a: Some(vec![1.0, 2.0, 3.0, 4.0]),
            motor_angle_rad: vec![0.0, 1.0, 2.0, 3.0],
            ..Log::default()
        };
        let shown = |log: &Log| {
            let record = Record::new(log, None);
            let late = Late::of(&model, &record);
            late.measured.iter().map(|row| (row[0], row[1])).collect::<Vec<_>>()
        };
        assert_eq!(shown(&log)[..2], [(3.0, 0.0), (4.0, 1.0)]);
        assert!(shown(&log)[2].0.is_nan() && shown(&log)[2].1 == 2.0);
        log.voltage_v = None;
        assert_eq!(Late::of(&model, &Record::new(&log, None)).samples, [0; CHANNELS]);
    }

    #[test]
    fn a_current_that_is_late_by_parts_of_a_sample_is_likeliest_with_that_delay() {
        let truth = actuator();
        let (interval, parts) = (1e-3, 3);
        // A voltage that is held over an interval, and the joint at its thirds: the current is taken a third before.
        let volts = |k: usize| 0.5 * ((k * 7919) % 13) as f64 - 3.0;
        let count = 400 * parts;
        let inputs = Inputs {
            time_s: (0..count).map(|k| k as f64 * interval / parts as f64).collect(),
            drive: Drive::Voltage,
            drive_values: (0..count).map(|k| volts(k / parts)).collect(),
            load_nm: vec![0.0; count],
        };
        let run = simulate(&truth, &inputs, ScalarKind::F64, None, Some(2)).unwrap();
        let rows = || (1..400).map(|k| parts * k);
        let slow = Log {
            time_s: rows().map(|k| inputs.time_s[k]).collect(),
            voltage_v: Some(rows().map(|k| inputs.drive_values[k]).collect()),
            current_a: Some(rows().map(|k| run[k - 1].measured_current_a).collect()),
            motor_angle_rad: rows().map(|k| run[k].motor_angle_rad).collect(),
            ..Log::default()
        };
        let record = Record::new(&slow, Some(6));
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask);
        let deviance = |samples: f64| {
            let mut model = truth.clone();
            model.sensor.current_delay_s = samples * interval;
            problem.deviance_along(&Default::default(), &model, &expected(&model, &record)).unwrap()
        };
        let found = [0.0, 0.2, 1.0 / 3.0, 0.5, 1.0].map(deviance);
        assert!(found.iter().all(|other| found[2] <= *other), "{found:?}");
        assert!(found[0] > found[2] + 100.0 && found[1] > found[2] + 10.0, "{found:?}");
    }

    #[test]
    fn a_filter_knows_that_a_late_channel_shows_the_speed() {
        let mut model = actuator();
        let late = EffectParameters::new(Kind::SensorDelay, Location::OutputEncoder);
        // A whole sample is shifted, what is left of it shows the speed.
        model.effects.push(late.with("delay_s", 1.3e-3));
        let log = Log {
            time_s: (0..300).map(|k| f64::from(k) * 1e-3).collect(),
            current_a: Some(vec![0.1; 300]),
            motor_angle_rad: vec![0.0; 300],
            output_angle_rad: Some(vec![0.0; 300]),
            ..Log::default()
        };
        let record = Record::new(&log, None);
        let plant = plant(&model, &record.grid, record.drive).unwrap();
        let observer = Observer::new(&model, &*plant, &record);
        let layout = Layout::of(&model);
        let mut row = vec![0.0; layout.len()];
        let shown = |channel, state: usize, value: f64| {
            let mut x = vec![0.0; layout.len()];
            x[state] = value;
            observer.shown(channel, &x, &[])
        };
        let (channel, speed) = (Channel::Output, layout.speed(layout.stages));
        observer.sensitivity(channel, &[], &mut row);
        let slope = shown(channel, speed, 1.0) - shown(channel, speed, 0.0);
        assert!(slope != 0.0 && (row[speed] - slope).abs() < 1e-12, "{slope}");
    }
}
