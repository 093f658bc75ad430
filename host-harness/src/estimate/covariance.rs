//! The covariance of a filter: what a measurement takes from it, and how it is carried on.
//!
//! A design does this at every sample, and it is most of what a design costs. So the number of states
//! is known to the compiler here, up to what a joint of three stages has.

use joint_core::work::Work;

use crate::wide;

/// Does with an order as a constant what is written for it, or what is written for all others.
macro_rules! of_order {
    ($order:expr, $n:ident => $known:expr, $other:expr) => {
        of_order!($order, $n => $known, $other, 3 4 5 6 7 8 9 10 11 12 13 14 15 16)
    };
    ($order:expr, $n:ident => $known:expr, $other:expr, $($value:literal)*) => {
        match $order {
            $($value => {
                const $n: usize = $value;
                $known
            })*
            _ => $other,
        }
    };
}

/// A symmetric matrix of that many states, by rows.
#[derive(Clone, Debug)]
pub(super) struct Covariance {
    order: usize,
    rows: Vec<f64>,
    half: Vec<f64>,
    across: Vec<f64>,
}

impl Covariance {
    /// Of states that are independent, by their one sigma.
    pub(super) fn independent(sigmas: impl ExactSizeIterator<Item = f64>) -> Self {
        let order = sigmas.len();
        let mut rows = vec![0.0; order * order];
        for (k, sigma) in sigmas.enumerate() {
            rows[k * order + k] = sigma * sigma;
        }
        Self { order, rows, half: vec![0.0; order * order], across: vec![0.0; order * order] }
    }

    /// Its product with a sensor's row, few of whose entries are not zero.
    pub(super) fn times(&self, sensor: &[f64], product: &mut [f64]) {
        of_order!(self.order, N => times::<N>(&self.rows, sensor, product), {
            product.fill(0.0);
            for (row, weight) in self.rows.chunks_exact(self.order).zip(sensor) {
                add_scaled(product, *weight, row);
            }
        });
    }

    /// Adds `scale` times the square of a vector.
    pub(super) fn add_square(&mut self, scale: f64, vector: &[f64]) {
        let rows = &mut self.rows;
        of_order!(self.order, N => wide::run(AddSquare::<N>(rows, scale, vector)), {
            for (row, own) in rows.chunks_exact_mut(self.order).zip(vector) {
                add_scaled(row, scale * own, vector);
            }
        });
    }

    /// Adds `scale` times the product of two vectors, either way round.
    pub(super) fn add_both_ways(&mut self, scale: f64, one: &[f64], other: &[f64]) {
        let rows = &mut self.rows;
        of_order!(self.order, N => wide::run(AddBothWays::<N>(rows, scale, one, other)), {
            for ((row, own), across) in rows.chunks_exact_mut(self.order).zip(one).zip(other) {
                add_scaled(row, scale * own, other);
                add_scaled(row, scale * across, one);
            }
        });
    }

    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        self.rows.fill(0.0);
    }

    /// Adds to the variance of one state.
    pub(super) fn add_variance(&mut self, state: usize, variance: f64) {
        self.rows[state * self.order + state] += variance;
    }

    /// Carries it over an interval: `F P Fᵀ`, with `F` by rows.
    pub(super) fn carry(&mut self, transition: &[f64]) {
        let rows = &mut self.rows;
        of_order!(self.order, N => wide::run(Carry::<N>(transition, rows)), self.carry_any(transition));
    }

    fn carry_any(&mut self, transition: &[f64]) {
        let order = self.order;
        for (i, row) in transition.chunks_exact(order).enumerate() {
            for (j, value) in row.iter().enumerate() {
                self.across[j * order + i] = *value;
            }
        }
        product(order, transition, &self.rows, &mut self.half);
        product(order, &self.half, &self.across, &mut self.rows);
        mirror(order, &mut self.rows);
    }
}

/// What is above the diagonal becomes what is below it, so that rounding keeps it symmetric.
fn mirror(order: usize, rows: &mut [f64]) {
    for i in 0..order {
        for j in 0..i {
            rows[j * order + i] = rows[i * order + j];
        }
    }
}

fn add_scaled(sum: &mut [f64], scale: f64, vector: &[f64]) {
    if scale != 0.0 {
        for (sum, value) in sum.iter_mut().zip(vector) {
            *sum += scale * value;
        }
    }
}

fn times<const N: usize>(rows: &[f64], sensor: &[f64], product: &mut [f64]) {
    let mut sum = [0.0; N];
    for (row, weight) in rows.as_chunks::<N>().0.iter().zip(sensor) {
        if *weight != 0.0 {
            for (sum, own) in sum.iter_mut().zip(row) {
                *sum += weight * own;
            }
        }
    }
    product[..N].copy_from_slice(&sum);
}

