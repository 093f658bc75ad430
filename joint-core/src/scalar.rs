//! The number that the joint is computed in.
//!
//! The step is written once against this trait. What separates it from a float trait is
//! [`Scalar::Gain`]: every constant of the model multiplies a state through [`Scalar::times`], so a
//! fixed-point format can keep its states in one range and give each constant its own exponent.
//! [`Scalar::over`] divides only by numbers of one or more, and angles that only matter modulo a
//! turn are kept in turns, which wrap for free in fixed point.

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

/// A number for states, and the constants that multiply it.
pub trait Scalar:
    Copy
    + Wire
    + Debug
    + Default
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// A constant of the model; a float is its own gain.
    type Gain: Copy + Debug + Default + PartialEq + Wire + 'static;

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
    /// Whole turns and the rest between −½ and ½, of an angle in turns between −1 and 1.
    fn split_turns(self) -> (i32, Self);
    /// A part of a turn and what it has lost, after less than half a turn more: whole turns, the part
    /// and the loss. A float is summed with compensation; a fixed-point part is exact.
    #[inline]
    fn summed(part: Self, lost: Self, turns: Self) -> (i32, Self, Self) {
        let (sum, lost) = part.plus(turns, lost);
        let (whole, part) = sum.split_turns();
        (whole, part, lost)
    }
    /// The same after a motion at this speed, with what rounding would take of the product.
    #[inline]
    fn turned(part: Self, lost: Self, speed: Self, gain: Self::Gain) -> (i32, Self, Self) {
        Self::summed(part, lost, speed.times(gain))
    }
    /// What a loss is worth, in turns; not for the hot path.
    fn lost_to_f64(self) -> f64 {
        self.to_f64()
    }
    /// The part of `whole · whole_ratio + part · ratio` between −½ and ½ turn.
    fn wrapped_turns(whole: i32, whole_ratio: Self::Gain, part: Self, ratio: Self::Gain) -> Self;
    /// `(whole + part) · ratio`, for laws that do not repeat with the angle.
    fn wide_turns(whole: i32, part: Self, ratio: Self::Gain) -> Self;

    /// Turns between −½ and ½ from counts of 2⁻³² turn.
    fn from_turn_counts(counts: i32) -> Self;

    /// Cosine of an angle in turns, for |turns| ≤ ½.
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
        if direction < Self::ZERO { -self } else { self }
    }

    /// Whether the number stands at the end of its range, or is none.
    fn is_at_limit(self) -> bool;

    /// Hyperbolic tangent; absolute error that of [`Scalar::exp_minus`].
    #[inline]
    fn tanh(self) -> Self {
        let magnitude = self.abs();
        let decayed = (magnitude + magnitude).exp_minus();
        let bent = (Self::ONE - decayed).over(Self::ONE + decayed);
        if self < Self::ZERO { -bent } else { bent }
    }
}

/// Sine of |turns| ≤ ½. It is mirrored about a quarter turn, and so is `p = x (½ − |x|)`, of which it
/// is a smooth odd function: the polynomial gives sine over p, and there is no quadrant to look up.
macro_rules! sine {
    ($turns:expr, $t:ty, $($c:expr),+) => {{
        let x: $t = $turns;
        let p = x * (0.5 - x.abs());
        p * horner!(p.abs(), $t, $($c),+)
    }};
}

macro_rules! horner {
    ($x:expr, $t:ty, $first:expr $(, $c:expr)+) => {{
        let x: $t = $x;
        let mut sum: $t = $first;
        $( sum = sum * x + $c; )+
        sum
    }};
}

/// 6^−⅓.
const FLOAT_REACH: f64 = 0.550_321_208_149_104_5;
/// Cube root of the cubic's first coefficient in the Stribeck curve of f32.
const CUBE: f64 = 0.036826556131;

impl Scalar for f32 {
    type Gain = f32;

    const ZERO: f32 = 0.0;
    const ONE: f32 = 1.0;
    const HALF: f32 = 0.5;
    const SIXTH: f32 = 1.0 / 6.0;
    const ELEVEN_TWELFTHS: f32 = 11.0 / 12.0;
    const REACH: f64 = FLOAT_REACH;
    const PER_REACH: f32 = (1.0 / FLOAT_REACH) as f32;
    const RELAXING: [f32; 2] =
        [(1.0 / FLOAT_REACH) as f32, (0.5 / (FLOAT_REACH * FLOAT_REACH)) as f32];
    const SQUARE: f64 = CUBE;

