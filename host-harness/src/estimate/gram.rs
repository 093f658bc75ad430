//! The curvature of a sum of squares: a tall matrix's product with itself.
//!
//! It is symmetric, so half of its entries are asked for, and each core takes some of its columns.

use nalgebra::DMatrix;
use rayon::prelude::*;

/// `JᵀJ` of a matrix.
pub(crate) fn gram(jacobian: &DMatrix<f64>) -> DMatrix<f64> {
    let order = jacobian.ncols();
    let columns: Vec<Vec<f64>> = (0..order)
        .into_par_iter()
        .map(|j| {
            let own = jacobian.column(j);
            (0..=j).map(|i| jacobian.column(i).dot(&own)).collect()
        })
        .collect();
    DMatrix::from_fn(order, order, |i, j| columns[i.max(j)][i.min(j)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_the_entries_tell_the_others() {
        let tall = DMatrix::from_fn(40, 5, |i, j| ((1 + i * (j + 2)) as f64).sin());
        assert_eq!(gram(&tall), tall.tr_mul(&tall));
    }
}
