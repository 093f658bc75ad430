//! Products of a covariance where the number of its states is known to the compiler, in whole registers.
//!
//! `N` is that number and `B` the registers of a row, which is filled up with zeros.

use joint_core::work::Work;

use joint_simulation::lanes::{LANES, Lanes};

/// A row in whole registers.
type Row<const B: usize> = [Lanes; B];

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

/// Lays rows across.
pub(super) fn turn<const N: usize, const B: usize>(rows: &[f64], across: &mut [Lanes]) {
    let across = across.as_chunks_mut::<B>().0;
    for (i, row) in rows.as_chunks::<N>().0.iter().enumerate() {
        for (across, value) in across.iter_mut().zip(row) {
            across[i / LANES].0[i % LANES] = *value;
        }
    }
}

/// The product of a covariance with a row, few of whose entries are not zero.
pub(super) fn times<const N: usize, const B: usize>(
    lanes: &[Lanes],
    sensor: &[f64],
    product: &mut [f64],
) {
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

/// Adds so many times the square of a vector.
pub(super) struct AddSquare<'a, const N: usize, const B: usize>(
    pub(super) &'a mut [Lanes],
    pub(super) f64,
    pub(super) &'a [f64],
);

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

/// Adds so many times the product of two vectors, either way round.
pub(super) struct AddBothWays<'a, const N: usize, const B: usize>(
    pub(super) &'a mut [Lanes],
    pub(super) f64,
    pub(super) &'a [f64],
    pub(super) &'a [f64],
);

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

/// Carries a covariance along a transition, given by rows, and by columns filled up.
pub(super) struct Carry<'a, const N: usize, const B: usize>(
    pub(super) &'a [f64],
    pub(super) &'a [Lanes],
    pub(super) &'a mut [Lanes],
);

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
        let Self(weights, across, lanes) = self;
        let rows = lanes.as_chunks_mut::<B>().0.first_chunk_mut::<N>();
        let across = across.as_chunks::<B>().0.first_chunk::<N>();
        let weights = weights.as_chunks::<N>().0.first_chunk::<N>();
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
