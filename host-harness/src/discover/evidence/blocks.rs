//! Blocks of samples, the unit in which evidence counts.
//!
//! What disturbs a joint lasts longer than a sample, so samples are no independent witnesses; blocks
//! of ten correlation times are, nearly. Shares are ratios of sums over blocks, with the standard
//! error of the delete-one jackknife (Efron and Stein, Ann. Stat. 9, 1981).

use std::ops::Range;

use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::discover::bounds::BY_CHANCE;

/// Most blocks: more add no precision to a standard error.
const MOST: usize = 60;
/// Correlation times in a block.
const TIMES: f64 = 10.0;
/// Autocorrelation below which a series has forgotten itself.
const FORGOTTEN: f64 = 0.05;
/// Lags up to which an autocorrelation is summed; of a series that has not forgotten itself by then means of so many
/// samples are looked at.
const LAGS: usize = 64;
const COARSER: usize = 4;

/// Consecutive samples, cut into blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct Blocks {
    ranges: Vec<Range<usize>>,
}

/// A share and its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Share {
    /// The share.
    pub value: f64,
    /// One standard error.
    pub error: f64,
}

impl Blocks {
    /// Of the stretches of consecutive samples where `mask` is set, in blocks of at least `least`
    /// samples; what is left of a stretch goes to its last block.
    pub fn over(mask: &[bool], least: usize) -> Self {
        let samples = mask.iter().filter(|set| **set).count();
        let length = least.max(samples / MOST).max(1);
        let mut ranges = Vec::new();
        let mut start = 0;
        for stretch in mask.chunk_by(|a, b| a == b) {
            let end = start + stretch.len();
            if stretch[0] {
                let count = (stretch.len() / length).max(1);
                let border = |k: usize| start + k * stretch.len() / count;
                ranges.extend((0..count).map(|k| border(k)..border(k + 1)));
            }
            start = end;
        }
        Self { ranges }
    }

    /// Blocks of ten correlation times of a series.
    pub fn of_series(mask: &[bool], series: &[f64]) -> Self {
        Self::over(mask, (TIMES * correlation_time(series)).ceil() as usize)
    }

    /// The blocks.
    pub fn ranges(&self) -> &[Range<usize>] {
        &self.ranges
    }

    /// Sum of a series in each block.
    pub fn sums(&self, series: &[f64]) -> Vec<f64> {
        self.ranges.iter().map(|range| series[range.clone()].iter().sum()).collect()
    }

    /// Sum of the squares of a series in each block.
    pub fn squares(&self, series: &[f64]) -> Vec<f64> {
        let sum = |range: &Range<usize>| series[range.clone()].iter().map(|x| x * x).sum();
        self.ranges.iter().map(sum).collect()
    }
}

/// Integrated autocorrelation time of a series in samples, one at least (Priestley, Spectral Analysis
/// and Time Series, 1981): the sum of the autocorrelations to both sides, until they are forgotten.
pub(super) fn correlation_time(series: &[f64]) -> f64 {
    let count = series.len().max(1) as f64;
    let mean = series.iter().sum::<f64>() / count;
    let product = |lag: usize| -> f64 {
        series.iter().zip(&series[lag..]).map(|(a, b)| (a - mean) * (b - mean)).sum()
    };
    let variance = if series.is_empty() { 0.0 } else { product(0) };
    if variance <= 0.0 {
        return 1.0;
    }
    let mut time = 1.0;
    let last = series.len() / 4;
    for lag in 1..last.min(LAGS) {
        let correlation = product(lag) / variance;
        if correlation < FORGOTTEN {
            return time;
        }
        time += 2.0 * correlation;
    }
    if last <= LAGS {
        return time;
    }
    let means = series.chunks_exact(COARSER).map(|own| own.iter().sum::<f64>() / COARSER as f64);
    COARSER as f64 * correlation_time(&means.collect::<Vec<_>>())
}

