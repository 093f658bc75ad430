//! Where a format's numbers end.

use super::Number;

/// The range of a number; that of floats, whose end no joint comes near, is infinite.
pub trait Limits: Number {
    /// Where its numbers end.
    const LARGEST: f64 = f64::INFINITY;
    /// Where its constants end.
    const LARGEST_GAIN: f64 = f64::INFINITY;
    /// Whether it holds the matrix of a stiff joint, which is then stepped by the implicit method;
    /// where it does not, such a joint takes more micro-steps.
    const IMPLICIT: bool = true;

    /// Whether the number stands at the end of its range, or is none.
    fn is_at_limit(self) -> bool;
}

impl Limits for f32 {
    #[inline(always)]
    fn is_at_limit(self) -> bool {
        !self.is_finite()
    }
}

impl Limits for f64 {
    #[inline(always)]
    fn is_at_limit(self) -> bool {
        !self.is_finite()
    }
}