struct AddSquare<'a, const N: usize>(&'a mut [f64], f64, &'a [f64]);

impl<const N: usize> Work for AddSquare<'_, N> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self(rows, scale, vector) = self;
        let mut own = [0.0; N];
        own.copy_from_slice(&vector[..N]);
        for (row, weight) in rows.as_chunks_mut::<N>().0.iter_mut().zip(own) {
            let weight = scale * weight;
            if weight != 0.0 {
                for (row, own) in row.iter_mut().zip(own) {
                    *row += weight * own;
                }
            }
        }
    }
}

struct AddBothWays<'a, const N: usize>(&'a mut [f64], f64, &'a [f64], &'a [f64]);

impl<const N: usize> Work for AddBothWays<'_, N> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self(rows, scale, one, other) = self;
        let (mut a, mut b) = ([0.0; N], [0.0; N]);
        a.copy_from_slice(&one[..N]);
        b.copy_from_slice(&other[..N]);
        for (k, row) in rows.as_chunks_mut::<N>().0.iter_mut().enumerate().take(N) {
            let [by_a, by_b] = [scale * b[k], scale * a[k]];
            for ((row, a), b) in row.iter_mut().zip(a).zip(b) {
                *row += by_a * a + by_b * b;
            }
        }
    }
}

fn product(order: usize, left: &[f64], right: &[f64], out: &mut [f64]) {
    out.fill(0.0);
    for (left, out) in left.chunks_exact(order).zip(out.chunks_exact_mut(order)) {
        for (left, right) in left.iter().zip(right.chunks_exact(order)) {
            for (out, right) in out.iter_mut().zip(right) {
                *out += left * right;
            }
        }
    }
}

struct Carry<'a, const N: usize>(&'a [f64], &'a mut [f64]);

impl<const N: usize> Work for Carry<'_, N> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self(transition, all) = self;
        let (transition, rows) = (transition.as_chunks::<N>().0, all.as_chunks_mut::<N>().0);
        let mut across = [[0.0; N]; N];
        for (i, row) in transition.iter().enumerate() {
            for (across, value) in across.iter_mut().zip(row) {
                across[i] = *value;
            }
        }
        let row_times = |left: &[f64; N], right: &[[f64; N]]| {
            let mut sum = [0.0; N];
            for (left, right) in left.iter().zip(right) {
                for (sum, right) in sum.iter_mut().zip(right) {
                    *sum += left * right;
                }
            }
            sum
        };
        let mut half = [[0.0; N]; N];
        for (half, row) in half.iter_mut().zip(transition) {
            *half = row_times(row, rows);
        }
        for (row, half) in rows.iter_mut().zip(&half) {
            *row = row_times(half, &across);
        }
        mirror(N, all);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn transition(order: usize) -> Vec<f64> {
        (0..order * order).map(|k| (0.7 * k as f64).sin()).collect()
    }

    #[test]
    fn what_is_carried_is_what_the_product_says_at_every_order() {
        for order in 3..20 {
            let sigmas: Vec<f64> = (0..order).map(|k| 1.0 + k as f64).collect();
            let mut own = Covariance::independent(sigmas.iter().copied());
            let f = transition(order);
            own.carry(&f);
            for i in 0..order {
                for j in 0..order {
                    let terms =
                        (0..order).map(|k| f[i * order + k] * sigmas[k].powi(2) * f[j * order + k]);
                    let wanted: f64 = terms.sum();
                    let found = own.rows[i * order + j];
                    assert!((found - wanted).abs() < 1e-9, "{order}: {i} {j}: {found} {wanted}");
                }
            }
        }
    }

    #[test]
    fn a_measurement_takes_what_it_tells() {
        let mut own = Covariance::independent([2.0, 3.0, 1.0].into_iter());
        own.carry(&[1.0, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
        let mut column = [0.0; 3];
        own.times(&[1.0, 0.0, 0.0], &mut column);
        assert_eq!(column, [6.25, 4.5, 0.0]);
        own.add_square(-1.0 / (6.25 + 1.0), &column);
        own.times(&[1.0, 0.0, 0.0], &mut column);
        assert!((column[0] - 6.25 / 7.25).abs() < 1e-12);
        own.add_variance(2, 3.0);
        own.times(&[0.0, 0.0, 1.0], &mut column);
        assert_eq!(column, [0.0, 0.0, 4.0]);
    }
}
