//! A linear combination of all coordinates at once: dynamics that the model has otherwise, or not at all.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::family::{Equations, Family};

/// The coordinates of every sample about their mean and by their RMS, and a constant.
#[derive(Clone, Debug)]
pub(super) struct Linear {
    rows: Vec<Option<Vec<f64>>>,
    columns: usize,
}

impl Linear {
    /// Of coordinates by sample; one that does not change is left out. A sample with a value that is no number has
    /// no place. `None` where there is nothing to combine.
    pub(super) fn new(coordinates: &[&[f64]]) -> Option<Self> {
        let standard = |values: &&[f64]| {
            let finite = || values.iter().filter(|value| value.is_finite());
            let count = finite().count().max(1) as f64;
            let mean = finite().sum::<f64>() / count;
            let rms = (finite().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt();
            (rms > 0.0).then(|| values.iter().map(|v| (v - mean) / rms).collect::<Vec<f64>>())
        };
        let columns: Vec<Vec<f64>> = coordinates.iter().filter_map(standard).collect();
        let samples = columns.first()?.len();
        let row = |k: usize| -> Option<Vec<f64>> {
            let values = columns.iter().map(|column| column[k]).chain([1.0]);
            let row: Vec<f64> = values.collect();
            row.iter().all(|value| value.is_finite()).then_some(row)
        };
        Some(Self { rows: (0..samples).map(row).collect(), columns: columns.len() + 1 })
    }
}

impl Family for Linear {
    type Equations = Dense;

    fn none(&self) -> Dense {
        let count = self.columns;
        Dense { square: DMatrix::zeros(count, count), right: DVector::zeros(count) }
    }

    fn add(&self, to: &mut Dense, series: &[f64], samples: Range<usize>) {
        for k in samples {
            let Some(row) = &self.rows[k] else { continue };
            for (i, one) in row.iter().enumerate() {
                to.right[i] += one * series[k];
                for (j, other) in row.iter().enumerate() {
                    to.square[(i, j)] += one * other;
                }
            }
        }
    }

    fn value(&self, coefficients: &[f64], sample: usize) -> f64 {
        let row = self.rows[sample].iter().flatten();
        row.zip(coefficients).map(|(value, coefficient)| value * coefficient).sum()
    }
}

/// Normal equations of a few columns.
#[derive(Clone, Debug)]
pub(super) struct Dense {
    square: DMatrix<f64>,
    right: DVector<f64>,
}

impl Equations for Dense {
    fn plus(&mut self, other: &Self, sign: f64) {
        self.square += sign * &other.square;
        self.right += sign * &other.right;
    }

    fn solved(&self, ridge: f64) -> Vec<f64> {
        let count = self.right.len();
        let square = &self.square + ridge * DMatrix::<f64>::identity(count, count);
        match square.cholesky() {
            Some(own) => own.solve(&self.right).iter().copied().collect(),
            None => vec![0.0; count],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_combination_is_found_again_and_what_stands_still_or_is_no_number_is_left_out() {
        let one: Vec<f64> = (0..500).map(|k| f64::from(k).sin()).collect();
        let mut other: Vec<f64> = (0..500).map(|k| (1.7 * f64::from(k)).cos()).collect();
        let series: Vec<f64> =
            one.iter().zip(&other).map(|(a, b)| 2.0 * a - 3.0 * b + 5.0).collect();
        other[7] = f64::NAN;
        let family = Linear::new(&[&one, &[4.0; 500], &other]).unwrap();
        let mut equations = family.none();
        family.add(&mut equations, &series, 0..500);
        let found = equations.solved(1e-9);
        assert_eq!(found.len(), 3);
        assert!((0..500).all(|k| k == 7 || (family.value(&found, k) - series[k]).abs() < 1e-8));
        assert_eq!(family.value(&found, 7), 0.0);
        assert!(Linear::new(&[&[4.0; 500]]).is_none());
    }

    #[test]
    fn coordinates_count_about_their_mean_and_by_their_rms_against_a_ridge() {
        let plain = [-1.0, 1.0, -1.0, 1.0];
        let family = Linear::new(&[&plain.map(|x| 1000.0 + 50.0 * x)]).unwrap();
        let mut equations = family.none();
        family.add(&mut equations, &plain.map(|x| 8.0 * x + 3.0), 0..4);
        // Four samples, and two more that are zero.
        let found = equations.solved(2.0);
        assert!(
            (found[0] - 32.0 / 6.0).abs() < 1e-12 && (found[1] - 2.0).abs() < 1e-12,
            "{found:?}"
        );
    }
}
