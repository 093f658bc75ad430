//! Fixed point, for a drive without a floating-point unit: 32-bit words, 64-bit products.
//!
//! A state is a multiple of 2⁻²⁶ between −32 and 32. The joint's units ([`crate::per_unit`]) keep
//! what is admissible far inside that; what is not stops at the limits and does not wrap, and
//! [`crate::joint::Joint::saturated`] tells. A constant of the model has an exponent of its own
//! ([`Gain`]), so ten decades of them cost no resolution. Products round to the nearest, which keeps
//! a joint in stick where it is. Nothing here divides: reciprocals are found by Newton's iteration
//! on a normalised mantissa, and no float is touched once the constants are built.

mod exponential;

use core::ops::{Add, Mul, Neg, Sub};

use crate::angle::{Turns, counted};
use crate::friction::{Damped, Relaxation, Stribeck};
use crate::gear::Deflection;
use crate::number::{Elementary, Limits, Number, compared};
use crate::work::Wide;
use exponential::interpolated;

/// Binary places of a state.
const PLACES: u32 = 26;
const UNIT: i32 = 1 << PLACES;

/// A number between −32 and 32 in steps of 2⁻²⁶, about 1.5e-8.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Fixed(i32);

/// A constant below an eighth as a mantissa of 31 bits and a power of two, or a larger one, up to
/// 32768, in steps of 2⁻¹⁶.
///
/// A shift by a variable number of bits rounds down and costs a mask; a second product with the power
/// of two rounds to the nearest in one instruction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Gain {
    mantissa: i32,
    /// Up to 2³⁰; zero for a constant in steps of 2⁻¹⁶.
    power: i32,
}

impl Fixed {
    /// The largest number; sums and products stop here.
    pub const MAX: Fixed = Fixed(i32::MAX);
    /// The smallest one.
    pub const MIN: Fixed = Fixed(i32::MIN);

    /// From its bits: a multiple of 2⁻²⁶.
    pub const fn from_bits(bits: i32) -> Self {
        Self(bits)
    }

    /// Its bits.
    pub const fn to_bits(self) -> i32 {
        self.0
    }
}

/// The product's bits from this place on, or the nearest 32-bit number, to 64 of its last place.
#[inline(always)]
fn from_place<const PLACE: u32>(product: i64) -> i32 {
    let limit = 1_i32 << (PLACE - 1);
    let high = ((product >> 32) as i32).clamp(-limit, limit - 1);
    (high << (32 - PLACE)) | ((product as u32) >> PLACE) as i32
}

/// The nearest 32-bit number.
#[inline]
fn narrow(wide: i64) -> i32 {
    wide.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32
}

/// Upper word of a product, to the nearest.
#[inline(always)]
fn nearest_upper(a: i32, b: i32) -> i32 {
    ((i64::from(a) * i64::from(b) + (1 << 31)) >> 32) as i32
}

impl Gain {
    /// The product in units of 2⁻⁵⁸; for constants below one.
    #[inline(always)]
    fn exactly(self, of: Fixed) -> i64 {
        let product = i64::from(of.0) * i64::from(self.mantissa);
        if self.power == 0 {
            return product << 16;
        }
        let low = u64::from(product as u32) * u64::from(self.power as u32);
        (product >> 32) * i64::from(self.power) + (low >> 32) as i64
    }
}

/// Upper word of a product of 32-bit fractions, rounded down.
#[inline(always)]
fn upper(a: i32, b: i32) -> i32 {
    ((i64::from(a) * i64::from(b)) >> 32) as i32
}

impl Add for Fixed {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

impl Sub for Fixed {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}

impl Neg for Fixed {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(0_i32.saturating_sub(self.0))
    }
}

impl Mul for Fixed {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(from_place::<PLACES>(i64::from(self.0) * i64::from(other.0)))
    }
}

/// A divisor of at least 1/64, a smaller one taken for that: the bits by which it is moved up to
/// stand between ½ and 1, and the reciprocal of what it then is, in units of 2⁻²⁹.
///
/// The line 48/17 − 32/17 D is within 1/17 of 1/D; each Newton step squares that.
#[inline(always)]
fn reciprocal<const STEPS: u32>(by: Fixed) -> (u32, i32) {
    of_one_or_more::<STEPS>(if by.0 > UNIT / 64 { by.0 } else { UNIT / 64 })
}

