//! The covariance of a filter: what a measurement takes from it, and how it is carried on.
//!
//! A design does this at every sample, and it is most of what a design costs. So the number of states
//! is known to the compiler here, up to what a joint of three stages has, and rows are filled up with
//! zeros to whole registers.

use super::whole_registers::{AddBothWays, AddSquare, Carry, times, turn};
use joint_simulation::lanes::{LANES, Lanes};
use joint_simulation::wide;

/// Does with an order and the registers of a row as constants what is written for them, or what is
/// written for all others.
macro_rules! of_order {
    ($order:expr, $n:ident $b:ident => $known:expr, $other:expr) => {
        of_order!($order, $n $b => $known, $other, 4 5 6 7 8 9 10 11 12 13 14 15 16)
    };
    ($order:expr, $n:ident $b:ident => $known:expr, $other:expr, $($value:literal)*) => {
        match $order {
            $($value => {
                const $n: usize = $value;
                const $b: usize = blocks($n);
                $known
            })*
            _ => $other,
        }
    };
}

/// Registers of a row.
const fn blocks(order: usize) -> usize {
    order.div_ceil(LANES)
}

/// A square matrix of that many states, by rows that are filled up with zeros.
#[derive(Clone, Debug)]
struct Square {
    order: usize,
    lanes: Vec<Lanes>,
}

impl Square {
    fn zero(order: usize) -> Self {
        Self { order, lanes: vec![Lanes::default(); order * blocks(order)] }
    }

    fn at(&mut self, row: usize, column: usize) -> &mut f64 {
        &mut self.lanes[row * blocks(self.order) + column / LANES].0[column % LANES]
    }

    fn rows(&self) -> impl Iterator<Item = &[Lanes]> {
        self.lanes.chunks_exact(blocks(self.order).max(1))
    }

    fn rows_mut(&mut self) -> impl Iterator<Item = &mut [Lanes]> {
        self.lanes.chunks_exact_mut(blocks(self.order).max(1))
    }
}

/// How the states follow from those an interval before, as covariances are carried along it.
#[derive(Clone, Debug)]
pub(super) struct Transition {
    /// By rows, not filled up: derivative of each state with each.
    rows: Vec<f64>,
    /// The same by columns.
    across: Square,
}

impl Transition {
    /// Of that many states, none of which follows from another.
    pub(super) fn none(order: usize) -> Self {
        Self { rows: vec![0.0; order * order], across: Square::zero(order) }
    }

    /// Becomes another of as many states.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.rows.copy_from_slice(&other.rows);
        self.across.lanes.copy_from_slice(&other.across.lanes);
    }

    /// By rows: derivative of each state with each.
    pub(super) fn rows(&self) -> &[f64] {
        &self.rows
    }

    /// By columns, filled up with zeros.
    pub(super) fn across(&self) -> &[Lanes] {
        &self.across.lanes
    }

    /// Sets the rows.
    pub(super) fn set(&mut self, change: impl FnOnce(&mut [f64])) {
        change(&mut self.rows);
        let Self { rows, across } = self;
        of_order!(across.order, N B => turn::<N, B>(rows, &mut across.lanes), {
            let order = across.order;
            for (k, value) in rows.iter().enumerate() {
                *across.at(k % order, k / order) = *value;
            }
        });
    }
}

/// A symmetric matrix of that many states.
#[derive(Clone, Debug)]
pub(super) struct Covariance {
    own: Square,
}

impl Covariance {
    /// Of states that are independent, by their one sigma.
    pub(super) fn independent(sigmas: impl ExactSizeIterator<Item = f64>) -> Self {
        let mut own = Square::zero(sigmas.len());
        for (k, sigma) in sigmas.enumerate() {
            *own.at(k, k) = sigma * sigma;
        }
        Self { own }
    }

    /// Its product with a sensor's row, few of whose entries are not zero.
    pub(super) fn times(&self, sensor: &[f64], product: &mut [f64]) {
        of_order!(self.own.order, N B => times::<N, B>(&self.own.lanes, sensor, product), {
            product.fill(0.0);
            for (row, weight) in self.own.rows().zip(sensor).filter(|(_, weight)| **weight != 0.0) {
                for (sum, own) in product.iter_mut().zip(row.iter().flat_map(|lanes| lanes.0)) {
                    *sum += weight * own;
                }
            }
        });
    }