    fn gain(value: f64) -> f32 {
        value as f32
    }
    fn from_f64(value: f64) -> f32 {
        value as f32
    }
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    #[inline(always)]
    fn eighth(self) -> f32 {
        self * 0.125
    }
    #[inline(always)]
    fn swing(self) -> f32 {
        const SWING: f32 = (0.0625 / FLOAT_REACH) as f32;
        self * SWING
    }
    #[inline(always)]
    fn per_square(self) -> f32 {
        self * (1.0 / CUBE) as f32
    }
    #[inline(always)]
    fn times(self, gain: f32) -> f32 {
        self * gain
    }
    #[inline(always)]
    fn ratio(self, at_least_self: f32) -> f32 {
        self / at_least_self
    }
    #[inline(always)]
    fn over(self, at_least_one: f32) -> f32 {
        self / at_least_one
    }
    #[inline(always)]
    fn abs(self) -> f32 {
        f32::abs(self)
    }
    /// `exp(−t) = exp(−t/32)³²`, the root by a cubic whose 32nd power is within 7.2e-7 of it on
    /// `0 ≤ t ≤ 16`; what is left there, 1.2e-7, stands for all beyond.
    #[inline(always)]
    fn exp_minus(self) -> f32 {
        let t = if self < 16.0 { self } else { 16.0 };
        let mut root = horner!(t, f32, -4.807_761e-6, 4.877_664_6e-4, -0.031_249_774, 1.0);
        for _ in 0..5 {
            root = root * root;
        }
        root
    }
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
    fn thrice(self) -> f32 {
        self * 3.0
    }
    #[inline(always)]
    fn is_at_limit(self) -> bool {
        !self.is_finite()
    }
    #[inline(always)]
    fn from_turn_counts(counts: i32) -> f32 {
        counts as f32 * (1.0 / 4_294_967_296.0)
    }
    #[inline(always)]
    fn from_small(value: u8) -> f32 {
        f32::from(value)
    }
    #[inline(always)]
    fn sin_turns(self) -> f32 {
        sine!(self, f32, 56.144_802, 71.193_33, 50.269_58, 12.566_344)
    }
    #[inline(always)]
    fn split_turns(self) -> (i32, f32) {
        let whole = (self + self) as i32;
        (whole, self - whole as f32)
    }
    #[inline]
    fn wrapped_turns(whole: i32, whole_ratio: f32, part: f32, ratio: f32) -> f32 {
        let turns = whole as f32 * whole_ratio + part * ratio;
        let nearest = (turns + if turns < 0.0 { -0.5 } else { 0.5 }) as i32;
        turns - nearest as f32
    }
    #[inline]
    fn wide_turns(whole: i32, part: f32, ratio: f32) -> f32 {
        (whole as f32 + part) * ratio
    }
}

impl Scalar for f64 {
    type Gain = f64;

    const ZERO: f64 = 0.0;
    const ONE: f64 = 1.0;
    const HALF: f64 = 0.5;
    const SIXTH: f64 = 1.0 / 6.0;
    const ELEVEN_TWELFTHS: f64 = 11.0 / 12.0;
    const REACH: f64 = FLOAT_REACH;
    const PER_REACH: f64 = 1.0 / FLOAT_REACH;
    const RELAXING: [f64; 2] = [1.0 / FLOAT_REACH, 0.5 / (FLOAT_REACH * FLOAT_REACH)];
    const SQUARE: f64 = 1.0;