/// The same of bits that are above zero.
#[inline(always)]
fn of_one_or_more<const STEPS: u32>(by: i32) -> (u32, i32) {
    let lead = by.leading_zeros() - 1;
    let d = by << lead;
    let mut r = 1_515_870_810 - upper(2_021_161_080, d);
    for _ in 0..STEPS {
        let missing = (1 << 28) - upper(d, r);
        r += upper(r, missing << 4);
    }
    (lead, r)
}

impl Fixed {
    /// Quotient by a number of at least 1/64.
    #[inline]
    fn quotient(self, by: Self) -> Self {
        let (lead, r) = reciprocal::<3>(by);
        // 1/x is 2^(lead − 5) / D.
        let product = i64::from(self.0) * i64::from(r);
        Self(narrow((product + (1_i64 << (33 - lead))) >> (34 - lead)))
    }

    /// Quotient of numbers above zero by one that is no smaller, to 2e-5 of itself.
    #[inline(always)]
    fn share(self, of: Self) -> Self {
        let (lead, r) = reciprocal::<2>(of);
        Self(upper(self.0 << lead, r).saturating_add(2) >> 2)
    }
}

impl Number for Fixed {
    type Gain = Gain;
    compared!();

    const ZERO: Fixed = Fixed(0);
    const ONE: Fixed = Fixed(UNIT);
    const HALF: Fixed = Fixed(UNIT / 2);

    /// Beyond 32768 a constant stops; below 2⁻³³ it is zero.
    fn gain(value: f64) -> Gain {
        if libm::fabs(value) >= 0.125 {
            return Gain { mantissa: libm::round(value * 65_536.0) as i32, power: 0 };
        }
        let (fraction, exponent) = libm::frexp(value);
        let bits = 33 + exponent;
        if value == 0.0 || !value.is_finite() || bits < 0 {
            return Gain::default();
        }
        // The fraction lies between ½ and 1; as one, it would be the next exponent's ½.
        let mantissa = libm::round(fraction * 2_147_483_648.0 * 2.0) as i64 / 2;
        Gain { mantissa: narrow(mantissa), power: 1 << bits }
    }
    fn from_f64(value: f64) -> Fixed {
        Fixed(libm::round(value * f64::from(UNIT)) as i32)
    }
    fn to_f64(self) -> f64 {
        f64::from(self.0) / f64::from(UNIT)
    }
    #[inline(always)]
    fn times(self, gain: Gain) -> Fixed {
        if gain.power == 0 {
            return Fixed(from_place::<16>(i64::from(self.0) * i64::from(gain.mantissa)));
        }
        Fixed(nearest_upper(upper(self.0, gain.mantissa), gain.power))
    }
    #[inline(always)]
    fn times_nearest(self, gain: Gain) -> Fixed {
        if gain.power == 0 {
            let product = i64::from(self.0) * i64::from(gain.mantissa);
            return Fixed(from_place::<16>(product + (1 << 15)));
        }
        Fixed(nearest_upper(nearest_upper(self.0, gain.mantissa), gain.power))
    }
    #[inline]
    fn ratio(self, at_least_self: Fixed) -> Fixed {
        // Both moved up as far as they go, so that a small divisor is as good as a large one.
        let room = at_least_self.0.max(1).leading_zeros().saturating_sub(2);
        Fixed(self.0 << room).quotient(Fixed(at_least_self.0 << room))
    }
    #[inline(always)]
    fn over(self, at_least_one: Fixed) -> Fixed {
        self.quotient(at_least_one)
    }
    #[inline(always)]
    fn abs(self) -> Fixed {
        Fixed(self.0.saturating_abs())
    }
    #[inline(always)]
    fn nearest(self, other: Fixed) -> Fixed {
        let product = i64::from(self.0) * i64::from(other.0) + i64::from(UNIT / 2);
        Self(from_place::<PLACES>(product))
    }
    #[inline(always)]
    fn half(self) -> Fixed {
        Fixed(self.0 >> 1)
    }
    #[inline(always)]
    fn eighth(self) -> Fixed {
        Fixed(self.0 >> 3)
    }
    #[inline(always)]
    fn along(self, direction: Fixed) -> Fixed {
        if direction.0 < 0 { -self } else { self }
    }
}

impl Limits for Fixed {
    const LARGEST: f64 = 32.0;
    const LARGEST_GAIN: f64 = 32_768.0;
    const IMPLICIT: bool = false;