/// `part / whole`, both summed over blocks.
pub(super) fn ratio(part: &[f64], whole: &[f64]) -> Share {
    jackknifed(part.len(), |kept| {
        let sum = |values: &[f64]| -> f64 { kept.clone().map(|k| values[k]).sum() };
        let whole = sum(whole);
        if whole > 0.0 { sum(part) / whole } else { 0.0 }
    })
}

/// A block and those beside it, of so many: what it is not asked of.
pub(super) fn neighbours(block: usize, count: usize) -> Range<usize> {
    block.saturating_sub(1)..(block + 2).min(count)
}

/// Standard errors that the best of so many shares, each over so many blocks, exceeds by chance in [`BY_CHANCE`] of
/// all cases at most (Bonferroni, of Student's t); endless for less than two blocks.
pub(super) fn beyond_chance(tests: usize, blocks: usize) -> f64 {
    let scatter = StudentsT::new(0.0, 1.0, blocks.saturating_sub(1) as f64);
    scatter.map_or(f64::INFINITY, |t| t.inverse_cdf(1.0 - BY_CHANCE / tests.max(1) as f64))
}

/// A statistic of blocks and its delete-one standard error.
pub(super) fn jackknifed(blocks: usize, statistic: impl Fn(Kept) -> f64) -> Share {
    let value = statistic(Kept::all(blocks));
    if blocks < 2 {
        return Share { value, error: f64::INFINITY };
    }
    let without: Vec<f64> = (0..blocks).map(|out| statistic(Kept::without(blocks, out))).collect();
    let count = blocks as f64;
    let mean = without.iter().sum::<f64>() / count;
    let squares: f64 = without.iter().map(|x| (x - mean).powi(2)).sum();
    Share { value, error: ((count - 1.0) / count * squares).sqrt() }
}

/// Numbers of the blocks that a statistic is taken of.
#[derive(Clone, Debug)]
pub(super) struct Kept {
    next: usize,
    end: usize,
    out: usize,
}

impl Kept {
    fn all(blocks: usize) -> Self {
        Self { next: 0, end: blocks, out: blocks }
    }

    fn without(blocks: usize, out: usize) -> Self {
        Self { next: 0, end: blocks, out }
    }
}

impl Iterator for Kept {
    type Item = usize;

