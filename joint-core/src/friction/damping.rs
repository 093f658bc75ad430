//! A kick of a damped speed: the implicit midpoint rule.
//!
//! Over a kick friction acts as a damping c, and a mass loses the share 2x = c τ/J of its speed. The
//! rule's quotient 1/(1 + x) is expanded, to x² in the middle kick and to x in the shorter outer ones.

use crate::number::Number;

/// How a format kicks a damped speed.
pub trait Damped: Number {
    /// A speed after a gain at which it would lose the share `lost` = 2x of itself, with x² where that
    /// is asked for.
    #[inline(always)]
    fn kicked<const SQUARE: bool>(self, gained: Self, lost: Self) -> Self {
        let x = lost.half();
        let taken = if SQUARE { Self::ONE - x + x * x } else { Self::ONE - x };
        self + gained * taken
    }

    /// A gain of speed without what rounding alone may have made: one unit of the last place would keep
    /// a joint in stick trembling, and so creeping. Floats lose it in the sum.
    #[inline(always)]
    fn settled(self) -> Self {
        self
    }

    /// A force in the middle kick with what damping makes of its rise since the step's start: the part
    /// −(ḟ ∂a/∂v) h²/48 of the splitting's double commutator, ḟ as the rise to the step's middle and
    /// `lost` the share of the speed that damping takes. Left out in fixed point, which is held to 2 %
    /// and where products are dear.
    #[inline(always)]
    fn risen(self, began: Self, lost: Self) -> Self {
        self + lost.half().eighth().nearest(self - began)
    }
}

impl Damped for f32 {}
impl Damped for f64 {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kick_is_the_midpoint_rules_to_the_order_of_its_expansion() {
        for lost in [-0.2_f64, 0.02, 0.2] {
            let (x, gained) = (0.5 * lost, 3.0);
            let missed = |found: f64| (found - 1.0 - gained / (1.0 + x)) / gained * (1.0 + x);
            // 1/(1 + x) less its expansion is −x³/(1 + x), or x²/(1 + x).
            assert!((missed(1.0.kicked::<true>(gained, lost)) - x.powi(3)).abs() < 1e-14, "{x}");
            assert!((missed(1.0.kicked::<false>(gained, lost)) + x * x).abs() < 1e-14, "{x}");
        }
    }

    #[test]
    fn a_force_that_rises_is_raised_by_a_sixteenth_of_the_share_lost() {
        assert_eq!(2.0_f64.risen(0.5, 0.25), 2.0 + 1.5 * 0.25 / 16.0);
    }
}