    /// A large constant's product stops up to 2¹⁶ steps before the last one.
    #[inline(always)]
    fn is_at_limit(self) -> bool {
        const LIMIT: i32 = i32::MAX - (1 << 16);
        self.0 > LIMIT || self.0 < -LIMIT
    }
}

impl Elementary for Fixed {
    /// `2^−p`, the whole part of `p` as a shift and a polynomial of fourth order for the rest.
    #[inline(always)]
    fn exp_minus(self) -> Fixed {
        let capped = if self.0 < 20 * UNIT { self.0 } else { 20 * UNIT };
        // Times log2(e), which is in units of 2⁻³⁰.
        let power = upper(capped, 1_549_082_005) << 2;
        let whole = (power >> PLACES) as u32;
        // In units of 2⁻³¹; coefficients in units of 2⁻³⁰.
        let part = (power & (UNIT - 1)) << (31 - PLACES);
        let mut sum = 7_339_192;
        for coefficient in [-57_137_150, 257_086_653, -744_155_626, 1_073_739_719] {
            sum = (upper(sum, part) << 1) + coefficient;
        }
        if whole > PLACES {
            return Fixed(0);
        }
        Fixed((sum + (8 << whole)) >> (whole + 4))
    }
    #[inline(always)]
    fn sin_turns(self) -> Fixed {
        let p = self * (Fixed::HALF - self.abs());
        let a = p.abs();
        // A quarter of the coefficients of the f32 sine, in units of 2⁻²⁶.
        let mut sum = Fixed(941_953_445);
        for coefficient in [1_194_425_888, 843_383_602, 210_828_268] {
            sum = sum * a + Fixed(coefficient);
        }
        let quarter = p * sum;
        quarter + quarter + quarter + quarter
    }
}

impl Turns for Fixed {
    counted!();

    #[inline(always)]
    fn from_turn_counts(counts: i32) -> Fixed {
        Fixed(counts >> (32 - PLACES))
    }
    #[inline(always)]
    fn split_turns(self) -> (i32, Fixed) {
        let whole = (self.0 + (UNIT / 2)) >> PLACES;
        (whole, Fixed(self.0 - (whole << PLACES)))
    }
    #[inline]
    fn summed(part: Fixed, lost: Fixed, turns: Fixed) -> (i32, Fixed, Fixed) {
        let (whole, part) = (part + turns).split_turns();
        (whole, part, lost)
    }
    /// The loss is the next 32 binary places, with the sign turned as that of a float's.
    #[inline]
    fn turned(part: Fixed, lost: Fixed, speed: Fixed, gain: Gain) -> (i32, Fixed, Fixed) {
        let moved = gain.exactly(speed);
        let sum = (i64::from(part.0) << 32) - i64::from(lost.0) + moved;
        // To the nearest part: the loss then is a signed word.
        let near = ((sum + (1 << 31)) >> 32) as i32;
        let lost = (i64::from(near) << 32) - sum;
        let (whole, part) = Fixed(near).split_turns();
        (whole, part, Fixed(lost as i32))
    }
    fn lost_to_f64(self) -> f64 {
        self.to_f64() / 4_294_967_296.0
    }
    #[inline]
    fn wrapped_turns(whole: i32, whole_ratio: Gain, part: Fixed, ratio: Gain) -> Fixed {
        let turns = (scaled(i64::from(whole) << PLACES, whole_ratio) as i64)
            .wrapping_add(i64::from(part.times(ratio).0));
        let nearest = (turns + i64::from(UNIT / 2)) >> PLACES;
        Fixed((turns - (nearest << PLACES)) as i32)
    }
    fn wide_turns(whole: i32, part: Fixed, ratio: Gain) -> Fixed {
        let turns = (i64::from(whole) << PLACES) + i64::from(part.0);
        let moved = scaled(turns, ratio);
        Fixed(moved.clamp(i128::from(i32::MIN), i128::from(i32::MAX)) as i32)
    }
}

impl Deflection for Fixed {
    #[inline(always)]
    fn drifted(self, lost: Fixed, change: Fixed, gain: Gain) -> (Fixed, Fixed) {
        let moved = gain.exactly(change);
        let (low, carry) = (lost.0 as u32).overflowing_add(moved as u32);
        (self + Fixed((moved >> 32) as i32 + i32::from(carry)), Fixed(low as i32))
    }
}

impl Stribeck for Fixed {
    const SQUARE: f64 = 1.0;

