//! What a generic family of functions has to say of itself to be fitted to all blocks but some.

use std::ops::Range;

/// A set of functions of the coordinates, of which a sum is fitted.
pub(super) trait Family {
    /// Its normal equations.
    type Equations: Equations;
    /// Those of no sample.
    fn none(&self) -> Self::Equations;
    /// Adds samples of a series to them.
    fn add(&self, to: &mut Self::Equations, series: &[f64], samples: Range<usize>);
    /// The sum with these coefficients at a sample; zero where it has no place.
    fn value(&self, coefficients: &[f64], sample: usize) -> f64;
}

/// Normal equations of a least-squares fit.
pub(super) trait Equations: Clone {
    /// The sum with `sign` times another's.
    fn plus(&mut self, other: &Self, sign: f64);
    /// Coefficients with `ridge`, which is above zero, added to the diagonal.
    fn solved(&self, ridge: f64) -> Vec<f64>;
}
