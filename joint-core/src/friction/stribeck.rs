//! The Stribeck curve 1/ρ = g(v)/α0 = 1 + β exp(−(v/v0)²), equation (3), and how it bends.

use crate::number::{Elementary, Number, horner};

/// How a format computes the Stribeck curve.
pub trait Stribeck: Number {
    /// Unit of the square 2(v/v0)² in [`Stribeck::stribeck`]: f32 takes the one that makes its
    /// polynomial's first coefficient one and saves its product.
    const SQUARE: f64;

    /// Of a curve 1 + β exp(−s/2), for `s ≥ 0` in units of [`Stribeck::SQUARE`] and β above −1: the
    /// share of it that exceeds one, `β / (exp(s/2) + β)`, and the curve itself. Absolute error of the
    /// exponential below 4e-5 (f32) and 1e-10 (f64).
    fn stribeck(self, beta: Self) -> (Self, Self);

    /// What is in units of [`Stribeck::SQUARE`] in units of one.
    #[inline(always)]
    fn per_square(self) -> Self {
        self
    }
}

/// Cube root of the cubic's first coefficient in f32.
const CUBE: f64 = 0.036826556131;

impl Stribeck for f32 {
    const SQUARE: f64 = CUBE;

    /// The exponential is the eighth power of a cubic: it needs no end of its range, since its
    /// inverse goes to zero with it.
    #[inline(always)]
    fn stribeck(self, beta: f32) -> (f32, f32) {
        let root = horner!(self, f32, 1.0, 1.416_852, 1.697_819_6, 1.0);
        let square = root * root;
        let fourth = square * square;
        let grown = fourth * fourth;
        (beta / (grown + beta), 1.0 + beta / grown)
    }
    #[inline(always)]
    fn per_square(self) -> f32 {
        self * (1.0 / CUBE) as f32
    }
}

impl Stribeck for f64 {
    const SQUARE: f64 = 1.0;

    #[inline(always)]
    fn stribeck(self, beta: f64) -> (f64, f64) {
        let excess = beta * (0.5 * self).exp_minus();
        (excess / (1.0 + excess), 1.0 + excess)
    }
}

/// The Stribeck curve at one speed.
#[derive(Clone, Copy)]
pub(crate) struct Curve<S> {
    /// 1/ρ = g(v)/α0.
    pub(super) level: S,
    /// ρ = α0/g(v).
    pub(crate) rho: S,
    /// v ρ' over the unit of the square.
    pub(super) steepness: S,
}

impl<S: Stribeck> Curve<S> {
    /// At a speed over v0/√2, in the root of [`Stribeck::SQUARE`].
    #[inline(always)]
    pub(super) fn at(relative: S, beta: &S) -> Self {
        let square = relative.squared();
        let (excess, level) = square.stribeck(*beta);
        let rho = S::ONE - excess;
        Self { level, rho, steepness: rho * excess * square }
    }

    /// Slope of |v| ρ, the bristle's slip over ζ.
    #[inline(always)]
    pub(crate) fn slope(&self) -> S {
        self.rho + self.steepness.per_square()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_excess_of_a_stribeck_curve_keeps_its_stated_error_and_ends_at_zero() {
        let sweep = |high: f64| (0..=4000).map(move |k| high * f64::from(k) / 4000.0);
        for beta in [-0.9, -0.3, 0.4, 2.0] {
            for s in sweep(160.0).chain(sweep(4.0)) {
                let exact = beta / ((0.5 * s).exp() + beta);
                // The error 4e-5 of exp(−s/2) grows by β/(1 + β exp(−s/2))².
                let bound = 4e-5 * beta.abs() / (1.0 + beta.min(0.0)).powi(2) + 1e-6;
                let narrow = f64::from(((s * f32::SQUARE) as f32).stribeck(beta as f32).0);
                assert!((narrow - exact).abs() < bound, "f32 at {s}, {beta}: {narrow} {exact}");
                assert!((s.stribeck(beta).0 - exact).abs() < 1e-8, "f64 at {s}, {beta}");
            }
            assert_eq!(1e9_f32.stribeck(beta as f32).0, 0.0);
            assert_eq!(f32::MAX.stribeck(beta as f32).0, 0.0);
            assert!(1e9_f64.stribeck(beta).0.abs() < 1e-20);
        }
    }

    #[test]
    fn a_curve_and_its_slope_are_the_same_in_both_floats() {
        for beta in [-0.3, 0.4] {
            let rho = |v: f64| 1.0 / (1.0 + beta * (-v * v).exp());
            for v in [0.0, 0.2, 0.7, 1.0, 1.6] {
                let slope = rho(v) + v * (rho(v + 1e-5) - rho(v - 1e-5)) / 2e-5;
                let wide = Curve::at(v * 2.0_f64.sqrt(), &beta);
                let narrow = Curve::at((v * (2.0 * f32::SQUARE).sqrt()) as f32, &(beta as f32));
                for (found, exact, bound) in [
                    (wide.level, 1.0 / rho(v), 1e-9),
                    (wide.slope(), slope, 1e-8),
                    (f64::from(narrow.level), 1.0 / rho(v), 1e-4),
                    (f64::from(narrow.rho), rho(v), 1e-4),
                    // The exponential's error of 4e-5 times 2 v² and what β makes of it.
                    (f64::from(narrow.slope()), slope, 5e-4),
                ] {
                    assert!((found - exact).abs() < bound, "{beta} {v}: {found} {exact}");
                }
            }
        }
    }
}
