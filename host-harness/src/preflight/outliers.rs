//! Samples that are no measurement: one cell of 1e300, one voltage of a million.
//!
//! A glitch of a bus or of a conversion stands alone and far outside what the channel otherwise shows. One of
//! them is enough to spoil a least-squares fit.

use super::{Case, Check, Finding};
use crate::log::Log;

/// How many times the largest of the other samples an outlier is off the channel's middle.
const BEYOND: f64 = 20.0;
/// Samples in a row from which on it is an event, not an outlier.
const SEVERAL: usize = 3;
/// Share of the samples that may be looked at as outliers.
const FEW: f64 = 1e-3;

pub(super) const CHECK: Check =
    Check { name: "outliers", compares: "each sample with the spread of its channel", run };

fn run(case: &Case<'_>) -> Vec<Finding> {
    let columns = case.log.columns();
    columns
        .into_iter()
        .skip(1)
        .filter_map(|(name, values)| outlier(case.log, name, values))
        .collect()
}

fn outlier(log: &Log, name: &str, values: &[f64]) -> Option<Finding> {
    let mut known: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    let middle = super::regression::median(known.clone())?;
    known.iter_mut().for_each(|value| *value = (*value - middle).abs());
    let few = (FEW * known.len() as f64).ceil() as usize;
    let place = known.len().checked_sub(few + 1)?;
    let bound = BEYOND * *known.select_nth_unstable_by(place, f64::total_cmp).1;
    // A channel that rests but for a few samples has no spread of its own.
    if bound == 0.0 {
        return None;
    }
    let far: Vec<usize> =
        (0..values.len()).filter(|k| (values[*k] - middle).abs() > bound).collect();
    let first = *far.first()?;
    let alone = far.windows(SEVERAL).all(|run| run[SEVERAL - 1] - run[0] >= SEVERAL);
    alone.then(|| {
        Finding::error(format!(
            "{name} = {:e} at t_s = {} is no measurement: the other samples lie within {:.3e} of {middle:.3e}{}",
            values[first],
            log.time_s[first],
            bound / BEYOND,
            if far.len() > 1 { format!(" ({} such samples)", far.len()) } else { String::new() }
        ))
        .help("leave the field empty, or remove the row")
        .at(first)
    })
}

#[cfg(test)]
mod tests {
    use super::super::made::{actuator_and_log, of};
    use super::*;

    #[test]
    fn one_impossible_sample_is_told_with_its_row() {
        let (model, good) = actuator_and_log();
        assert_eq!(of(&CHECK, &model, &good), []);
        for value in [1e6, -1e6, 1e300] {
            let mut log = good.clone();
            log.voltage_v.as_mut().unwrap()[1234] = value;
            let told = of(&CHECK, &model, &log);
            assert_eq!(told.len(), 1);
            assert!(told[0].message.starts_with("u_v = "), "{told:?}");
            assert_eq!(told[0].row, Some(1234));
        }
    }

    #[test]
    fn a_pulse_of_several_samples_is_an_experiment() {
        let (model, mut log) = actuator_and_log();
        log.voltage_v.as_mut().unwrap().fill(0.1);
        log.voltage_v.as_mut().unwrap()[100] = 0.0;
        log.voltage_v.as_mut().unwrap()[1000..1005].fill(24.0);
        assert_eq!(of(&CHECK, &model, &log), []);
    }
}
