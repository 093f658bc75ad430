//! Whether samples that no fit has seen confirm an effect, given all the others.
//!
//! A likelihood on the samples that were fitted to rises with every parameter. On samples that no fit has
//! seen it rises only by what is there. Blocks are the witnesses: what is owed to one moment has a large
//! scatter and a small t (Racine, J. Econometrics 99, 2000; the score is the predictive likelihood of
//! Dawid, J. R. Stat. Soc. A 147, 1984).

use super::blocks::Blocks;
use super::slope::Slope;
use crate::discover::bounds::MOST_INNOVATION;
use crate::estimate::abreast::Rows;
use crate::estimate::filter::Noise;
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::record::CHANNELS;
use crate::model::Model;
use crate::plant::BuildError;

/// What unseen samples say of an effect.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Unseen {
    /// What it takes from minus twice the log-likelihood of each sample; zero of those that were fitted to.
    pub series: Vec<f64>,
    /// Their sum over its standard error, by blocks.
    pub t: f64,
    /// The slope of the errors without it on what it changes of them, both counted in the noise of the model with it:
    /// whether that model comes nearer, or only expects to be farther off.
    pub slope: Slope,
}

/// Asks the samples of `tested` for a fit against the same without one of its effects, refitted.
///
/// # Errors
/// A model cannot be built.
pub(crate) fn unseen(
    problem: &Problem<'_>,
    without: &Fit,
    with: &Fit,
    tested: &[bool],
) -> Result<Unseen, BuildError> {
    let mask: Vec<f64> = tested.iter().map(|tested| f64::from(u8::from(*tested))).collect();
    let asked = Problem { mask: &mask, scout: None, ..*problem };
    let at = |model: &Model, noise: &Noise| -> Result<(Vec<f64>, Rows), BuildError> {
        let run = asked.design(model, noise)?;
        let errors: Rows = run.innovations.iter().map(|row| row.map(bounded)).collect();
        let rows = run.gains.log_variances().zip(&errors).zip(tested);
        let deviance =
            |log: f64, row: &[f64; CHANNELS]| log + row.iter().map(|e| e * e).sum::<f64>();
        let deviances =
            rows.map(|((log, row), tested)| if *tested { deviance(log, row) } else { 0.0 });
        Ok((deviances.collect(), errors))
    };
    // Each at its own noise: where the simpler one's has swallowed what it misses, that tells them apart.
    let (better, (plain, farther)) = rayon::join(
        || at(&with.model, &with.noise),
        || rayon::join(|| at(&without.model, &without.noise), || at(&without.model, &with.noise)),
    );
    let ((better, near), (plain, _), (_, far)) = (better?, plain?, farther?);
    let series: Vec<f64> = plain.iter().zip(&better).map(|(a, b)| a - b).collect();
    let t = witnessed(&Blocks::of_series(tested, &series), &series);
    Ok(Unseen { t, slope: Slope::of(tested, &far, &near), series })
}

fn bounded(error: f64) -> f64 {
    if error.is_nan() { MOST_INNOVATION } else { error.clamp(-MOST_INNOVATION, MOST_INNOVATION) }
}

/// The t of a series' sum over blocks.
fn witnessed(blocks: &Blocks, gains: &[f64]) -> f64 {
    let sums = blocks.sums(gains);
    let count = sums.len() as f64;
    let gain: f64 = sums.iter().sum();
    if sums.len() < 2 {
        return 0.0;
    }
    let mean = gain / count;
    let scatter = sums.iter().map(|sum| (sum - mean).powi(2)).sum::<f64>() / (count - 1.0);
    if scatter > 0.0 { gain / (count * scatter).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::candidates::cogging;
    use crate::discover::trial;
    use crate::estimate::record::Record;

    /// What unseen samples say of a line of order 12 where the log holds one times `hidden`.
    fn told(hidden: f64) -> Unseen {
        let nominal = trial::motor();
        let line = trial::line(12.0).with("amplitude_nm", 0.02 * hidden);
        let record = Record::new(&trial::log(&nominal, line, 4.0), None);
        let (tested, mask) = trial::split(&record);
        let problem = Problem::new(&record, &mask).rough();
        let without = trial::fitted(&problem, &nominal, &[]);
        let with = trial::fitted(&problem, &nominal, &[cogging::line(12.0, 0.01, false)]);
        unseen(&problem, &without.fit, &with.fit, &tested).unwrap()
    }

    #[test]
    fn unseen_samples_bear_out_what_is_there_and_nothing_else() {
        let (there, not) = (told(1.0), told(0.0));
        // Five standard errors of a normal deviate happen once in three million.
        let gain = |told: &Unseen| told.series.iter().sum::<f64>();
        assert!(gain(&there) > 100.0 && there.t > 5.0, "{} {}", gain(&there), there.t);
        assert!(gain(&not) < 10.0 && not.t < 5.0, "{} {}", gain(&not), not.t);
        let [there, not] = [there, not].map(|told| told.slope);
        // It is what its fit says, and what is not there is none.
        assert!((there.0.value - 1.0).abs() < 0.1 && there.margin(5.0) > 0.0, "{there:?}");
        assert!(not.margin(1.0) < 0.0, "{not:?}");
    }

    #[test]
    fn an_error_counts_for_ten_sigmas_at_most() {
        let errors = [-3.0, 10.0, 11.0, -1e200, f64::INFINITY, f64::NAN];
        assert_eq!(errors.map(bounded), [-3.0, 10.0, 10.0, -10.0, 10.0, 10.0]);
    }

    #[test]
    fn fewer_than_two_blocks_and_blocks_that_are_all_the_same_tell_nothing() {
        let told = |count: usize| {
            let gains: Vec<f64> = (0..count).map(|k| k as f64).collect();
            witnessed(&Blocks::over(&vec![true; count], 1), &gains)
        };
        // Of 0 and 1 the sum is 1 and the mean ½, half a unit from each: √2 times ½ in two of them.
        assert_eq!([told(0), told(1), told(2)], [0.0, 0.0, 1.0]);
        assert_eq!(witnessed(&Blocks::over(&[true; 4], 1), &[2.0; 4]), 0.0);
    }

    #[test]
    fn what_is_owed_to_one_moment_has_a_small_t() {
        let tested = vec![true; 1000];
        let blocks = Blocks::over(&tested, 20);
        // Both sum to 999.
        let evenly = witnessed(&blocks, &(0..1000).map(|k| f64::from(k % 3)).collect::<Vec<_>>());
        let at_once: Vec<f64> = (0..1000).map(|k| if k == 99 { 999.0 } else { 0.0 }).collect();
        let at_once = witnessed(&blocks, &at_once);
        assert!(evenly > 50.0, "{evenly}");
        // One block of fifty: its t is one, whatever its size.
        assert!((at_once - 1.0).abs() < 1e-9, "{at_once}");
    }
}
