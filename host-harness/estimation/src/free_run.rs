//! Free runs: a model from a measured state on, by the logged input alone.
//!
//! One-step predictions are how differences are found; a run without any correction is what a
//! simulator's user sees. It begins at the filter's state at the start of a stretch, so that no
//! encoder zero and no wind-up of before is counted as the model's.

use std::ops::Range;

use super::filter::{Noise, Observer};
use super::fit::Problem;
use super::record::{CHANNELS, Channel, Record};
use joint_simulation::model::Model;
use joint_simulation::plant::{BuildError, plant};

/// The stretches of consecutive samples where `mask` is set, of two samples at least; none goes over the
/// start of a log.
pub fn stretches(record: &Record, mask: &[bool]) -> Vec<Range<usize>> {
    let mut all = Vec::new();
    let mut begun: Option<usize> = None;
    for (k, inside) in mask.iter().copied().chain([false]).enumerate() {
        if let Some(start) = begun
            && (!inside || record.starts.contains(&k))
        {
            all.push(start..k);
            begun = None;
        }
        if inside && begun.is_none() {
            begun = Some(k);
        }
    }
    all.retain(|range| range.len() > 1);
    all
}

/// RMS error of free runs over these stretches by channel, in its unit; `None` where nothing is
/// measured, infinite where a run has left all numbers.
///
/// # Errors
/// The model cannot be built.
pub fn errors(
    model: &Model,
    record: &Record,
    noise: &Noise,
    stretches: &[Range<usize>],
) -> Result<[Option<f64>; CHANNELS], BuildError> {
    let plant = plant(model, &record.grid, record.drive)?;
    let observer = Observer::new(model, &*plant, record);
    let walks = Problem::new(record, &[]).walks(&noise.uncoloured(), model);
    let (_, run) = observer.design(noise, &walks);
    let (mut sums, mut counts) = ([0.0; CHANNELS], [0.0; CHANNELS]);
    for stretch in stretches {
        let mut x = run.states[stretch.start].clone();
        for k in stretch.clone() {
            for channel in Channel::ALL {
                let c = channel as usize;
                let measured = observer.late.measured[k][c];
                if k > stretch.start && measured.is_finite() {
                    sums[c] += (measured - observer.shown(channel, &x, &walks)).powi(2);
                    counts[c] += 1.0;
                }
            }
            observer.advance(k, &mut x, &walks);
        }
    }
    let rms = |c: usize| {
        let mean: f64 = sums[c] / counts[c];
        (counts[c] > 0.0).then(|| if mean.is_finite() { mean.sqrt() } else { f64::INFINITY })
    };
    Ok(std::array::from_fn(rms))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::expected;
    use joint_simulation::demo::actuator;
    use joint_simulation::synthetic::{Experiment, record};

    #[test]
    fn stretches_end_with_the_mask_and_with_a_log() {
        let log = record(&actuator(), &Experiment::clean(0.1), 1).unwrap();
        let joined = Record::join(&[log.clone(), log], None).unwrap();
        let (half, all) = (joined.starts[1], joined.len());
        let mask: Vec<bool> = (0..all).map(|k| k > half - 10).collect();
        assert_eq!(stretches(&joined, &mask), [half - 9..half, half..all]);
    }

    #[test]
    fn the_true_model_runs_free_within_its_sensors_and_a_wrong_one_does_not() {
        let truth = actuator();
        let log = record(&truth, &Experiment::clean(0.5), 2).unwrap();
        let record = Record::join(&[log], None).unwrap();
        let noise = expected(&truth, &record);
        let half = record.len() / 2;
        let stretch = half..half + 300;
        let runs =
            |model: &Model| errors(model, &record, &noise, std::slice::from_ref(&stretch)).unwrap();
        let mut wrong = truth.clone();
        wrong.motor.torque_constant_nm_per_a *= 1.1;
        let (right, wrong) = (runs(&truth), runs(&wrong));
        let motor = Channel::Motor as usize;
        let (right, wrong) = (right[motor].unwrap(), wrong[motor].unwrap());
        assert!(wrong > 5.0 * right, "{right} {wrong}");
    }
}
