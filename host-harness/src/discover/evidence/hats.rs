//! Piecewise linear functions, fitted by least squares: the generic family's one building block.
//!
//! A sum of hat functions on an even grid can follow any smooth curve of a coordinate; its normal
//! equations are tridiagonal, so that leaving out every block in turn costs next to nothing.

use super::family::{Equations, Family};

/// Where samples stand on a grid of knots: the knot before each, and what it and the one after count.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    places: Vec<Option<(usize, [f64; 2])>>,
    knots: usize,
}

impl Grid {
    /// Of a coordinate, by `knots` between its ends; by the sign of `direction` twice as many. A value
    /// that is no number has no place. `None` where the coordinate does not move.
    pub(super) fn new(values: &[f64], direction: Option<&[f64]>, knots: usize) -> Option<Self> {
        let finite = values.iter().copied().filter(|value| value.is_finite());
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = finite.fold(ends, |(low, high), x| (low.min(x), high.max(x)));
        if high <= low || !(high - low).is_finite() || knots < 2 {
            return None;
        }
        let last = knots - 1;
        let place = |(k, value): (usize, &f64)| {
            value.is_finite().then(|| {
                let along = (value - low) / (high - low) * last as f64;
                let knot = (along as usize).min(last - 1);
                let back = direction.is_some_and(|direction| direction[k] < 0.0);
                let share = along - knot as f64;
                (knot + if back { knots } else { 0 }, [1.0 - share, share])
            })
        };
        let places = values.iter().enumerate().map(place).collect();
        Some(Self { places, knots: if direction.is_some() { 2 * knots } else { knots } })
    }

    /// The same as the coefficient of another quantity, by its RMS; where that is no number a sample has no
    /// place. `None` where it is zero everywhere.
    pub(super) fn times(mut self, weights: &[f64]) -> Option<Self> {
        let finite = weights.iter().filter(|weight| weight.is_finite());
        let (squares, count) =
            finite.fold((0.0, 0.0), |(sum, count), weight| (sum + weight * weight, count + 1.0));
        let rms = f64::sqrt(squares / f64::max(count, 1.0));
        if rms <= 0.0 || !rms.is_finite() {
            return None;
        }
        for (place, weight) in self.places.iter_mut().zip(weights) {
            let weight = weight / rms;
            *place = place
                .filter(|_| weight.is_finite())
                .map(|(knot, shares)| (knot, shares.map(|share| share * weight)));
        }
        Some(self)
    }
}

impl Family for Grid {
    type Equations = Tridiagonal;

    fn none(&self) -> Tridiagonal {
        let none = || vec![0.0; self.knots];
        Tridiagonal { diagonal: none(), beside: none(), right: none() }
    }

    fn add(&self, to: &mut Tridiagonal, series: &[f64], samples: std::ops::Range<usize>) {
        for k in samples {
            let Some((knot, [here, next])) = self.places[k] else { continue };
            to.diagonal[knot] += here * here;
            to.diagonal[knot + 1] += next * next;
            to.beside[knot] += here * next;
            to.right[knot] += here * series[k];
            to.right[knot + 1] += next * series[k];
        }
    }

    fn value(&self, coefficients: &[f64], sample: usize) -> f64 {
        self.places[sample].map_or(0.0, |(knot, [here, next])| {
            coefficients[knot] * here + coefficients[knot + 1] * next
        })
    }
}

/// Normal equations of a least-squares fit, which are tridiagonal.
#[derive(Clone, Debug)]
pub(super) struct Tridiagonal {
    diagonal: Vec<f64>,
    beside: Vec<f64>,
    right: Vec<f64>,
}

impl Equations for Tridiagonal {
    fn plus(&mut self, other: &Self, sign: f64) {
        let pairs = [
            (&mut self.diagonal, &other.diagonal),
            (&mut self.beside, &other.beside),
            (&mut self.right, &other.right),
        ];
        for (own, other) in pairs {
            own.iter_mut().zip(other).for_each(|(own, other)| *own += sign * other);
        }
    }

