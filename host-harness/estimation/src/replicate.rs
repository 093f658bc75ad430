//! A bootstrap replicate: a record that the fitted model itself would have produced (parametric bootstrap).
//!
//! Same inputs, same sensors, same noise, nothing missing. What a statistic is on replicates is what it
//! is when nothing is missing, so every threshold is taken from here.

use std::ops::Range;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use super::abreast::{self, Rows};
use super::filter::{Equation, Gains, Noise, Observer, Walk};
use super::fit::Problem;
use super::late::{Late, is_between_samples};
use super::record::{Channel, Record};
use joint_simulation::lanes::LANES;
use joint_simulation::model::Model;
use joint_simulation::plant::{BuildError, Layout, plant};

/// RMS of whitened innovations from which on a replicate has diverged: a right filter leaves one.
const THROWN: f64 = 5.0;

/// A replicate of a record.
///
/// # Errors
/// The model cannot be built.
pub fn replicate(
    model: &Model,
    record: &Record,
    noise: &Noise,
    seed: u64,
) -> Result<Record, BuildError> {
    let plant = plant(model, &record.grid, record.drive)?;
    let observer = Observer::new(model, &*plant, record);
    let layout = Layout::of(model);
    let shifts = Late::of(model, record).samples;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
    let mut state = Vec::new();
    let mut replicate = record.clone();
    let walks: Vec<Walk> = noise.walks(layout.stages).collect();
    let before = is_between_samples(model, record).then_some(Walk::CURRENT_BEFORE);
    let before = before.as_slice();
    let mut disturbances = vec![0.0; walks.len()];
    let count = Channel::ALL.map(|channel| 12.0_f64.sqrt() * noise.sensors[channel as usize]);
    for k in 0..record.len() {
        if record.starts.contains(&k) {
            state = observer.start(k, before, |number| state.get(number).copied());
            for (value, walk) in disturbances.iter_mut().zip(&walks) {
                *value = walk.initial * normal();
            }
        }
        // One clock stamps both encoders.
        let late = if record.jitter.is_empty() { 0.0 } else { normal() };
        for channel in Channel::ALL {
            let c = channel as usize;
            let then = k.checked_add_signed(shifts[c]).filter(|then| *then < record.len());
            let Some(then) = then else { continue };
            if record.measured[then][c].is_finite() {
                let shown = observer.shown(channel, &state, before);
                replicate.measured[then][c] = match channel {
                    Channel::Current => shown + noise.sensors[c] * normal(),
                    _ => {
                        let seen = shown + late * record.jitter(then, channel).sqrt();
                        (seen / count[c]).round() * count[c]
                    }
                };
            }
        }
        let of = |equation: Equation| {
            let own = walks.iter().zip(&disturbances).filter(|(walk, _)| walk.equation == equation);
            own.map(|(_, value)| value).sum::<f64>()
        };
        let more = noise.drive * normal() + of(Equation::Voltage);
        let torques: Vec<f64> =
            (0..=layout.stages).map(|mass| of(Equation::Torque(mass))).collect();
        let drives = observer.late.drives(record, k).map(|drive| drive + more);
        observer.remember(&mut state, before);
        plant.propagate_switched(k, &mut state[..layout.len()], drives, record.load_nm[k]);
        let interval = record.grid.interval(k);
        for (mass, torque) in torques.into_iter().enumerate().filter(|(_, torque)| *torque != 0.0) {
            observer.push(&mut state, mass, torque, interval);
        }
        for (value, walk) in disturbances.iter_mut().zip(&walks) {
            *value = walk.kept(interval) * *value + walk.gained(interval).sqrt() * normal();
        }
        let reversing = observer.reversing(&state).map(|share| share.sqrt() * noise.reversal);
        let [rotor, last] = [noise.torque.hypot(reversing[0]), noise.output.hypot(reversing[1])];
        observer.push(&mut state, 0, rotor * normal(), interval);
        if last > 0.0 {
            observer.push(&mut state, layout.stages, last * normal(), interval);
        }
    }
    Ok(replicate)
}

/// Innovations that a model leaves on replicates of its own, as far as the problem fits, with the gains of the
/// record's filter: replicates differ from it by noise alone. Where a replicate diverges, or the filter on it, they
/// are what every right filter leaves: white, of variance one.
///
/// # Errors
/// The model cannot be built.
pub fn null_innovations(
    model: &Model,
    problem: &Problem<'_>,
    noise: &Noise,
    gains: &Gains,
    seeds: Range<u64>,
) -> Result<Vec<Rows>, BuildError> {
    let seeds: Vec<u64> = seeds.collect();
    let replicates = seeds
        .par_iter()
        .map(|seed| replicate(model, problem.record, noise, *seed))
        .collect::<Result<Vec<_>, _>>()?;
    let plant = plant(model, &problem.record.grid, problem.record.drive)?;
    let observers: Vec<Observer<'_>> = replicates
        .iter()
        .map(|replicate| Observer::new(model, &*plant, replicate).as_far_as(problem.mask))
        .collect();
    let together = observers.par_chunks(LANES);
    let mut all: Vec<Rows> =
        together.flat_map_iter(|observers| abreast::innovations(observers, gains)).collect();
    for ((rows, replicate), seed) in all.iter_mut().zip(&replicates).zip(seeds) {
        let diverged =
            !replicate.measured.iter().zip(&problem.record.measured).all(|(own, given)| {
                own.iter().zip(given).all(|(own, given)| own.is_finite() || !given.is_finite())
            });
        if diverged || has_diverged(rows) {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            for (row, measured) in rows.iter_mut().zip(&problem.record.measured) {
                *row = measured.map(|value| match value.is_finite() {
                    true => StandardNormal.sample(&mut random),
                    false => 0.0,
                });
            }
        }
    }
    Ok(all)
}

/// Whether whitened innovations are beyond what any right filter leaves.
fn has_diverged(rows: &Rows) -> bool {
    let squares = rows.iter().flatten().filter(|e| **e != 0.0).map(|e| e * e);
    let (sum, count) = squares.fold((0.0, 0.0), |(sum, count), e| (sum + e, count + 1.0));
    sum.is_nan() || sum > THROWN * THROWN * count
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::expected;
    use joint_simulation::demo::actuator;
    use joint_simulation::synthetic::{Experiment, record};

    /// Variance of what replicates leave of an actuator whose rotor feels this torque noise, Nm.
    fn left(torque: f64) -> (bool, f64) {
        let model = actuator();
        let log = record(&model, &Experiment { duration_s: 0.2, ..Experiment::default() }, 3);
        let record = Record::join(&[log.unwrap()], None).unwrap();
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask);
        let wild = Noise { torque, ..expected(&model, &record) };
        let diverged = replicate(&model, &record, &wild, 1).unwrap();
        let finite = diverged.measured.iter().flatten().all(|value| value.is_finite());
        let gains = problem.design(&model, &expected(&model, &record)).unwrap().gains;
        let rows = null_innovations(&model, &problem, &wild, &gains, 1..2).unwrap().remove(0);
        let seen: Vec<f64> = rows.iter().flatten().copied().filter(|e| *e != 0.0).collect();
        (finite, seen.iter().map(|e| e * e).sum::<f64>() / seen.len() as f64)
    }

    #[test]
    fn a_twin_beyond_all_numbers_or_sense_leaves_white_errors() {
        for (torque, stays) in [(1e200, false), (1e3, true)] {
            let (finite, variance) = left(torque);
            assert_eq!(finite, stays, "{torque}");
            assert!((variance - 1.0).abs() < 0.15, "{torque}: {variance}");
        }
    }
}
