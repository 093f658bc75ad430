//! The number that the joint is computed in.
//!
//! The step is written once against this trait. What separates it from a float trait is
//! [`Scalar::Gain`]: every constant of the model multiplies a state through [`Scalar::times`], so a
//! fixed-point format can keep its states in one range and give each constant its own exponent.
//! [`Scalar::over`] divides only by numbers of one or more, and angles that only matter modulo a
//! turn are kept in turns, which wrap for free in fixed point.

mod floats;

pub use floats::{halved, halved_in_part};

use core::fmt::Debug;
use core::ops::{Add, Mul, Neg, Sub};

use crate::work::Work;

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
/// It cannot be compared but by [`Scalar::below`], whose answer chooses between numbers and not
/// between ways: so the compiler sees to it that no operation count of the step depends on data.
pub trait Scalar:
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
    /// Whole turns.
    type Whole: Copy + Debug + Default + PartialEq;

    /// Where the format's numbers end; infinite for floats, whose end no joint comes near.
    const LARGEST: f64 = f64::INFINITY;
    /// Where its constants end.
    const LARGEST_GAIN: f64 = f64::INFINITY;
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// One half.
    const HALF: Self;
    /// One sixth.
    const SIXTH: Self;
    /// Eleven twelfths.
    const ELEVEN_TWELFTHS: Self;
    /// Whether stiff joints are stepped by the implicit method: not in fixed point, whose range the
    /// matrix of a stiff joint leaves; it takes more micro-steps.
    const IMPLICIT: bool = true;
    /// Whether the middle kick's damping follows a rising force: not in fixed point, which is held to 2 %
    /// and where products are dear.
    const RISES: bool = true;
    /// Unit of the reach in [`Scalar::relaxed`], over the bristle's own: floats take 6^−⅓, which makes
    /// the cubic's first coefficient one and saves its product.
    const REACH: f64;
    /// One over it.
    const PER_REACH: Self;
    /// Coefficients of a = p + x (q + r x) there, where r is one in floats.
    const RELAXING: [Self; 2];
    /// Unit of the square in [`Scalar::stribeck`], for the same reason.
    const SQUARE: f64;

    /// A constant from its exact value.
    fn gain(value: f64) -> Self::Gain;
    /// A state from its exact value; not for the hot path.
    fn from_f64(value: f64) -> Self;
    /// The state's value; not for the hot path.
    fn to_f64(self) -> f64;
    /// Product with a constant.
    fn times(self, gain: Self::Gain) -> Self;
    /// The same to the nearest number, where products add up step by step; see [`Scalar::nearest`].
    #[inline(always)]
    fn times_nearest(self, gain: Self::Gain) -> Self {
        self.times(gain)
    }
    /// Constants whose products are summed up, by [`Scalar::weighed`] alone: fixed point gives them one
    /// exponent and rounds the sum instead of each product.
    fn gains<const K: usize>(values: [f64; K]) -> [Self::Gain; K] {
        values.map(Self::gain)
    }
    /// Sum of the products with constants of one call of [`Scalar::gains`].
    #[inline(always)]
    fn weighed<const K: usize>(values: [Self; K], gains: [Self::Gain; K]) -> Self {
        let products = values.into_iter().zip(gains).map(|(value, gain)| value.times(gain));
        products.reduce(|sum, product| sum + product).unwrap_or(Self::ZERO)
    }
    /// Its sum with such a sum.
    #[inline(always)]
    fn plus_weighed<const K: usize>(self, values: [Self; K], gains: [Self::Gain; K]) -> Self {
        let products = values.into_iter().zip(gains).map(|(value, gain)| value.times(gain));
        products.fold(self, |sum, product| sum + product)
    }
    /// A bristle's motion at this speed, and what rounding has taken of those before: left out, a speed
    /// too small for the product would creep on.
    #[inline(always)]
    fn reached(self, gain: Self::Gain, lost: Self) -> (Self, Self) {
        (self.times(gain), lost)
    }
    /// The sum with a product, and what rounding has taken of those before: a float keeps nothing, since
    /// it rounds by a share of the sum.
    #[inline(always)]
    fn drifted(self, lost: Self, change: Self, gain: Self::Gain) -> (Self, Self) {
        (self + change.times(gain), lost)
    }
    /// A small whole number.
    fn from_small(value: u8) -> Self;
    /// Quotient by a positive number that the dividend does not exceed; not for the plain step.
    fn ratio(self, at_least_self: Self) -> Self;
    /// Quotient by a number of one or more.
    fn over(self, at_least_one: Self) -> Self;
    /// Magnitude.
    fn abs(self) -> Self;
    /// `exp(−x)` of any `x ≥ 0`; absolute error below 5e-6 (f32) and 1e-10 (f64).
    fn exp_minus(self) -> Self;
    /// Sine of an angle in turns, for |turns| ≤ ½; absolute error below 1e-6.
    fn sin_turns(self) -> Self;
    /// Where it is less than another.
    fn below(self, other: Self) -> Self::Mask;
    /// The first where the mask holds, the second elsewhere.
    fn choose(mask: Self::Mask, there: Self, elsewhere: Self) -> Self;
    /// Whether a mask holds anywhere.
    fn anywhere(mask: Self::Mask) -> bool;
    /// Whole turns from their exact number; not for the hot path.
    fn whole(turns: i32) -> Self::Whole;
    /// Their number; not for the hot path.
    fn whole_to_f64(whole: Self::Whole) -> f64;
    /// Whole turns and some more; wraps after 2³¹.
    fn counted(whole: Self::Whole, more: Self::Whole) -> Self::Whole;
    /// Whole turns and the rest between −½ and ½, of an angle in turns between −1 and 1.
    fn split_turns(self) -> (Self::Whole, Self);
    /// A part of a turn and what it has lost, after less than half a turn more: whole turns, the part
    /// and the loss. A float is summed with compensation; a fixed-point part is exact.
    #[inline(always)]
    fn summed(part: Self, lost: Self, turns: Self) -> (Self::Whole, Self, Self) {
        let (sum, lost) = part.plus(turns, lost);
        let (whole, part) = sum.split_turns();
        (whole, part, lost)
    }
    /// The same after a motion at this speed, with what rounding would take of the product.
    #[inline(always)]
    fn turned(part: Self, lost: Self, speed: Self, gain: Self::Gain) -> (Self::Whole, Self, Self) {
        Self::summed(part, lost, speed.times(gain))
    }
    /// What a loss is worth, in turns; not for the hot path.
    fn lost_to_f64(self) -> f64 {
        self.to_f64()
    }
    /// The part of `whole · whole_ratio + part · ratio` between −½ and ½ turn.
    fn wrapped_turns(
        whole: Self::Whole,
        whole_ratio: Self::Gain,
        part: Self,
        ratio: Self::Gain,
    ) -> Self;
    /// `(whole + part) · ratio`, for laws that do not repeat with the angle.
    fn wide_turns(whole: Self::Whole, part: Self, ratio: Self::Gain) -> Self;

    /// Turns between −½ and ½ from counts of 2⁻³² turn.
    fn from_turn_counts(counts: i32) -> Self;

    /// Cosine of an angle in turns, for |turns| ≤ ½.
    #[inline(always)]
    fn cos_turns(self) -> Self {
        let quarter = Self::HALF * Self::HALF;
        (quarter - self.abs()).sin_turns()
    }

    /// Of a Stribeck curve 1 + β exp(−s/2), for `s ≥ 0` in units of [`Scalar::SQUARE`] and β above −1: the share of it that exceeds
    /// one, `β / (exp(s/2) + β)`, and the curve itself. Absolute error of the exponential below 4e-5
    /// (f32) and 1e-10 (f64).
    fn stribeck(self, beta: Self) -> (Self, Self);

    /// A bristle at this deflection after a motion of `reach` in units of [`Scalar::REACH`] times its
    /// reach, where it slips at `level = 1/rho`: with x = |reach| ρ in units of one and
    /// a = 1 + x/2 + x²/6, `(ζ + reach a) / (1 + x a)`.
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

    /// The sum, and what it and those before it have lost by rounding.
    #[inline(always)]
    fn plus(self, increment: Self, lost: Self) -> (Self, Self) {
        let increment = increment - lost;
        let sum = self + increment;
        (sum, (sum - self) - increment)
    }

    /// The product to the nearest number: where products add up step by step, one rounded down would
    /// push. Floats always are.
    #[inline(always)]
    fn nearest(self, other: Self) -> Self {
        self * other
    }

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
    fn eighth(self) -> Self;

    /// A sixteenth of it, over [`Scalar::REACH`].
    fn swing(self) -> Self;

    /// What is in units of [`Scalar::SQUARE`] in units of one.
    fn per_square(self) -> Self;

    /// A speed after a gain at which it would lose the share `lost` = 2x of itself, by the implicit
    /// midpoint rule with its quotient 1/(1 + x) expanded, to x² where that is asked for.
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

    /// Three times it.
    #[inline(always)]
    fn thrice(self) -> Self {
        self + self + self
    }

    /// With the sign turned where `direction` is below zero.
    #[inline(always)]
    fn along(self, direction: Self) -> Self {
        Self::choose(direction.below(Self::ZERO), -self, self)
    }

    /// Whether the number stands at the end of its range, or is none.
    fn is_at_limit(self) -> bool;

    /// Does work in such numbers: those of many lanes choose the widest registers at hand.
    #[inline(always)]
    fn widely<W: Work>(work: W) -> W::Output {
        work.run()
    }

    /// Hyperbolic tangent; absolute error that of [`Scalar::exp_minus`].
    #[inline(always)]
    fn tanh(self) -> Self {
        let magnitude = self.abs();
        let decayed = (magnitude + magnitude).exp_minus();
        let bent = (Self::ONE - decayed).over(Self::ONE + decayed);
        bent.along(self)
    }
}

/// One number that can be compared, and whose whole turns are a count: for what is not the step, and
/// may take its way by the data.
pub trait Real: Scalar<Mask = bool, Whole = i32> + PartialOrd {}
impl<T: Scalar<Mask = bool, Whole = i32> + PartialOrd> Real for T {}

/// What a single number answers where several would answer one by one.
macro_rules! single {
    () => {
        type Mask = bool;
        type Whole = i32;

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
        fn whole(turns: i32) -> i32 {
            turns
        }
        fn whole_to_f64(whole: i32) -> f64 {
            f64::from(whole)
        }
        #[inline(always)]
        fn counted(whole: i32, more: i32) -> i32 {
            whole.wrapping_add(more)
        }
    };
}

pub(crate) use single;
