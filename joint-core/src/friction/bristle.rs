//! The bristle at constant speed: a relaxation towards its slip value, up to 10⁸ times a second.
//!
//! Far stiffer than the step, but a scalar with a closed solution. This is its Padé (0,3) approximant:
//! with y = κ v the slip, x = |y| ρ and a = 1 + x/2 + x²/6, `ζ ← (ζ + y a) / (1 + x a)`. It is right to
//! third order in stick, exact in the slip limit, and stable at every step.

use crate::number::Number;

/// How a format computes the relaxation of a bristle.
pub trait Relaxation: Number {
    /// Unit of the slip in [`Relaxation::relaxed`], over the bristle's own: floats take 6^−⅓, which
    /// makes the cubic's first coefficient one and saves its product.
    const REACH: f64;
    /// One over it.
    const PER_REACH: Self;
    /// Coefficients of a = p + x (q + r x) there, where r is one in floats.
    const RELAXING: [Self; 2];
    /// One sixth.
    const SIXTH: Self;
    /// Eleven twelfths.
    const ELEVEN_TWELFTHS: Self;

    /// A bristle's slip at this speed, and what rounding has taken of those before: left out, a speed
    /// too small for the product would creep on.
    #[inline(always)]
    fn reached(self, gain: Self::Gain, lost: Self) -> (Self, Self) {
        (self.times(gain), lost)
    }

    /// A bristle at this deflection ζ after a slip of `reach` in units of [`Relaxation::REACH`], where
    /// it slips at `level = 1/rho`.
    #[inline(always)]
    fn relaxed(self, reach: Self, rho: Self, _level: Self) -> Self {
        let [p, q] = Self::RELAXING;
        let x = reach.abs() * rho;
        let a = p + x * (q + x);
        (self + reach * a).over(Self::ONE + x * a)
    }

    /// The same with what the sum has lost by rounding: in stick a motion too small for the sum would
    /// be forgotten, and the joint would creep.
    #[inline(always)]
    fn relaxed_exactly(self, lost: Self, reach: Self, rho: Self, _level: Self) -> (Self, Self) {
        let [p, q] = Self::RELAXING;
        let x = reach.abs() * rho;
        let a = p + x * (q + x);
        self.plus((a * (reach - self * x)).over(Self::ONE + x * a), lost)
    }

    /// A sixteenth of a number over [`Relaxation::REACH`].
    fn swing(self) -> Self;
}

/// 6^−⅓.
const FLOAT_REACH: f64 = 0.550_321_208_149_104_5;

macro_rules! float {
    ($float:ident) => {
        impl Relaxation for $float {
            const REACH: f64 = FLOAT_REACH;
            const PER_REACH: $float = (1.0 / FLOAT_REACH) as $float;
            const RELAXING: [$float; 2] =
                [(1.0 / FLOAT_REACH) as $float, (0.5 / (FLOAT_REACH * FLOAT_REACH)) as $float];
            const SIXTH: $float = 1.0 / 6.0;
            const ELEVEN_TWELFTHS: $float = 11.0 / 12.0;

            #[inline(always)]
            fn swing(self) -> $float {
                const SWING: $float = (0.0625 / FLOAT_REACH) as $float;
                self * SWING
            }
        }
    };
}

float!(f32);
float!(f64);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ways_of_relaxing_are_of_third_order_and_end_at_the_slip_value() {
        for (zeta, slip, rho) in
            [(0.3, 0.02, 0.7), (-0.9, 0.04, 0.8), (0.5, -0.03, 1.0), (0.2, 1e6, 0.6)]
        {
            let x: f64 = f64::abs(slip) * rho;
            let end = f64::signum(slip) / rho;
            let exact = end + (zeta - end) * (-x).exp();
            let reach = slip * f64::REACH;
            let (exactly, lost) = zeta.relaxed_exactly(0.0, reach, rho, 1.0 / rho);
            // What is left of the exponential's series, and rounding.
            let bound = (zeta - end).abs() * x.powi(4) * (-x).exp() / 24.0 + 1e-14;
            assert!((zeta.relaxed(reach, rho, 1.0 / rho) - exact).abs() < 2.0 * bound, "{slip}");
            assert!((exactly + lost - exact).abs() < 2.0 * bound, "{slip}");
        }
    }
}
