//! The level of friction on the day of a record.
//!
//! The same law rubs harder or softer from day to day, by a few per cent. That is a parameter of the record
//! and not of the model, so one scale on all friction is estimated on the record's first seconds. A Coulomb
//! level or a viscous coefficient alone is erratic, and an offset from one direction is a disaster.

use super::errors::{Tally, signals};
use super::run::Runner;
use crate::log::Log;
use crate::model::Model;
use crate::plant::BuildError;
use crate::start::Measured;

/// Seconds of the record that tell the level, and at most this share of it.
const LEVEL_S: f64 = 2.0;
const SHARE: f64 = 1.0 / 3.0;
/// Scales that are tried.
const RANGE: [f64; 2] = [0.5, 2.0];
/// Scales tried over the range, and halvings of what lies between two of them.
const TRIED: usize = 15;
const ROUNDS: usize = 12;

/// The scale that brings the free run of the record's first seconds nearest to the motor's angle, and these
/// seconds; `None` where the model has no friction or the best scale lies at the end of the range.
pub(super) fn scale(
    model: &Model,
    log: &Log,
    measured: &Measured<'_>,
    begin: usize,
) -> Result<(Option<f64>, f64), BuildError> {
    let whole = log.time_s[log.len() - 1] - log.time_s[begin];
    let level_s = LEVEL_S.min(SHARE * whole);
    let end = log.time_s.partition_point(|t| *t <= log.time_s[begin] + level_s);
    let start = measured.at(begin).filter(|_| model.rubs() && end > begin + 10);
    let Some(start) = start else { return Ok((None, level_s)) };
    let part = part(log, begin..end);
    let signals = &signals(&part)[..1];
    let missed = |scale: f64| -> Result<f64, BuildError> {
        let model = model.with_friction(scale);
        let run = Runner::new(&model, &part)?.run(&start, 0..part.len());
        let mut tally = Tally::new(signals);
        tally.add(&part, &(0..part.len()), &run, 0.0);
        Ok(tally.errors(0).rms)
    };
    let ratio = (RANGE[1] / RANGE[0]).powf(1.0 / (TRIED - 1) as f64);
    let tried: Vec<f64> = (0..TRIED).map(|k| RANGE[0] * ratio.powi(k as i32)).collect();
    let errors: Vec<f64> = tried.iter().map(|scale| missed(*scale)).collect::<Result<_, _>>()?;
    let best = (0..TRIED).min_by(|a, b| errors[*a].total_cmp(&errors[*b])).unwrap_or(0);
    if best == 0 || best == TRIED - 1 {
        return Ok((None, level_s));
    }
    // Golden section between the neighbours of the best.
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (tried[best - 1], tried[best + 1]);
    for _ in 0..ROUNDS {
        let [left, right] = [high - golden * (high - low), low + golden * (high - low)];
        if missed(left)? < missed(right)? { high = right } else { low = left }
    }
    Ok((Some(0.5 * (low + high)), level_s))
}

/// A range of a log's samples.
fn part(log: &Log, range: std::ops::Range<usize>) -> Log {
    let marked: Vec<bool> = (0..log.len()).map(|k| range.contains(&k)).collect();
    log.only(&marked)
}
