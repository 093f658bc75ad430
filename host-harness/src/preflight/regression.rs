//! Robust linear regression with errors that allow for coloured residuals.
//!
//! What disturbs a real joint is correlated in time, so the textbook's standard errors are too small.
//! Rows are gathered in blocks that follow each other, and errors come from leaving one block out at a
//! time (the delete-one jackknife, Efron and Stein 1981). Rows that stand out are weighted down by
//! Huber's function at 1.345 robust standard deviations.

use nalgebra::{DMatrix, DVector};

/// Blocks of rows.
const BLOCKS: usize = 20;
/// Rounds of reweighting.
const ROUNDS: usize = 6;
/// Huber's constant: 95 % efficient where residuals are normal.
const HUBER: f64 = 1.345;
/// Standard deviations in a median absolute deviation, where residuals are normal.
const NORMAL_MAD: f64 = 1.4826;

/// Rows of a regression: what is explained, and what explains it.
#[derive(Clone, Debug)]
pub(super) struct Rows {
    columns: usize,
    targets: Vec<f64>,
    values: Vec<f64>,
}

/// A fitted regression.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    /// The coefficients, in the order of the columns.
    pub(super) coefficients: DVector<f64>,
    /// The same without one block each.
    without: Vec<DVector<f64>>,
    /// Robust standard deviation of what is left.
    pub(super) residual: f64,
}

impl Rows {
    pub(super) fn new(columns: usize) -> Self {
        Self { columns, targets: Vec::new(), values: Vec::new() }
    }

    /// Adds a row; one that lacks a value is left out.
    pub(super) fn push(&mut self, target: f64, values: &[f64]) {
        if target.is_finite() && values.iter().all(|value| value.is_finite()) {
            self.targets.push(target);
            self.values.extend_from_slice(values);
        }
    }

    pub(super) fn len(&self) -> usize {
        self.targets.len()
    }

    fn row(&self, k: usize) -> &[f64] {
        &self.values[k * self.columns..(k + 1) * self.columns]
    }

    fn residuals(&self, coefficients: &DVector<f64>) -> Vec<f64> {
        let left = |k: usize| {
            let told: f64 = self.row(k).iter().zip(coefficients.iter()).map(|(x, c)| x * c).sum();
            self.targets[k] - told
        };
        (0..self.len()).map(left).collect()
    }

    /// Fits by least squares with Huber's weights; `None` where the rows are too few or do not tell the
    /// columns apart.
    pub(super) fn fit(&self) -> Option<Fit> {
        if self.len() < (4 * self.columns).max(BLOCKS) {
            return None;
        }
        let scales: Vec<f64> = (0..self.columns)
            .map(|c| (0..self.len()).map(|k| self.row(k)[c].powi(2)).sum::<f64>().sqrt())
            .collect();
        if scales.iter().any(|scale| !(scale.is_finite() && *scale > 0.0)) {
            return None;
        }
        let mut weights = vec![1.0; self.len()];
        let mut sums = self.sums(&weights, &scales);
        let mut coefficients = solved(&sums, None, &scales)?;
        let mut residual = 0.0;
        for _ in 0..ROUNDS {
            let left = self.residuals(&coefficients);
            residual = NORMAL_MAD * median(left.iter().map(|left| left.abs()).collect())?;
            if residual <= 0.0 {
                break;
            }
            for (weight, left) in weights.iter_mut().zip(&left) {
                *weight = (HUBER * residual / left.abs()).min(1.0);
            }
            sums = self.sums(&weights, &scales);
            coefficients = solved(&sums, None, &scales)?;
        }
        let without = (0..BLOCKS).map(|block| solved(&sums, Some(block), &scales));
        Some(Fit { without: without.collect::<Option<_>>()?, coefficients, residual })
    }