    fn gain(value: f64) -> f64 {
        value
    }
    fn from_f64(value: f64) -> f64 {
        value
    }
    fn to_f64(self) -> f64 {
        self
    }
    #[inline(always)]
    fn eighth(self) -> f64 {
        self * 0.125
    }
    #[inline(always)]
    fn swing(self) -> f64 {
        const SWING: f64 = 0.0625 / FLOAT_REACH;
        self * SWING
    }
    #[inline(always)]
    fn per_square(self) -> f64 {
        self
    }
    #[inline(always)]
    fn times(self, gain: f64) -> f64 {
        self * gain
    }
    #[inline(always)]
    fn ratio(self, at_least_self: f64) -> f64 {
        self / at_least_self
    }
    #[inline(always)]
    fn over(self, at_least_one: f64) -> f64 {
        self / at_least_one
    }
    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }
    #[inline(always)]
    fn exp_minus(self) -> f64 {
        let power = core::f64::consts::LOG2_E * if self < 64.0 { self } else { 64.0 };
        let whole = power as i32;
        let part = power - f64::from(whole);
        let mantissa = horner!(
            part,
            f64,
            -1.083_036_970_248_301_6e-5,
            0.000_147_293_815_700_777_48,
            -0.001_327_837_364_900_122,
            0.009_615_595_597_091_18,
            -0.055_503_473_283_022_1,
            0.240_226_428_467_964_8,
            -0.693_147_176_860_134_2,
            0.999_999_999_971_375_5
        );
        mantissa * f64::from_bits(((1023 - whole) as u64) << 52)
    }
    #[inline(always)]
    fn stribeck(self, beta: f64) -> (f64, f64) {
        let excess = beta * (0.5 * self).exp_minus();
        (excess / (1.0 + excess), 1.0 + excess)
    }
    #[inline(always)]
    fn is_at_limit(self) -> bool {
        !self.is_finite()
    }
    #[inline(always)]
    fn from_turn_counts(counts: i32) -> f64 {
        f64::from(counts) * (1.0 / 4_294_967_296.0)
    }
    #[inline(always)]
    fn from_small(value: u8) -> f64 {
        f64::from(value)
    }
    #[inline(always)]
    fn sin_turns(self) -> f64 {
        sine!(
            self,
            f64,
            7.532_170_094_907_101,
            23.569_620_688_749_745,
            52.436_418_256_069_42,
            71.390_215_699_215_19,
            50.265_482_709_283_225,
            12.566_370_613_548_331
        )
    }
    #[inline(always)]
    fn split_turns(self) -> (i32, f64) {
        let whole = (self + self) as i32;
        (whole, self - f64::from(whole))
    }
    #[inline]
    fn wrapped_turns(whole: i32, whole_ratio: f64, part: f64, ratio: f64) -> f64 {
        let turns = f64::from(whole) * whole_ratio + part * ratio;
        let nearest = (turns + if turns < 0.0 { -0.5 } else { 0.5 }) as i32;
        turns - f64::from(nearest)
    }
    #[inline]
    fn wide_turns(whole: i32, part: f64, ratio: f64) -> f64 {
        (f64::from(whole) + part) * ratio
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sweep(low: f64, high: f64) -> impl Iterator<Item = f64> {
        (0..=4000).map(move |k| low + (high - low) * f64::from(k) / 4000.0)
    }

    #[test]
    fn exp_minus_keeps_its_stated_absolute_error() {
        for x in sweep(0.0, 80.0).chain(sweep(0.0, 1.0)) {
            assert!((x.exp_minus() - (-x).exp()).abs() < 1e-10, "f64 at {x}");
            let narrow = x as f32;
            let exact = (-f64::from(narrow)).exp();
            assert!((f64::from(narrow.exp_minus()) - exact).abs() < 5e-6, "f32 at {x}");
        }
    }

    #[test]
    fn the_excess_of_a_stribeck_curve_keeps_its_stated_error_and_ends_at_zero() {
        for beta in [-0.9, -0.3, 0.4, 2.0] {
            for s in sweep(0.0, 160.0).chain(sweep(0.0, 4.0)) {
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
    fn sine_and_cosine_of_turns_keep_their_stated_error() {
        for turns in sweep(-0.5, 0.5) {
            let angle = turns * core::f64::consts::TAU;
            assert!((turns.sin_turns() - angle.sin()).abs() < 1e-9);
            assert!((turns.cos_turns() - angle.cos()).abs() < 1e-9);
            assert!((f64::from((turns as f32).sin_turns()) - angle.sin()).abs() < 1e-6);
            assert!((f64::from((turns as f32).cos_turns()) - angle.cos()).abs() < 1e-6);
        }
    }

    #[test]
    fn turns_wrap_to_the_nearest_whole_turn_in_both_directions() {
        assert!((f64::wrapped_turns(10, 0.1, 0.25, 0.1) - 0.025).abs() < 1e-12);
        assert!((f64::wrapped_turns(-10, 0.1, -0.25, 0.1) + 0.025).abs() < 1e-12);
        let ratio = 1.0 / 1024.0;
        assert!((f32::wrapped_turns(1000, ratio, 0.0, ratio) + 24.0 / 1024.0).abs() < 1e-6);
    }
}
