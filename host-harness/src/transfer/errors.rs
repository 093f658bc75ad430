//! Errors of runs by signal, in SI units.

use std::ops::Range;

use serde::Serialize;

use super::run::Shown;
use crate::log::{CURRENT, Log, MOTOR_ANGLE, OUTPUT_ANGLE};

/// A signal that a run predicts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Signal {
    /// The log's column.
    pub column: &'static str,
    /// Its unit.
    pub unit: &'static str,
}

/// Errors of one signal, in its unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Errors {
    /// Root mean square.
    pub rms: f64,
    /// Mean of the absolute values.
    pub mean_absolute: f64,
    /// Largest absolute value.
    pub max: f64,
}

/// The signals of a log that a run predicts: the angles, and the current where the voltage is the input.
pub(super) fn signals(log: &Log) -> Vec<Signal> {
    let mut all = vec![Signal { column: MOTOR_ANGLE, unit: "rad" }];
    if log.output_angle_rad.is_some() {
        all.push(Signal { column: OUTPUT_ANGLE, unit: "rad" });
    }
    if log.voltage_v.is_some() && log.current_a.is_some() {
        all.push(Signal { column: CURRENT, unit: "A" });
    }
    all
}

/// Sums of errors by signal.
#[derive(Clone, Debug)]
pub(super) struct Tally {
    signals: Vec<Signal>,
    sums: Vec<Sums>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    squares: f64,
    absolute: f64,
    most: f64,
    count: f64,
}

impl Sums {
    fn add(&mut self, error: f64) {
        // A run that has left all numbers is infinitely wrong; a sample that is missing is not asked for.
        self.squares += error * error;
        self.absolute += error.abs();
        self.most = self.most.max(error.abs());
        self.count += 1.0;
    }

    fn errors(&self) -> Errors {
        let count = self.count.max(1.0);
        let finite = |value: f64| if value.is_finite() { value } else { f64::MAX };
        Errors {
            rms: finite((self.squares / count).sqrt()),
            mean_absolute: finite(self.absolute / count),
            max: finite(self.most),
        }
    }
}

impl Tally {
    pub(super) fn new(signals: &[Signal]) -> Self {
        Self { signals: signals.to_vec(), sums: vec![Sums::default(); signals.len()] }
    }

    /// Adds a run over these samples of the log; the first one is its start.
    pub(super) fn add(&mut self, log: &Log, range: &Range<usize>, run: &[Shown], offset: f64) {
        for (signal, sums) in self.signals.iter().zip(&mut self.sums) {
            for (k, shown) in range.clone().zip(run).skip(1) {
                let measured = value(log, signal, k);
                let told = match signal.column {
                    OUTPUT_ANGLE => shown.output_rad + offset,
                    CURRENT => shown.current_a,
                    _ => shown.motor_rad,
                };
                if measured.is_finite() {
                    sums.add(if told.is_finite() { told - measured } else { f64::INFINITY });
                }
            }
        }
    }

    pub(super) fn errors(&self, signal: usize) -> Errors {
        self.sums[signal].errors()
    }
}

pub(super) fn value(log: &Log, signal: &Signal, k: usize) -> f64 {
    let of = |values: &Option<Vec<f64>>| values.as_ref().map_or(f64::NAN, |values| values[k]);
    match signal.column {
        OUTPUT_ANGLE => of(&log.output_angle_rad),
        CURRENT => of(&log.current_a),
        _ => log.motor_angle_rad[k],
    }
}

/// Errors of a joint that stays at its first value.
pub(super) fn resting(signals: &[Signal], log: &Log, range: &Range<usize>) -> Vec<Errors> {
    let of = |signal: &Signal| {
        let mut known = range.clone().map(|k| value(log, signal, k)).filter(|v| v.is_finite());
        let Some(first) = known.next() else { return Errors::default() };
        let mut sums = Sums::default();
        known.for_each(|value| sums.add(value - first));
        sums.errors()
    };
    signals.iter().map(of).collect()
}

/// RMS difference of two runs by signal.
pub(super) fn apart(signals: &[Signal], one: &[Shown], other: &[Shown]) -> Vec<f64> {
    let of = |signal: &Signal| {
        let mut sums = Sums::default();
        for (one, other) in one.iter().zip(other) {
            sums.add(match signal.column {
                OUTPUT_ANGLE => one.output_rad - other.output_rad,
                CURRENT => one.current_a - other.current_a,
                _ => one.motor_rad - other.motor_rad,
            });
        }
        sums.errors().rms
    };
    signals.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_of_known_samples_behind_the_start() {
        let log = Log {
            time_s: vec![0.0, 1.0, 2.0, 3.0],
            motor_angle_rad: vec![5.0, 1.0, f64::NAN, 4.0],
            ..Log::default()
        };
        let run: Vec<Shown> =
            (0..4).map(|_| Shown { motor_rad: 0.0, output_rad: 0.0, current_a: 0.0 }).collect();
        let signals = signals(&log);
        let mut tally = Tally::new(&signals);
        tally.add(&log, &(0..4), &run, 0.0);
        let errors = tally.errors(0);
        assert_eq!((errors.max, errors.mean_absolute), (4.0, 2.5));
        assert!((errors.rms - 8.5_f64.sqrt()).abs() < 1e-12);
        assert_eq!(resting(&signals, &log, &(0..4))[0].max, 4.0);
    }
}