    /// Adds `scale` times the square of a vector.
    pub(super) fn add_square(&mut self, scale: f64, vector: &[f64]) {
        let lanes = &mut self.own.lanes;
        of_order!(self.own.order, N B => wide::run(AddSquare::<N, B>(lanes, scale, vector)), {
            for (row, own) in self.own.rows_mut().zip(vector) {
                add_scaled(row, scale * own, vector);
            }
        });
    }

    /// Adds `scale` times the product of two vectors, either way round.
    pub(super) fn add_both_ways(&mut self, scale: f64, one: &[f64], other: &[f64]) {
        let lanes = &mut self.own.lanes;
        of_order!(self.own.order, N B => wide::run(AddBothWays::<N, B>(lanes, scale, one, other)), {
            for ((row, own), across) in self.own.rows_mut().zip(one).zip(other) {
                add_scaled(row, scale * own, other);
                add_scaled(row, scale * across, one);
            }
        });
    }

    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        self.own.lanes.fill(Lanes::default());
    }

    /// The variance of one state.
    pub(super) fn variance(&mut self, state: usize) -> f64 {
        *self.own.at(state, state)
    }

    /// Adds to the variance of one state.
    pub(super) fn add_variance(&mut self, state: usize, variance: f64) {
        *self.own.at(state, state) += variance;
    }

    /// Carries it over an interval: `F P Fᵀ`.
    pub(super) fn carry(&mut self, over: &Transition) {
        let lanes = &mut self.own.lanes;
        of_order!(self.own.order, N B => wide::run(Carry::<N, B>(over.rows(), over.across(), lanes)), self.carry_any(over));
    }

    fn carry_any(&mut self, over: &Transition) {
        let order = self.own.order;
        let mut half = Square::zero(order);
        for (half, row) in half.rows_mut().zip(over.rows.chunks_exact(order)) {
            add_products(half, row.iter().copied(), &self.own);
        }
        for (row, half) in self.own.rows_mut().zip(half.rows()) {
            row.fill(Lanes::default());
            add_products(row, half.iter().flat_map(|lanes| lanes.0), &over.across);
        }
        // Rounding must keep it symmetric.
        for i in 0..order {
            for j in 0..i {
                *self.own.at(j, i) = *self.own.at(i, j);
            }
        }
    }
}

fn add_products(sum: &mut [Lanes], weights: impl Iterator<Item = f64>, rows: &Square) {
    for (weight, row) in weights.zip(rows.rows()) {
        for (sum, row) in sum.iter_mut().zip(row) {
            *sum = *sum + Lanes::all(weight) * *row;
        }
    }
}

fn add_scaled(sum: &mut [Lanes], scale: f64, vector: &[f64]) {
    if scale != 0.0 {
        let sum = sum.iter_mut().flat_map(|lanes| &mut lanes.0);
        for (sum, value) in sum.zip(vector) {
            *sum += scale * value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn over(order: usize, rows: &[f64]) -> Transition {
        let mut over = Transition::none(order);
        over.set(|own| own.copy_from_slice(rows));
        over
    }

    fn transition(order: usize) -> Vec<f64> {
        (0..order * order).map(|k| (0.7 * k as f64).sin()).collect()
    }

    #[test]
    fn what_is_carried_is_what_the_product_says_at_every_order() {
        for order in 3..20 {
            let sigmas: Vec<f64> = (0..order).map(|k| 1.0 + k as f64).collect();
            let mut own = Covariance::independent(sigmas.iter().copied());
            let f = transition(order);
            own.carry(&over(order, &f));
            for i in 0..order {
                for j in 0..order {
                    let terms =
                        (0..order).map(|k| f[i * order + k] * sigmas[k].powi(2) * f[j * order + k]);
                    let wanted: f64 = terms.sum();
                    let found = *own.own.at(i, j);
                    assert!((found - wanted).abs() < 1e-9, "{order}: {i} {j}: {found} {wanted}");
                }
            }
        }
    }

    #[test]
    fn a_measurement_takes_what_it_tells() {
        let mut own = Covariance::independent([2.0, 3.0, 1.0].into_iter());
        own.carry(&over(3, &[1.0, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]));
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
