//! What acts on a joint over each interval, from the inputs that its log has.
//!
//! A log's input is not always what acted: a current's report is filtered, and a drive acts late. A joint
//! that is stepped from row to row keeps no past; the record is the past. The filter is undone there, and
//! an input that acts `d` seconds late, whatever part of an interval or number of them that is, divides an
//! interval where it switches.

use std::borrow::Cow;

use joint_core::effect::input_delay::delay_s;
use joint_core::effect::{EffectParameters, Kind, sensor_lag};
use joint_core::joint::Drive;
use joint_core::params::Location;

use crate::grid::Grid;
use crate::model::Model;

/// What drives a joint over a record: sample `k` is held from `time_s[k]` to `time_s[k + 1]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Inputs {
    /// Sample times, s, rising.
    pub time_s: Vec<f64>,
    /// What the drive imposes.
    pub drive: Drive,
    /// Volts or amperes; not a number where the drive lets go: no current flows then.
    pub drive_values: Vec<f64>,
    /// Load at the output, Nm, positive against positive motion.
    pub load_nm: Vec<f64>,
}

/// Smallest share of an interval that is stepped on its own.
const LEAST: f64 = 1e-3;

/// The time constant of the filter behind which a log shows the current that is its input, s; zero where
/// there is none.
pub fn filtered_s(model: &Model, drive: Drive) -> f64 {
    match drive {
        Drive::Voltage => 0.0,
        Drive::Current => sensor_lag::time_constant_s(&model.effects, Location::CurrentSensor),
    }
}

/// How long after the instant from which a joint is stepped along a grid its sample's input acts, s.
pub fn acts_late_s(model: &Model, grid: &Grid, drive: Drive) -> f64 {
    imposed_late_s(&model.effects, drive) - grid.lead_s
}

/// How long after it is imposed an input acts, s; a current whose report is ahead of its filter acts as much
/// later than the filter undone.
fn imposed_late_s(effects: &[EffectParameters], drive: Drive) -> f64 {
    let ahead = match drive {
        Drive::Voltage => 0.0,
        Drive::Current => sensor_lag::lead_s(effects, Location::CurrentSensor),
    };
    delay_s(effects) + ahead
}

/// Of a filtered series at these times, values held from each to the next that the filter
/// `τ y' = x − y` makes it of: `(y₁ − a y₀)/(1 − a)` with `a = exp(−h/τ)`; what is shown, where the next
/// value is not known.
pub fn unfiltered(shown: &[f64], time_s: &[f64], constant_s: f64) -> Vec<f64> {
    let pairs = shown.windows(2).zip(time_s.windows(2));
    let undone = pairs.map(|(shown, time)| {
        let reached = -(-(time[1] - time[0]) / constant_s).exp_m1();
        let change = shown[1] - shown[0];
        shown[0] + if change.is_nan() { 0.0 } else { change / reached }
    });
    undone.chain(shown.last().copied()).collect()
}

/// The effects that a joint has when it is stepped along a record: what its input was before, the record
/// says.
pub fn stepped(effects: &[EffectParameters]) -> Cow<'_, [EffectParameters]> {
    match effects.iter().any(|effect| effect.kind == Kind::InputDelay) {
        true => effects.iter().filter(|effect| effect.kind != Kind::InputDelay).copied().collect(),
        false => Cow::Borrowed(effects),
    }
}

/// What acts over the interval after sample `k` of these times where every value is held from its sample
/// on and acts `delay_s` later: `each` is told the sample whose value it is, from when and until when. The
/// first value acts before its time too, and what is shorter than can be stepped on its own is left out.
pub fn pieces(time_s: &[f64], k: usize, delay_s: f64, each: impl FnMut(usize, f64, f64)) {
    pieces_from(LEAST, time_s, k, delay_s, each);
}

/// The same without what is shorter than a share of the interval.
fn pieces_from(
    least: f64,
    time_s: &[f64],
    k: usize,
    delay_s: f64,
    mut each: impl FnMut(usize, f64, f64),
) {
    let (Some(&begin), Some(&end)) = (time_s.get(k), time_s.get(k + 1)) else { return };
    let least = least * (end - begin);
    let mut source = time_s.partition_point(|time| time + delay_s <= begin + least).max(1) - 1;
    let mut from = begin;
    while from < end {
        let next = time_s.get(source + 1).map_or(end, |time| time + delay_s);
        let until = if next > end - least { end } else { next };
        each(source, from, until);
        (source, from) = (source + 1, until);
    }
}

