//! The twin: a record that the fitted model itself would have produced.
//!
//! Same inputs, same sensors, same noise, nothing missing. What a statistic is on twins is what it
//! is when nothing is missing, so every threshold is taken from here.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::filter::{Noise, Observer};
use super::fit::Problem;
use super::late::Late;
use super::record::{CHANNELS, Channel, Record};
use crate::model::Model;
use crate::plant::{BuildError, Layout, plant};

/// A twin of a record.
///
/// # Errors
/// The model cannot be built.
pub fn twin(
    model: &Model,
    record: &Record,
    noise: &Noise,
    seed: u64,
) -> Result<Record, BuildError> {
    let plant = plant(model, &record.grid, record.drive)?;
    let observer = Observer::new(model, &*plant, record);
    let layout = Layout::of(model);
    let late = Late::of(model, record).samples;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
    let mut state = Vec::new();
    let mut twin = record.clone();
    let count = Channel::ALL.map(|channel| 12.0_f64.sqrt() * noise.sensors[channel as usize]);
    for k in 0..record.len() {
        if record.starts.contains(&k) {
            state = observer.start(k, layout.len());
        }
        for channel in Channel::ALL {
            let c = channel as usize;
            let then = k.checked_add_signed(late[c]).filter(|then| *then < record.len());
            let Some(then) = then else { continue };
            if record.measured[then][c].is_finite() {
                let shown = observer.shown(channel, &state, &[]);
                twin.measured[then][c] = match channel {
                    Channel::Current => shown + noise.sensors[c] * normal(),
                    _ => (shown / count[c]).round() * count[c],
                };
            }
        }
        let drive = record.drive_values[k] + noise.drive * normal();
        plant.propagate(k, &mut state, drive, record.load_nm[k]);
        observer.push(&mut state, 0, noise.torque * normal(), record.grid.interval(k));
    }
    Ok(twin)
}

/// Innovations that a model leaves on its own twin, as far as the problem fits. Where noise throws the twin
/// beyond all numbers, they are what every right filter leaves: white, of variance one.
///
/// # Errors
/// The model cannot be built.
pub fn null_innovations(
    model: &Model,
    problem: &Problem<'_>,
    noise: &Noise,
    seed: u64,
) -> Result<Vec<[f64; CHANNELS]>, BuildError> {
    let twin = twin(model, problem.record, noise, seed)?;
    let plant = plant(model, &twin.grid, twin.drive)?;
    let observer = Observer::new(model, &*plant, &twin).as_far_as(problem.mask);
    let mut rows = observer.design(noise, &problem.walks()).1.innovations;
    if !rows.iter().flatten().all(|e| e.is_finite()) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        for (row, measured) in rows.iter_mut().zip(&problem.record.measured) {
            *row = measured.map(|value| match value.is_finite() {
                true => StandardNormal.sample(&mut random),
                false => 0.0,
            });
        }
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::actuator;
    use crate::estimate::noise::expected;
    use crate::synthetic::{Experiment, record};

    #[test]
    fn a_twin_beyond_all_numbers_leaves_white_errors() {
        let model = actuator();
        let log = record(&model, &Experiment { duration_s: 0.2, ..Experiment::default() }, 3);
        let record = Record::join(&[log.unwrap()], None).unwrap();
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask);
        let wild = Noise { torque: 1e200, ..expected(&model, &record) };
        let thrown = twin(&model, &record, &wild, 1).unwrap();
        assert!(!thrown.measured.iter().flatten().all(|value| value.is_finite()));
        let rows = null_innovations(&model, &problem, &wild, 1).unwrap();
        let seen: Vec<f64> = rows.iter().flatten().copied().filter(|e| *e != 0.0).collect();
        let variance = seen.iter().map(|e| e * e).sum::<f64>() / seen.len() as f64;
        assert!((variance - 1.0).abs() < 0.15, "{variance} of {}", seen.len());
    }
}
