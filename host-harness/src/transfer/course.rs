//! Free runs sample by sample, to be drawn beside what was measured.

use std::ops::Range;

use super::errors::{self, Errors, Signal, Tally, signals, value};
use super::run::{Runner, Shown};
use crate::log::{CURRENT, Log, OUTPUT_ANGLE};
use crate::model::Model;
use crate::plant::BuildError;
use crate::start::Measured;

/// A model's free runs over a log, by signal.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// What is predicted.
    pub signal: Signal,
    /// What was measured, by sample; NaN where nothing was.
    pub measured: Vec<f64>,
    /// The run from the log's first state, by sample.
    pub free: Vec<f64>,
    /// The runs from the measured state at the start of each window, by sample; NaN behind the last one.
    pub windows: Vec<f64>,
    /// Samples at which a window begins.
    pub starts: Vec<usize>,
    /// Errors of the free run.
    pub free_errors: Errors,
    /// Errors over the windows; `None` where there is none.
    pub window_errors: Option<Errors>,
    /// What a joint misses that stays at its first value.
    pub resting: Errors,
    /// RMS of what was measured, about its mean.
    pub size: f64,
}

impl Course {
    /// Whether the free run has left the log: it misses more than a joint that never moves.
    pub fn diverged(&self) -> bool {
        self.free_errors.rms > self.resting.rms
    }
}

/// Runs a model on a log from its first state, and over windows of this length from the measured state.
/// Nothing where no angle is known.
///
/// # Errors
/// The model cannot be built.
pub fn courses(model: &Model, log: &Log, window_s: f64) -> Result<Vec<Course>, BuildError> {
    let signals = signals(log);
    let measured = Measured::new(model, log);
    let runner = Runner::new(model, log)?;
    let first = (0..log.len()).find_map(|k| Some((k, measured.at(k)?)));
    let Some((begin, start)) = first else { return Ok(Vec::new()) };
    let offset = measured.output_offset();
    let whole = begin..log.len();
    let free = runner.run(&start, whole.clone());
    let runs: Vec<(Range<usize>, Vec<Shown>)> = windows(log, begin, window_s)
        .into_iter()
        .filter_map(|range| Some((range.clone(), runner.run(&measured.at(range.start)?, range))))
        .collect();
    let (mut of_free, mut of_windows) = (Tally::new(&signals), Tally::new(&signals));
    of_free.add(log, &whole, &free, offset);
    runs.iter().for_each(|(range, run)| of_windows.add(log, range, run, offset));
    let resting = errors::resting(&signals, log, &whole);
    let course = |(s, signal): (usize, &Signal)| {
        let of = |shown: &Shown| match signal.column {
            OUTPUT_ANGLE => shown.output_rad + offset,
            CURRENT => shown.current_a,
            _ => shown.motor_rad,
        };
        let mut pieces = vec![f64::NAN; log.len()];
        for (range, run) in &runs {
            for (k, shown) in range.clone().zip(run) {
                pieces[k] = of(shown);
            }
        }
        let before = std::iter::repeat_n(f64::NAN, begin);
        let measured: Vec<f64> = (0..log.len()).map(|k| value(log, signal, k)).collect();
        Course {
            signal: *signal,
            size: size(&measured),
            measured,
            free: before.chain(free.iter().map(of)).collect(),
            windows: pieces,
            starts: runs.iter().map(|(range, _)| range.start).collect(),
            free_errors: of_free.errors(s),
            window_errors: (!runs.is_empty()).then(|| of_windows.errors(s)),
            resting: resting[s],
        }
    };
    Ok(signals.iter().enumerate().map(course).collect())
}

/// Windows of this length from a sample on; the last one is as long as the others, or left out.
pub(super) fn windows(log: &Log, begin: usize, window_s: f64) -> Vec<Range<usize>> {
    let (mut from, mut all) = (begin, Vec::new());
    while from < log.len() {
        let end = log.time_s.partition_point(|t| *t <= log.time_s[from] + window_s * (1.0 + 1e-9));
        if end >= log.len() {
            break;
        }
        all.push(from..end);
        from = end;
    }
    all
}

/// RMS about the mean of what is known.
fn size(values: &[f64]) -> f64 {
    let known = || values.iter().filter(|value| value.is_finite());
    let count = known().count().max(1) as f64;
    let mean = known().sum::<f64>() / count;
    (known().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::actuator;
    use crate::synthetic::{Experiment, record};
    use crate::transfer::transfer;

    #[test]
    fn what_is_drawn_has_the_errors_that_transfer_tells() {
        let truth = actuator();
        let log = record(&truth, &Experiment::clean(2.5), 2).unwrap();
        let drawn = courses(&truth, &log, 1.0).unwrap();
        let told = transfer(&truth, &log).unwrap();
        for (course, errors) in drawn.iter().zip(&told.signals) {
            assert_eq!(course.free_errors, errors.free_run);
            assert_eq!(course.window_errors, errors.windows);
            let squares = course.free.iter().zip(&course.measured).skip(1);
            let squares: Vec<f64> = squares.map(|(a, b)| (a - b).powi(2)).collect();
            let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
            assert!((rms / course.free_errors.rms - 1.0).abs() < 1e-9);
            assert!(!course.diverged() && course.starts.len() == 2);
        }
    }
}