/// The share of an interval at which an input that is so late switches.
pub fn switch(delay_s: f64, interval: f64) -> f64 {
    let samples = delay_s / interval;
    (samples - samples.floor()).clamp(LEAST, 1.0 - LEAST)
}

/// By sample of a log: the means of an input that is so late before and after it switches.
pub fn switched(values: &[f64], time_s: &[f64], delay_s: f64, share: f64) -> Vec<[f64; 2]> {
    let mut all: Vec<[f64; 2]> = values.iter().map(|value| [*value; 2]).collect();
    for (k, pair) in time_s.windows(2).enumerate() {
        let interval = pair[1] - pair[0];
        let middle = pair[0] + share * interval;
        let mut sums = [0.0; 2];
        pieces_from(0.0, time_s, k, delay_s, |source, from, until| {
            sums[0] += values[source] * (until.min(middle) - from).max(0.0);
            sums[1] += values[source] * (until - from.max(middle)).max(0.0);
        });
        all[k] = [sums[0] / (share * interval), sums[1] / ((1.0 - share) * interval)];
    }
    all
}

impl Inputs {
    /// What acts on a joint where these are what its log says, and by sample of that the sample of the
    /// log; `None` where they are the same.
    pub fn acting(&self, model: &Model) -> Option<(Self, Vec<usize>)> {
        let constant = filtered_s(model, self.drive);
        let delay = imposed_late_s(&model.effects, self.drive) - self.lead_s(model);
        if constant == 0.0 && delay == 0.0 {
            return None;
        }
        let values = match constant > 0.0 {
            true => unfiltered(&self.drive_values, &self.time_s, constant),
            false => self.drive_values.clone(),
        };
        let (mut acting, mut samples) = (Self { drive: self.drive, ..Self::none() }, Vec::new());
        let mut add = |time: f64, source: usize, own: usize| {
            acting.time_s.push(time);
            acting.drive_values.push(values[source]);
            acting.load_nm.push(self.load_nm.get(own).copied().unwrap_or(0.0));
            samples.push(own);
        };
        for k in 0..self.time_s.len() {
            pieces(&self.time_s, k, delay, |source, from, _| add(from, source, k));
        }
        if let (Some(time), Some(last)) = (self.time_s.last(), self.time_s.len().checked_sub(1)) {
            add(*time, last, last);
        }
        Some((acting, samples))
    }

    /// How long before its sample a value begins to act, s: half a typical interval where it was measured.
    fn lead_s(&self, model: &Model) -> f64 {
        match self.drive {
            Drive::Current if model.sensor.current_is_measured => {
                0.5 * Grid::new(&self.time_s, None).typical_interval()
            }
            _ => 0.0,
        }
    }

    fn none() -> Self {
        Self {
            time_s: Vec::new(),
            drive: Drive::Voltage,
            drive_values: Vec::new(),
            load_nm: Vec::new(),
        }
    }
}