    /// The normal equations of every block, in scaled columns.
    fn sums(&self, weights: &[f64], scales: &[f64]) -> Vec<(DMatrix<f64>, DVector<f64>)> {
        let zero = || (DMatrix::zeros(self.columns, self.columns), DVector::zeros(self.columns));
        let mut sums: Vec<_> = (0..BLOCKS).map(|_| zero()).collect();
        for k in 0..self.len() {
            let (gram, right) = &mut sums[k * BLOCKS / self.len()];
            let row = self.row(k);
            for a in 0..self.columns {
                let scaled = weights[k] * row[a] / scales[a];
                right[a] += scaled * self.targets[k];
                for b in 0..self.columns {
                    gram[(a, b)] += scaled * row[b] / scales[b];
                }
            }
        }
        sums
    }
}

/// The coefficients of all blocks but one.
fn solved(
    sums: &[(DMatrix<f64>, DVector<f64>)],
    without: Option<usize>,
    scales: &[f64],
) -> Option<DVector<f64>> {
    let columns = scales.len();
    let mut gram = DMatrix::zeros(columns, columns);
    let mut right = DVector::zeros(columns);
    for (block, (own_gram, own_right)) in sums.iter().enumerate() {
        if Some(block) != without {
            gram += own_gram;
            right += own_right;
        }
    }
    // Columns scaled to one: a pivot of rounding is no information.
    if gram.clone().symmetric_eigenvalues().min() < 1e-10 {
        return None;
    }
    let solution = gram.cholesky()?.solve(&right);
    let solution = DVector::from_iterator(
        columns,
        solution.iter().zip(scales).map(|(value, scale)| value / scale),
    );
    solution.iter().all(|value| value.is_finite()).then_some(solution)
}

impl Fit {
    /// A coefficient and its standard error.
    pub(super) fn coefficient(&self, column: usize) -> (f64, f64) {
        self.quantity(|coefficients| coefficients[column])
    }

    /// A quantity that follows from the coefficients, and its standard error.
    pub(super) fn quantity(&self, of: impl Fn(&DVector<f64>) -> f64) -> (f64, f64) {
        let every: Vec<f64> = self.without.iter().map(&of).collect();
        let blocks = every.len() as f64;
        let mean = every.iter().sum::<f64>() / blocks;
        let spread: f64 = every.iter().map(|value| (value - mean).powi(2)).sum();
        (of(&self.coefficients), (spread * (blocks - 1.0) / blocks).sqrt())
    }
}

/// The middle value; `None` of nothing.
pub(crate) fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    Some(*values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// A line through coloured noise of correlation `rho`, one row in a hundred an outlier.
    fn line(seed: u64, rho: f64) -> Fit {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut rows = Rows::new(2);
        let mut noise = 0.0;
        for k in 0..2000 {
            noise = rho * noise + random.random_range(-1.0..1.0);
            let x = (0.01 * f64::from(k)).sin();
            let off = if k % 100 == 7 { 500.0 } else { 0.0 };
            rows.push(3.0 * x + 1.0 + noise + off, &[x, 1.0]);
        }
        rows.fit().unwrap()
    }

    #[test]
    fn outliers_do_not_move_the_line() {
        let (slope, error) = line(1, 0.0).coefficient(0);
        assert!((slope - 3.0).abs() < 4.0 * error && error < 0.1, "{slope} ± {error}");
    }

    #[test]
    fn errors_allow_for_coloured_noise() {
        let off: Vec<f64> = (0..60)
            .map(|seed| {
                let (slope, error) = line(seed, 0.95).coefficient(0);
                (slope - 3.0) / error
            })
            .collect();
        let rms = (off.iter().map(|off| off * off).sum::<f64>() / 60.0).sqrt();
        // One for exact errors; 60 draws tell it to 10 %, and a jackknife of 20 blocks scatters by 16 %.
        assert!(rms < 1.4, "{rms}");
    }

    #[test]
    fn columns_that_are_one_and_the_same_are_not_told_apart() {
        let mut rows = Rows::new(2);
        (0..100).for_each(|k| rows.push(f64::from(k), &[f64::from(k), 2.0 * f64::from(k)]));
        assert!(rows.fit().is_none());
    }
}
