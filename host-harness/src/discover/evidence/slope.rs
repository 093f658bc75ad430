//! Whether what an effect changes of the prediction errors is what they lack.
//!
//! On samples that no fit has seen, the errors without an effect are regressed on the change that it makes of them. The
//! slope is one where the effect is what its fit says, zero where it predicts nothing, and above a half where it comes
//! nearer (a forecast that encompasses another: Chong and Hendry, Rev. Econ. Stud. 53, 1986; of nested models: Clark and
//! West, J. Econometrics 138, 2007). What drives the joint says how much an effect changes at any moment, so that only
//! what the regression leaves is uncertain: a slope is sharp where a sum of gains is not, and a moment of slip at which
//! both models fail weighs little.

use super::blocks::{Blocks, Share, ratio};
use crate::discover::bounds::{HALFWAY, MOSTLY, SIGMAS};
use crate::estimate::record::CHANNELS;

/// The slope of the errors without an effect on the change that it makes of them, with its standard error by blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope(pub(crate) Share);

impl Default for Slope {
    /// Of what changes nothing.
    fn default() -> Self {
        Self(Share { value: 0.0, error: f64::INFINITY })
    }
}

impl Slope {
    /// Over the samples of `tested`, of errors without an effect and with it, both counted in the same noise.
    pub(super) fn of(
        tested: &[bool],
        without: &[[f64; CHANNELS]],
        with: &[[f64; CHANNELS]],
    ) -> Self {
        let by_sample = |term: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
            let rows = without.iter().zip(with).zip(tested);
            let sum = |(a, b): (&[f64; CHANNELS], &[f64; CHANNELS])| {
                a.iter().zip(b).map(|(a, b)| term(*a, a - b)).sum()
            };
            rows.map(|(row, tested)| if *tested { sum(row) } else { 0.0 }).collect()
        };
        let [held, changed] =
            [by_sample(&|error, change| error * change), by_sample(&|_, change| change * change)];
        let [sum, whole] = [&held, &changed].map(|series| series.iter().sum::<f64>());
        if whole <= 0.0 {
            return Self::default();
        }
        let left: Vec<f64> = held.iter().zip(&changed).map(|(a, b)| a - sum / whole * b).collect();
        let blocks = Blocks::of_series(tested, &left);
        Self(ratio(&blocks.sums(&held), &blocks.sums(&changed)))
    }

    /// Its value and one standard error; `None` of what changes nothing.
    pub(crate) fn told(self) -> [Option<f64>; 2] {
        let Share { value, error } = self.0;
        [value, error].map(|own| Some(own).filter(|_| error.is_finite()))
    }

    /// Standard errors by which it is beyond that of an effect that comes no nearer than none.
    pub(crate) fn nearer(self) -> f64 {
        self.beyond(HALFWAY)
    }

    /// By how many standard errors an effect comes nearer, beyond what `chance` reaches, and most of what it changes is
    /// borne out, or may be; below zero where one of them is not so.
    pub(crate) fn margin(self, chance: f64) -> f64 {
        (self.nearer() - chance).min(self.beyond(MOSTLY) + SIGMAS)
    }

    fn beyond(self, of: f64) -> f64 {
        let Share { value, error } = self.0;
        if error > 0.0 { (value - of) / error } else { (value - of).signum() * f64::INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    const SAMPLES: usize = 4000;

    /// The slope of white errors that hold `held` times a change; for a while both models are off by `moment`, and the
    /// one with the effect by `lost` as well.
    fn told(seed: u64, held: f64, moment: f64, lost: f64) -> Slope {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let change = |k: usize| 2.0 * (k as f64 / 50.0).sin().max(0.0);
        let within = |k: usize| (450..500).contains(&k);
        let (mut without, mut with) = (Vec::new(), Vec::new());
        for k in 0..SAMPLES {
            let noise: f64 = StandardNormal.sample(&mut random);
            let far = if within(k) { moment } else { 0.0 };
            let error = held * change(k) + far + noise;
            let own = error - change(k) + if within(k) { lost } else { 0.0 };
            without.push([error, 0.0, 0.0]);
            with.push([own, 0.0, 0.0]);
        }
        let tested: Vec<bool> = (0..SAMPLES).map(|k| k % 1000 >= 400).collect();
        Slope::of(&tested, &without, &with)
    }

    #[test]
    fn it_is_how_much_of_the_change_the_errors_hold() {
        const SEEDS: u64 = 60;
        for held in [0.0, 0.5, 1.0, 2.0] {
            let off = |seed| {
                let Slope(Share { value, error }) = told(seed, held, 0.0, 0.0);
                ((value - held) / error).powi(2)
            };
            let scatter = (0..SEEDS).map(off).sum::<f64>() / SEEDS as f64;
            // Of sixty squares of normal deviates the mean scatters by 0.18.
            assert!((0.5..1.6).contains(&scatter), "{held}: {scatter}");
        }
        // A change whose mean square is one, over 2,400 samples of unit noise.
        let error = told(1, 1.0, 0.0, 0.0).0.error * 2400.0_f64.sqrt();
        assert!((0.5..1.5).contains(&error), "{error}");
    }

    #[test]
    fn a_moment_at_which_both_fail_weighs_little_and_one_that_the_effect_loses_more() {
        let [quiet, both, lost] =
            [(0.0, 0.0), (8.0, 0.0), (0.0, 8.0)].map(|(moment, lost)| told(7, 1.0, moment, lost));
        assert!((both.0.value - quiet.0.value).abs() < 0.2 && both.margin(3.3) > 0.0, "{both:?}");
        assert!(lost.0.value < 0.7 && lost.0.error > 3.0 * quiet.0.error, "{lost:?}");
    }

    #[test]
    fn an_effect_comes_nearer_beyond_chance_and_most_of_it_is_borne_out() {
        let margin = |value: f64, error: f64| Slope(Share { value, error }).margin(3.3);
        assert!((margin(1.0, 0.1) - 1.7).abs() < 1e-9);
        // What may be no nearer, and what comes nearer without doubt by a small part of what it changes.
        assert!(margin(0.9, 0.2) < 0.0 && margin(0.55, 0.01) < 0.0 && margin(0.73, 0.03) > 0.0);
        assert!(Slope::default().margin(1.0) < 0.0);
        assert_eq!(margin(1.0, 0.0), f64::INFINITY);
        assert_eq!(Slope(Share { value: 1.0, error: 0.1 }).told(), [Some(1.0), Some(0.1)]);
        assert_eq!(Slope::default().told(), [None; 2]);
    }

    #[test]
    fn what_changes_nothing_or_was_asked_of_one_block_tells_nothing() {
        let [errors, other] = [[[1.0, 0.0, 0.0]; 40], [[0.5, 0.0, 0.0]; 40]];
        assert_eq!(Slope::of(&[true; 40], &errors, &errors), Slope::default());
        assert_eq!(Slope::of(&[false; 40], &errors, &other), Slope::default());
        assert_eq!(Slope::of(&[true], &errors[..1], &other[..1]).told(), [None; 2]);
    }
}
