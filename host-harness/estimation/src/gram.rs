//! Products of tall matrices: the curvature of a sum of squares, and what two derivatives share.
//!
//! A record is long and its derivatives are few, so a product is a dot product for every two columns.
//! They are taken over a stretch of rows at a time, all of whose columns are near the processor, and
//! each core takes some of the stretches.

use joint_core::work::Work;
use nalgebra::DMatrix;
use rayon::prelude::*;

use joint_simulation::wide;

/// Rows of a stretch.
const STRETCH: usize = 512;
/// Sums that are taken side by side.
const SIDES: usize = 16;

/// `JᵀJ` of a matrix.
pub fn gram(jacobian: &DMatrix<f64>) -> DMatrix<f64> {
    let half = stretched(jacobian, jacobian, true);
    DMatrix::from_fn(half.nrows(), half.ncols(), |i, j| half[(i.min(j), i.max(j))])
}

/// `AᵀB` of matrices of as many rows.
pub fn shared(left: &DMatrix<f64>, right: &DMatrix<f64>) -> DMatrix<f64> {
    stretched(left, right, false)
}

/// The product; of a symmetric one what is not below the diagonal.
fn stretched(left: &DMatrix<f64>, right: &DMatrix<f64>, symmetric: bool) -> DMatrix<f64> {
    assert_eq!(left.nrows(), right.nrows(), "as many rows");
    let rows = left.nrows();
    let parts: Vec<DMatrix<f64>> = (0..rows.div_ceil(STRETCH))
        .into_par_iter()
        .map(|stretch| {
            let first = stretch * STRETCH;
            let rows = (first, STRETCH.min(rows - first));
            wide::run(Stretch { left, right, rows, symmetric })
        })
        .collect();
    let nothing = DMatrix::zeros(left.ncols(), right.ncols());
    parts.iter().fold(nothing, |sum, part| sum + part)
}

struct Stretch<'a> {
    left: &'a DMatrix<f64>,
    right: &'a DMatrix<f64>,
    /// The first, and how many.
    rows: (usize, usize),
    symmetric: bool,
}

impl Work for Stretch<'_> {
    type Output = DMatrix<f64>;

    #[inline(always)]
    fn run(self) -> DMatrix<f64> {
        let Self { left, right, rows: (first, count), symmetric } = self;
        let column = |of: &'_ DMatrix<f64>, k: usize| {
            let begin = k * of.nrows() + first;
            begin..begin + count
        };
        let mut product = DMatrix::zeros(left.ncols(), right.ncols());
        for j in 0..right.ncols() {
            let there = &right.as_slice()[column(right, j)];
            for i in 0..if symmetric { j + 1 } else { left.ncols() } {
                product[(i, j)] = dot(&left.as_slice()[column(left, i)], there);
            }
        }
        product
    }
}

#[inline(always)]
fn dot(one: &[f64], other: &[f64]) -> f64 {
    let (ones, one_left) = one.as_chunks::<SIDES>();
    let (others, other_left) = other.as_chunks::<SIDES>();
    let mut sums = [0.0; SIDES];
    for (one, other) in ones.iter().zip(others) {
        for ((sum, one), other) in sums.iter_mut().zip(one).zip(other) {
            *sum += one * other;
        }
    }
    let left: f64 = one_left.iter().zip(other_left).map(|(one, other)| one * other).sum();
    sums.iter().sum::<f64>() + left
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tall(rows: usize, columns: usize) -> DMatrix<f64> {
        DMatrix::from_fn(rows, columns, |i, j| ((1 + i * (j + 2)) as f64).sin())
    }

    #[test]
    fn products_are_those_of_every_two_columns() {
        for rows in [1, 40, 512, 1300] {
            let (one, other) = (tall(rows, 5), tall(rows, 7).map(|value| value + 0.3));
            let [own, wanted] = [gram(&one), one.tr_mul(&one)];
            assert!((own - wanted).amax() < 1e-12 * rows as f64);
            let [own, wanted] = [shared(&one, &other), one.tr_mul(&other)];
            assert!((own - wanted).amax() < 1e-12 * rows as f64);
        }
    }
}