    /// By Thomas' elimination.
    fn solved(&self, ridge: f64) -> Vec<f64> {
        let count = self.diagonal.len();
        let (mut above, mut right) = (vec![0.0; count], vec![0.0; count]);
        let (mut carried, mut known) = (0.0, 0.0);
        for k in 0..count {
            let below = if k > 0 { self.beside[k - 1] } else { 0.0 };
            let pivot = self.diagonal[k] + ridge - below * carried;
            above[k] = self.beside[k] / pivot;
            right[k] = (self.right[k] - below * known) / pivot;
            (carried, known) = (above[k], right[k]);
        }
        for k in (0..count.saturating_sub(1)).rev() {
            right[k] -= above[k] * right[k + 1];
        }
        right
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_piecewise_line_is_found_again() {
        let values: Vec<f64> = (0..1000).map(|k| f64::from(k) * 0.01).collect();
        let grid = Grid::new(&values, None, 6).unwrap();
        let wanted = [1.0, -2.0, 0.5, 3.0, 3.0, -1.0];
        let series: Vec<f64> = (0..1000).map(|k| grid.value(&wanted, k)).collect();
        let mut normal = grid.none();
        grid.add(&mut normal, &series, 0..1000);
        // The ridge pulls by its share of some hundred samples a knot.
        for (found, wanted) in normal.solved(1e-9).iter().zip(wanted) {
            assert!((found - wanted).abs() < 1e-8, "{found} {wanted}");
        }
    }

    #[test]
    fn each_direction_has_a_curve_of_its_own() {
        let values: Vec<f64> = (0..400).map(|k| f64::from(k % 100)).collect();
        let direction: Vec<f64> = (0..400).map(|k| if k < 200 { 1.0 } else { -1.0 }).collect();
        let grid = Grid::new(&values, Some(&direction), 4).unwrap();
        let mut normal = grid.none();
        grid.add(&mut normal, &direction, 0..400);
        let found = normal.solved(1e-9);
        assert!(found[..4].iter().all(|c| (c - 1.0).abs() < 1e-6), "{found:?}");
        assert!(found[4..].iter().all(|c| (c + 1.0).abs() < 1e-6), "{found:?}");
    }

    #[test]
    fn a_coefficient_that_varies_is_found_again() {
        let values: Vec<f64> = (0..1000).map(|k| f64::from(k) * 0.01).collect();
        let current: Vec<f64> = (0..1000).map(|k| 3.0 * (f64::from(k) * 0.07).sin()).collect();
        let rms = (current.iter().map(|i| i * i).sum::<f64>() / 1000.0).sqrt();
        let grid = Grid::new(&values, None, 4).unwrap();
        let wanted = [1.0, -2.0, 0.5, 3.0];
        let series: Vec<f64> = (0..1000).map(|k| grid.value(&wanted, k) * current[k]).collect();
        let grid = grid.times(&current).unwrap();
        let mut normal = grid.none();
        grid.add(&mut normal, &series, 0..1000);
        for (found, wanted) in normal.solved(1e-9).iter().zip(wanted) {
            assert!((found - wanted * rms).abs() < 1e-7, "{found} {wanted}");
        }
        assert!(Grid::new(&values, None, 4).unwrap().times(&[0.0; 1000]).is_none());
    }

    #[test]
    fn what_stands_still_or_is_no_number_has_no_grid() {
        assert!(Grid::new(&[1.0; 10], None, 4).is_none());
        assert!(Grid::new(&[f64::NAN; 10], None, 4).is_none());
        let grid = Grid::new(&[0.0, f64::NAN, 1.0], None, 2).unwrap();
        assert_eq!(grid.value(&[5.0, 5.0], 1), 0.0);
    }

    #[test]
    fn a_value_lies_on_the_line_between_its_knots_and_a_standstill_counts_as_forward() {
        let values = [0.0, 0.25, 1.5, 2.0, 3.0];
        let grid = Grid::new(&values, Some(&[1.0, 0.0, 0.0, -1.0, -1.0]), 4).unwrap();
        let coefficients = [0.0, 1.0, 2.0, 3.0, 10.0, 11.0, 12.0, 13.0];
        let told = [0, 1, 2, 3, 4].map(|k| grid.value(&coefficients, k));
        assert_eq!(told, [0.0, 0.25, 1.5, 12.0, 13.0]);
    }

    #[test]
    fn samples_that_are_taken_away_again_leave_no_trace_and_a_ridge_pulls_to_zero() {
        let grid = Grid::new(&[0.0, 1.0, 0.0, 1.0, 0.5], None, 2).unwrap();
        let [mut all, mut part] = [grid.none(), grid.none()];
        let series = [2.0, 6.0, 4.0, 8.0, 100.0];
        grid.add(&mut all, &series, 0..5);
        grid.add(&mut part, &series, 4..5);
        all.plus(&part, -1.0);
        // Two samples at each knot, and two more that are zero.
        assert_eq!(all.solved(2.0), [6.0 / 4.0, 14.0 / 4.0]);
        all.plus(&part, 1.0);
        let mut whole = grid.none();
        grid.add(&mut whole, &series, 0..5);
        assert_eq!(all.solved(1.0), whole.solved(1.0));
    }
}