    /// The exponential from a table of its values at eighths, with straight lines between: an error of
    /// 5e-4 at most; zero from 16 on.
    #[inline(always)]
    fn stribeck(self, beta: Fixed) -> (Fixed, Fixed) {
        let excess = beta.nearest(interpolated(self.0));
        let level = Fixed::ONE + excess;
        (excess.share(level), level)
    }
}

impl Relaxation for Fixed {
    const REACH: f64 = 1.0;
    const PER_REACH: Fixed = Fixed(UNIT);
    const RELAXING: [Fixed; 2] = [Fixed(UNIT), Fixed(UNIT / 2)];
    const SIXTH: Fixed = Fixed((UNIT + 3) / 6);
    const ELEVEN_TWELFTHS: Fixed = Fixed(UNIT - (UNIT + 6) / 12);

    #[inline(always)]
    fn reached(self, gain: Gain, lost: Fixed) -> (Fixed, Fixed) {
        let (reach, rest) = if gain.power == 0 {
            let product = i64::from(self.0) * i64::from(gain.mantissa);
            (from_place::<16>(product), (product as u32) << 16)
        } else {
            let moved = gain.exactly(self);
            ((moved >> 32) as i32, moved as u32)
        };
        let (low, carry) = (lost.0 as u32).overflowing_add(rest);
        (Fixed(reach.saturating_add(i32::from(carry))), Fixed(low as i32))
    }
    /// As a share of the way to the slip value, since the quotient's parts would leave the range. From
    /// a reach of 4.5 on, where 1 % of the way is left, the bristle is there.
    #[inline(always)]
    fn relaxed(self, reach: Fixed, rho: Fixed, level: Fixed) -> Fixed {
        const LIMIT: i32 = 9 * (UNIT / 2);
        const SIXTH_OF_WORD: i32 = 715_827_883;
        let x = reach.abs().nearest(rho).0;
        let x = if x < LIMIT { x } else { LIMIT };
        // x + x² (½ + x/6): x in steps of 2⁻²⁸, the half and the square's half of 2⁻²⁸ and 2⁻²⁴.
        let fine = x << 2;
        let bent = upper(fine, (1 << 27) + upper(fine, SIXTH_OF_WORD));
        let series = x + (upper(fine, bent << 4) << 2);
        let (lead, r) = of_one_or_more::<2>(UNIT.saturating_add(series));
        // In steps of 2⁻³⁰.
        let share = upper(series << lead, r) << 2;
        let share = if x < LIMIT { share } else { 1 << 30 };
        let way = level.along(reach).0.saturating_sub(self.0).clamp(-8 * UNIT + 1, 8 * UNIT - 1);
        // To the nearest: rounded down, a bristle in stick would creep.
        self + Fixed(nearest_upper(way << 2, share))
    }
    /// The sum of fixed point loses nothing.
    #[inline(always)]
    fn relaxed_exactly(
        self,
        lost: Fixed,
        reach: Fixed,
        rho: Fixed,
        level: Fixed,
    ) -> (Fixed, Fixed) {
        (self.relaxed(reach, rho, level), lost)
    }
    #[inline(always)]
    fn swing(self) -> Fixed {
        Fixed((self.0 + 8) >> 4)
    }
}

impl Damped for Fixed {
    #[inline(always)]
    fn settled(self) -> Fixed {
        Fixed(self.0 - self.0.signum())
    }
    /// By products with the share that is lost, in steps of 2⁻³²; a share stops at a half.
    #[inline(always)]
    fn kicked<const SQUARE: bool>(self, gained: Fixed, lost: Fixed) -> Fixed {
        const LIMIT: i32 = UNIT / 2;
        let half = lost.0.clamp(-2 * LIMIT + 2, 2 * LIMIT - 2) << 5;
        let damped = nearest_upper(gained.0, half);
        let back = if SQUARE { nearest_upper(damped, half) } else { 0 };
        self + Fixed(gained.0.saturating_sub(damped - back))
    }
    #[inline(always)]
    fn risen(self, _began: Fixed, _lost: Fixed) -> Fixed {
        self
    }
}

impl Wide for Fixed {}

/// A long number times a constant; not for the plain step.
fn scaled(value: i64, gain: Gain) -> i128 {
    let product = i128::from(value) * i128::from(gain.mantissa);
    if gain.power == 0 { product >> 16 } else { (product * i128::from(gain.power)) >> 64 }
}

#[cfg(test)]
mod tests;