    fn next(&mut self) -> Option<usize> {
        if self.next == self.out {
            self.next += 1;
        }
        let here = self.next;
        self.next += 1;
        (here < self.end).then_some(here)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn autoregressive(samples: usize, keep: f64, random: &mut impl Rng) -> Vec<f64> {
        let mut value = 0.0;
        (0..samples)
            .map(|_| {
                value = keep * value + random.random_range(-1.0..1.0);
                value
            })
            .collect()
    }

    #[test]
    fn blocks_cover_every_set_sample_once_and_no_other() {
        let mask: Vec<bool> = (0..1000).map(|k| (100..260).contains(&k) || k >= 900).collect();
        let blocks = Blocks::over(&mask, 30);
        let mut seen = vec![false; 1000];
        for k in blocks.ranges().iter().flat_map(Clone::clone) {
            assert!(!std::mem::replace(&mut seen[k], true), "sample {k} is in two blocks");
        }
        assert_eq!(seen, mask);
        assert!(blocks.ranges().iter().all(|range| range.len() >= 30));
    }

    #[test]
    fn a_long_stretch_has_sixty_blocks_and_a_short_one_those_it_holds() {
        let count =
            |samples: usize, least| Blocks::over(&vec![true; samples], least).ranges().len();
        assert_eq!([count(6000, 10), count(600, 30), count(59, 30), count(7, 1)], [60, 20, 1, 7]);
        assert_eq!(Blocks::over(&[false; 9], 1).ranges(), []);
    }

    #[test]
    fn blocks_of_a_series_are_ten_correlation_times_and_sum_it_up() {
        let series = autoregressive(100_000, 0.95, &mut ChaCha8Rng::seed_from_u64(4));
        let mask = vec![true; 1000];
        let blocks = Blocks::of_series(&mask, &series);
        let least = (10.0 * correlation_time(&series)).ceil() as usize;
        assert_eq!(blocks, Blocks::over(&mask, least));
        assert_eq!(blocks.ranges().len(), 1000 / least);
        let blocks = Blocks::over(&[true, true, false, true], 2);
        let series = [1.0, -3.0, 7.0, 4.0];
        assert_eq!([blocks.sums(&series), blocks.squares(&series)], [[-2.0, 4.0], [10.0, 16.0]]);
    }

    #[test]
    fn a_correlation_time_knows_no_offset_and_looks_ahead_by_a_quarter() {
        let series = autoregressive(2000, 0.5, &mut ChaCha8Rng::seed_from_u64(5));
        let time = correlation_time(&series);
        let offset: Vec<f64> = series.iter().map(|x| x + 100.0).collect();
        assert!((correlation_time(&offset) - time).abs() < 1e-8 * time);
        // Of a ramp from −4 to 4 the squares sum up to 60, and products one apart to 40.
        let ramp: Vec<f64> = (0..9).map(f64::from).collect();
        assert_eq!(correlation_time(&ramp), 1.0 + 2.0 * 40.0 / 60.0);
        assert_eq!([correlation_time(&[]), correlation_time(&[3.0; 50])], [1.0; 2]);
    }

    #[test]
    fn the_correlation_time_of_an_autoregression_is_the_textbooks() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        for keep in [0.0, 0.5, 0.9] {
            let series = autoregressive(200_000, keep, &mut random);
            // (1 + φ)/(1 − φ), of which the tail below 5 % is left out: 0.05 · 2φ/(1 − φ); the rest
            // is a hundred thousand samples' scatter.
            let exact = (1.0 + keep) / (1.0 - keep);
            let cut = 0.05 * 2.0 * keep / (1.0 - keep);
            let found = correlation_time(&series);
            assert!((found - exact).abs() < cut + 0.1 * exact, "{keep}: {found}, {exact}");
        }
    }

    #[test]
    fn the_jackknife_of_a_mean_is_its_standard_error() {
        let values: Vec<f64> = (0..20).map(|k| f64::from((k * 7) % 11)).collect();
        let share = ratio(&values, &[1.0; 20]);
        let mean = values.iter().sum::<f64>() / 20.0;
        let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 19.0;
        assert!((share.value - mean).abs() < 1e-12);
        assert!((share.error - (variance / 20.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn two_blocks_have_a_standard_error_one_has_none_and_a_share_of_nothing_is_none() {
        assert_eq!(ratio(&[1.0], &[2.0]), Share { value: 0.5, error: f64::INFINITY });
        assert_eq!(ratio(&[1.0, 0.0], &[2.0; 2]), Share { value: 0.25, error: 0.25 });
        assert_eq!(ratio(&[1.0; 2], &[0.0; 2]), Share::default());
    }

    #[test]
    fn a_block_is_not_asked_of_itself_nor_of_those_beside_it() {
        assert_eq!([0, 2, 4].map(|block| neighbours(block, 5)), [0..2, 1..4, 3..5]);
        assert_eq!(neighbours(0, 1), 0..1);
    }

    #[test]
    fn chance_reaches_students_quantile_of_as_many_tests() {
        // Twenty degrees of freedom, 0.95 and 0.995; one degree, 0.95.
        let told = [beyond_chance(1, 21), beyond_chance(10, 21), beyond_chance(1, 2)];
        let table = [1.724_718, 2.845_340, 6.313_752];
        assert!(
            told.iter().zip(table).all(|(told, wanted)| (told - wanted).abs() < 1e-5),
            "{told:?}"
        );
        assert_eq!(beyond_chance(0, 21), told[0]);
        assert_eq!([beyond_chance(1, 1), beyond_chance(1, 0)], [f64::INFINITY; 2]);
    }
}
