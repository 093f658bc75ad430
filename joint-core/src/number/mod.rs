//! What a number is: arithmetic, conversion, the product with a constant, comparison by masks.
//!
//! The joint is written once against these operations. What separates them from a float's is
//! [`Number::Gain`]: every constant of the model multiplies a state through [`Number::times`], so a
//! fixed-point format can keep its states in one range and give each constant its own exponent.
//! [`Number::over`] divides only by numbers of one or more.
//!
//! Where a format computes a law of the joint in its own way, a small trait stands beside that law:
//! [`Turns`](crate::angle::Turns), [`Deflection`](crate::gear::Deflection),
//! [`Stribeck`](crate::friction::Stribeck), [`Relaxation`](crate::friction::Relaxation) and
//! [`Damped`](crate::friction::Damped); [`Sums`] is what the kick asks for. [`Scalar`](crate::scalar::Scalar) is all of them.

mod elementary;
mod floats;
mod limits;
mod sums;

pub(crate) use elementary::horner;
pub use elementary::{Elementary, halved, halved_in_part};
pub use limits::Limits;
pub use sums::Sums;

use core::fmt::Debug;
use core::ops::{Add, Mul, Neg, Sub};

/// What travels in a parameter block. Without the feature `serde` it asks for nothing.
#[cfg(feature = "serde")]
pub trait Wire: serde::Serialize + serde::de::DeserializeOwned {}
#[cfg(feature = "serde")]
impl<T: serde::Serialize + serde::de::DeserializeOwned> Wire for T {}
/// What travels in a parameter block. Without the feature `serde` it asks for nothing.
#[cfg(not(feature = "serde"))]
pub trait Wire {}
#[cfg(not(feature = "serde"))]
impl<T> Wire for T {}

/// A number for states, and the constants that multiply it; or several numbers side by side.
///
/// It cannot be compared but by [`Number::below`], whose answer chooses between numbers and not
/// between ways: so the compiler sees to it that no operation count of the step depends on data.
pub trait Number:
    Copy
    + Wire
    + Debug
    + Default
    + PartialEq
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// A constant of the model; a float is its own gain.
    type Gain: Copy + Debug + Default + PartialEq + Wire + 'static;
    /// Where something holds: of every number side by side.
    type Mask: Copy;

    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// One half.
    const HALF: Self;

    /// A constant from its exact value.
    fn gain(value: f64) -> Self::Gain;
    /// A state from its exact value; not for the hot path.
    fn from_f64(value: f64) -> Self;
    /// The state's value; not for the hot path.
    fn to_f64(self) -> f64;

    /// Product with a constant.
    fn times(self, gain: Self::Gain) -> Self;
    /// The same to the nearest number, where products add up step by step; see [`Number::nearest`].
    #[inline(always)]
    fn times_nearest(self, gain: Self::Gain) -> Self {
        self.times(gain)
    }
    /// The product to the nearest number: where products add up step by step, one rounded down would
    /// push. Floats always are.
    #[inline(always)]
    fn nearest(self, other: Self) -> Self {
        self * other
    }
    /// Quotient by a number of one or more.
    fn over(self, at_least_one: Self) -> Self;
    /// Quotient by a positive number that the dividend does not exceed; not for the plain step.
    fn ratio(self, at_least_self: Self) -> Self;

    /// Its square.
    #[inline(always)]
    fn squared(self) -> Self {
        self * self
    }
    /// Half of it.
    #[inline(always)]
    fn half(self) -> Self {
        self * Self::HALF
    }
    /// An eighth of it.
    #[inline(always)]
    fn eighth(self) -> Self {
        self * (Self::HALF * Self::HALF * Self::HALF)
    }
    /// The sum, and what it and those before it have lost by rounding (Kahan).
    #[inline(always)]
    fn plus(self, increment: Self, lost: Self) -> (Self, Self) {
        let increment = increment - lost;
        let sum = self + increment;
        (sum, (sum - self) - increment)
    }

    /// Magnitude.
    fn abs(self) -> Self;
    /// Where it is less than another.
    fn below(self, other: Self) -> Self::Mask;
    /// The first where the mask holds, the second elsewhere.
    fn choose(mask: Self::Mask, there: Self, elsewhere: Self) -> Self;
    /// Whether a mask holds anywhere.
    fn anywhere(mask: Self::Mask) -> bool;
    /// With the sign turned where `direction` is below zero.
    #[inline(always)]
    fn along(self, direction: Self) -> Self {
        Self::choose(direction.below(Self::ZERO), -self, self)
    }
}

/// How one number is compared, where several are compared one by one.
macro_rules! compared {
    () => {
        type Mask = bool;

        #[inline(always)]
        fn below(self, other: Self) -> bool {
            self < other
        }
        #[inline(always)]
        fn choose(mask: bool, there: Self, elsewhere: Self) -> Self {
            if mask { there } else { elsewhere }
        }
        #[inline(always)]
        fn anywhere(mask: bool) -> bool {
            mask
        }
    };
}

pub(crate) use compared;