/// Of what was computed at every instant at which something switches, what is at samples.
pub fn at_samples<T>(all: Vec<T>, samples: &[usize]) -> Vec<T> {
    let mut next = 0;
    let mut kept = Vec::with_capacity(all.len());
    for (value, sample) in all.into_iter().zip(samples) {
        if *sample == next {
            kept.push(value);
            next += 1;
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::actuator;
    use crate::synthetic::Reported;

    const TIMES: [f64; 5] = [0.0, 1.0, 2.0, 3.0, 4.0];

    fn told(k: usize, delay: f64) -> Vec<(usize, f64, f64)> {
        let mut all = Vec::new();
        pieces(&TIMES, k, delay, |source, from, until| all.push((source, from, until)));
        all
    }

    #[test]
    fn an_input_acts_late_by_parts_of_an_interval_and_by_several() {
        assert_eq!(told(2, 0.0), [(2, 2.0, 3.0)]);
        assert_eq!(told(2, 0.25), [(1, 2.0, 2.25), (2, 2.25, 3.0)]);
        assert_eq!(told(3, 1.5), [(1, 3.0, 3.5), (2, 3.5, 4.0)]);
        assert_eq!(told(3, 2.0), [(1, 3.0, 4.0)]);
        assert_eq!(told(1, -0.25), [(1, 1.0, 1.75), (2, 1.75, 2.0)]);
        // What was before the log is taken to be as its first value.
        assert_eq!(told(0, 2.5), [(0, 0.0, 1.0)]);
    }

    #[test]
    fn the_impulse_of_a_late_input_is_its_own_whatever_the_delay() {
        let values = [1.0, -3.0, 2.0, 5.0, 5.0];
        for delay in [0.0, 0.2, 0.9999, 1.0, 1.0001, 1.7] {
            let share = switch(delay, 1.0);
            let switched = switched(&values, &TIMES, delay, share);
            let impulse: f64 = switched[..4]
                .iter()
                .map(|[early, late]| share * early + (1.0 - share) * late)
                .sum();
            // Over [0, 4] acts what is held over [-d, 4 - d].
            let wanted: f64 = (0..4)
                .map(|k| {
                    let left = (4.0 - delay - f64::from(k)).clamp(0.0, 1.0);
                    values[k as usize] * left + if k == 0 { delay } else { 0.0 }
                })
                .sum();
            assert!((impulse - wanted).abs() < 1e-9, "{delay}: {impulse} {wanted}");
        }
    }

    #[test]
    fn a_filter_that_is_undone_gives_what_went_into_it() {
        let time_s: Vec<f64> = (0..200).map(|k| 1e-3 * f64::from(k)).collect();
        // What the filter shows at a sample is of the value held before it.
        let held: Vec<f64> = time_s.iter().map(|t| (90.0 * t).sin()).collect();
        let before: Vec<f64> = [0.0].into_iter().chain(held.iter().copied()).take(200).collect();
        let shown = Reported::Filtered(0.02).of(&before, &time_s);
        let undone = unfiltered(&shown, &time_s, 0.02);
        let error = undone.iter().zip(&held).take(199).map(|(a, b)| (a - b).abs());
        assert!(error.fold(0.0, f64::max) < 1e-10);
    }

    #[test]
    fn a_filtered_input_acts_as_much_later_as_its_report_is_ahead() {
        let lag = EffectParameters::new(Kind::SensorLag, Location::CurrentSensor);
        let lag = lag.with("time_constant_s", 2.0).with("lead_s", 0.5);
        let delay = EffectParameters::new(Kind::InputDelay, Location::Inverter);
        let effects = [lag, delay.with("delay_s", 0.25)];
        let late = [Drive::Current, Drive::Voltage].map(|drive| imposed_late_s(&effects, drive));
        assert_eq!(late, [0.75, 0.25]);
    }

    #[test]
    fn instants_at_which_an_input_switches_are_between_the_samples() {
        let delay = EffectParameters::new(Kind::InputDelay, Location::Inverter);
        let model = Model { effects: vec![delay.with("delay_s", 0.5)], ..actuator() };
        let inputs = Inputs {
            time_s: TIMES.to_vec(),
            drive: Drive::Voltage,
            drive_values: vec![1.0, 2.0, 3.0, 4.0, 5.0],
            load_nm: vec![0.1; 5],
        };
        let (acting, samples) = inputs.acting(&model).unwrap();
        assert_eq!(acting.time_s, [0.0, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0]);
        assert_eq!(acting.drive_values[..7], [1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0]);
        assert_eq!(at_samples(acting.time_s, &samples), TIMES);
        assert!(inputs.acting(&actuator()).is_none());
    }

    #[test]
    fn a_measured_current_acts_half_an_interval_earlier_and_a_voltage_does_not() {
        let mut model = actuator();
        model.sensor.current_is_measured = true;
        let values = vec![1.0, 2.0, 3.0, 4.0, 5.0];
        let of = |drive| Inputs {
            time_s: TIMES.to_vec(),
            drive,
            drive_values: values.clone(),
            load_nm: vec![0.0; 5],
        };
        assert!(of(Drive::Voltage).acting(&model).is_none());
        let (acting, samples) = of(Drive::Current).acting(&model).unwrap();
        assert_eq!(acting.time_s, [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0]);
        assert_eq!(acting.drive_values, [1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 5.0, 5.0]);
        assert_eq!(at_samples(acting.time_s, &samples), TIMES);
    }
}
