//! The covariance of a filter: what a measurement takes from it, and how it is carried on.
//!
//! A design does this at every sample, and it is most of what a design costs. So the number of states
//! is known to the compiler here, up to what a joint of three stages has, and rows are filled up with
//! zeros to whole registers.

use joint_core::work::Work;

use crate::lanes::{LANES, Lanes};
use crate::wide;

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

/// A row in whole registers.
type Row<const B: usize> = [Lanes; B];

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

    /// Adds to the variance of one state.
    pub(super) fn add_variance(&mut self, state: usize, variance: f64) {
        *self.own.at(state, state) += variance;
    }

    /// Carries it over an interval: `F P Fᵀ`.
    pub(super) fn carry(&mut self, over: &Transition) {
        let lanes = &mut self.own.lanes;
        of_order!(self.own.order, N B => wide::run(Carry::<N, B>(over, lanes)), self.carry_any(over));
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
        // Rounding keeps it symmetric.
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

/// A vector in whole registers.
#[inline(always)]
fn filled_up<const N: usize, const B: usize>(vector: &[f64]) -> Row<B> {
    let mut row = [Lanes::default(); B];
    for (lanes, own) in row.iter_mut().zip(vector[..N].chunks(LANES)) {
        lanes.0[..own.len()].copy_from_slice(own);
    }
    row
}

#[inline(always)]
fn add<const B: usize>(sum: &mut Row<B>, weight: f64, row: &Row<B>) {
    for (sum, row) in sum.iter_mut().zip(row) {
        *sum = *sum + Lanes::all(weight) * *row;
    }
}

fn turn<const N: usize, const B: usize>(rows: &[f64], across: &mut [Lanes]) {
    let across = across.as_chunks_mut::<B>().0;
    for (i, row) in rows.as_chunks::<N>().0.iter().enumerate() {
        for (across, value) in across.iter_mut().zip(row) {
            across[i / LANES].0[i % LANES] = *value;
        }
    }
}

fn times<const N: usize, const B: usize>(lanes: &[Lanes], sensor: &[f64], product: &mut [f64]) {
    let mut sum = [Lanes::default(); B];
    for (row, weight) in lanes.as_chunks::<B>().0.iter().zip(sensor) {
        if *weight != 0.0 {
            add(&mut sum, *weight, row);
        }
    }
    for (product, sum) in product[..N].chunks_mut(LANES).zip(&sum) {
        product.copy_from_slice(&sum.0[..product.len()]);
    }
}

struct AddSquare<'a, const N: usize, const B: usize>(&'a mut [Lanes], f64, &'a [f64]);

impl<const N: usize, const B: usize> Work for AddSquare<'_, N, B> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self(lanes, scale, vector) = self;
        let own = filled_up::<N, B>(vector);
        for (row, weight) in lanes.as_chunks_mut::<B>().0.iter_mut().zip(&vector[..N]) {
            let weight = scale * weight;
            if weight != 0.0 {
                add(row, weight, &own);
            }
        }
    }
}

struct AddBothWays<'a, const N: usize, const B: usize>(&'a mut [Lanes], f64, &'a [f64], &'a [f64]);

impl<const N: usize, const B: usize> Work for AddBothWays<'_, N, B> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self(lanes, scale, one, other) = self;
        let (a, b) = (filled_up::<N, B>(one), filled_up::<N, B>(other));
        let rows = lanes.as_chunks_mut::<B>().0.iter_mut();
        for ((row, one), other) in rows.zip(&one[..N]).zip(&other[..N]) {
            let [by_a, by_b] = [Lanes::all(scale * other), Lanes::all(scale * one)];
            for ((row, a), b) in row.iter_mut().zip(&a).zip(&b) {
                *row = *row + (by_a * *a + by_b * *b);
            }
        }
    }
}

struct Carry<'a, const N: usize, const B: usize>(&'a Transition, &'a mut [Lanes]);

/// Rows of a product that are summed side by side: a sum waits for itself.
const ABREAST: usize = 4;

/// Sums over `k` of rows by their weights, for as many rows of weights as are summed side by side.
#[inline(always)]
fn sums<const N: usize>(
    weight: impl Fn(usize, usize) -> f64,
    row: impl Fn(usize) -> Lanes,
) -> [Lanes; ABREAST] {
    let [mut a, mut b, mut c, mut d] = [Lanes::default(); ABREAST];
    for k in 0..N {
        let row = row(k);
        a = a + Lanes::all(weight(0, k)) * row;
        b = b + Lanes::all(weight(1, k)) * row;
        c = c + Lanes::all(weight(2, k)) * row;
        d = d + Lanes::all(weight(3, k)) * row;
    }
    [a, b, c, d]
}

impl<const N: usize, const B: usize> Work for Carry<'_, N, B> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self(over, lanes) = self;
        let rows = lanes.as_chunks_mut::<B>().0.first_chunk_mut::<N>();
        let across = over.across.lanes.as_chunks::<B>().0.first_chunk::<N>();
        let weights = over.rows.as_chunks::<N>().0.first_chunk::<N>();
        let (Some(rows), Some(across), Some(weights)) = (rows, across, weights) else { return };
        // The last rows stand beside some that are done already.
        let firsts = (0..N).step_by(ABREAST).map(|first| first.min(N - ABREAST));
        let mut half = [[Lanes::default(); B]; N];
        for first in firsts.clone() {
            for block in 0..B {
                let done = sums::<N>(|i, k| weights[first + i][k], |k| rows[k][block]);
                for (i, sum) in done.into_iter().enumerate() {
                    half[first + i][block] = sum;
                }
            }
        }
        for first in firsts {
            // What is above the diagonal follows from what is below it, so that rounding keeps it symmetric.
            for block in 0..=(first + ABREAST - 1) / LANES {
                let weight = |i: usize, k: usize| half[first + i][k / LANES].0[k % LANES];
                let done = sums::<N>(weight, |k| across[k][block]);
                for (i, sum) in done.into_iter().enumerate() {
                    rows[first + i][block] = sum;
                }
            }
        }
        for i in 0..N {
            for j in 0..i {
                rows[j][i / LANES].0[i % LANES] = rows[i][j / LANES].0[j % LANES];
            }
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
