//! Fixed point, for a drive without a floating-point unit: 32-bit words, 64-bit products.
//!
//! A state is a multiple of 2⁻²⁶ between −32 and 32. The joint's units ([`crate::per_unit`]) keep
//! what is admissible far inside that; what is not stops at the limits and does not wrap, and
//! [`crate::joint::Joint::saturated`] tells. A constant of the model has an exponent of its own
//! ([`Gain`]), so ten decades of them cost no resolution. Products round to the nearest, which keeps
//! a joint in stick where it is. Nothing here divides: reciprocals are found by Newton's iteration
//! on a normalised mantissa, and no float is touched once the constants are built.
//!
//! Words, sums, limits, conversions and text are those of the crate `fixed`. Ours is what it has not:
//! constants with an exponent of their own, remainders below the last place, closed flows; and the
//! narrowing of its exact products, which its own would make dearer (`docs/step.md`).

mod laws;
mod lines;

use core::cmp::Ordering;
use core::fmt;
use core::ops::{Add, Mul, Neg, Sub};

use ::fixed::types::{I1F31, I2F30, I6F26, I12F20, I12F52, I16F16, I38F26};

use crate::number::{Elementary, Limits, Number, Sums, compared};
use crate::work::Wide;

/// Binary places of a state.
const PLACES: u32 = I6F26::FRAC_NBITS;
const UNIT: i32 = I6F26::ONE.to_bits();

/// A number between −32 and 32 in steps of 2⁻²⁶, about 1.5e-8.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Fixed(I6F26);

/// A constant below an eighth as a mantissa of 31 bits and a power of two, or a larger one, up to
/// 32768, in steps of 2⁻¹⁶.
///
/// A shift by a variable number of bits rounds down and costs a mask; a second product with the power
/// of two rounds to the nearest in one instruction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Gain {
    /// Where the power is zero, the bits of an [`I16F16`]; in a sum ([`Sums`]) those of an [`I12F20`].
    mantissa: I1F31,
    /// Up to 2³⁰; zero for a large constant.
    power: i32,
}

impl Fixed {
    /// The largest number; sums and products stop here.
    pub const MAX: Fixed = Fixed(I6F26::MAX);
    /// The smallest one.
    pub const MIN: Fixed = Fixed(I6F26::MIN);

    /// From its bits: a multiple of 2⁻²⁶.
    #[inline(always)]
    pub const fn from_bits(bits: i32) -> Self {
        Self(I6F26::from_bits(bits))
    }

    /// Its bits.
    #[inline(always)]
    pub const fn to_bits(self) -> i32 {
        self.0.to_bits()
    }
}

impl fmt::Display for Fixed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl From<I6F26> for Fixed {
    fn from(word: I6F26) -> Self {
        Self(word)
    }
}

impl From<Fixed> for I6F26 {
    fn from(number: Fixed) -> Self {
        number.0
    }
}

/// The product's bits from this place on, or the nearest 32-bit number, to 64 of its last place.
#[inline(always)]
fn from_place<const PLACE: u32>(product: i64) -> i32 {
    let limit = 1_i32 << (PLACE - 1);
    let high = ((product >> 32) as i32).clamp(-limit, limit - 1);
    (high << (32 - PLACE)) | ((product as u32) >> PLACE) as i32
}

/// Upper word of a product, to the nearest.
#[inline(always)]
fn nearest_upper(a: i32, b: i32) -> i32 {
    ((i64::from(a) * i64::from(b) + (1 << 31)) >> 32) as i32
}

/// Upper word of a product of 32-bit fractions, rounded down.
#[inline(always)]
fn upper(a: i32, b: i32) -> i32 {
    ((i64::from(a) * i64::from(b)) >> 32) as i32
}

/// The nearest number of a format: a float beyond its ends stops there, and what is no number is zero.
fn nearest_f64<F: ::fixed::traits::Fixed>(value: f64) -> F {
    let end = match value.partial_cmp(&0.0) {
        Some(Ordering::Less) => F::MIN,
        Some(Ordering::Greater) => F::MAX,
        _ => F::ZERO,
    };
    F::checked_from_num(value).unwrap_or(end)
}

impl Gain {
    /// The mantissa's product: of 57 binary places, or of 42 where the constant is in steps of 2⁻¹⁶.
    #[inline(always)]
    fn product(self, of: Fixed) -> i64 {
        of.0.wide_mul(self.mantissa).to_bits()
    }

    /// The product in units of 2⁻⁵⁸; for constants below one.
    #[inline(always)]
    fn exactly(self, of: Fixed) -> i64 {
        let product = self.product(of);
        if self.power == 0 {
            return product << 16;
        }
        let low = u64::from(product as u32) * u64::from(self.power as u32);
        (product >> 32) * i64::from(self.power) + (low >> 32) as i64
    }
}

impl Gain {
    /// A sum of products with constants of [`Sums::gains`], of which this is one, to the nearest number.
    #[inline(always)]
    fn summed(self, products: i64) -> Fixed {
        if self.power == 0 {
            return Fixed::from_bits(from_place::<20>(products.wrapping_add(1 << 19)));
        }
        let upper = (products.wrapping_add(1 << 31) >> 32) as i32;
        Fixed::from_bits(nearest_upper(upper, self.power))
    }
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
        Self(I6F26::ZERO.saturating_sub(self.0))
    }
}

impl Mul for Fixed {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self::from_bits(from_place::<PLACES>(self.product(other)))
    }
}

/// The line 48/17 − 32/17 D, within 1/17 of 1/D for D from ½ to 1.
const LINE: [i32; 2] = [1_515_870_810, 2_021_161_080];

/// A divisor of at least 1/64, a smaller one taken for that: the bits by which it is moved up to
/// stand between ½ and 1, and the reciprocal of what it then is, in units of 2⁻²⁹.
///
/// Each Newton step squares the error of the line.
#[inline(always)]
fn reciprocal<const STEPS: u32>(by: Fixed) -> (u32, i32) {
    of_one_or_more::<STEPS>(by.to_bits().max(UNIT / 64))
}

/// The same of bits that are above zero.
#[inline(always)]
fn of_one_or_more<const STEPS: u32>(by: i32) -> (u32, i32) {
    let lead = by.leading_zeros() - 1;
    let d = by << lead;
    let mut r = LINE[0] - upper(LINE[1], d);
    for _ in 0..STEPS {
        let missing = (1 << 28) - upper(d, r);
        r += upper(r, missing << 4);
    }
    (lead, r)
}

impl Fixed {
    /// The exact product, in units of 2⁻⁵².
    #[inline(always)]
    fn product(self, other: Self) -> i64 {
        let exact: I12F52 = self.0.wide_mul(other.0);
        exact.to_bits()
    }

    /// Quotient by a number of at least 1/64.
    #[inline]
    fn quotient(self, by: Self) -> Self {
        let (lead, r) = reciprocal::<3>(by);
        // 1/x is 2^(lead − 5) / D.
        let product = i64::from(self.to_bits()) * i64::from(r);
        let wide = (product + (1_i64 << (33 - lead))) >> (34 - lead);
        Self(I6F26::saturating_from_num(I38F26::from_bits(wide)))
    }

    /// One over a number of at least 1/32, a smaller one taken for that; to 4e-6 of itself, and to the
    /// last place at powers of two: a bristle that slips has a level of one, and its damping is a small
    /// difference.
    #[inline(always)]
    fn inverse(self) -> Self {
        let by = self.to_bits().max(UNIT / 32);
        let lead = by.leading_zeros() - 1;
        let d = by << lead;
        let mut r = LINE[0] - upper(LINE[1], d);
        // Newton's steps leave an error on one side: half the first's is taken off, and of the second's
        // what there is of it at powers of two.
        for offset in [113 << 12, 101 << 3] {
            let missing = (1 << 28) + offset - upper(d, r);
            r += upper(r, missing << 4);
        }
        // 1/x is 2^(lead − 5) / D.
        Self::from_bits((r << 1) >> (9 - lead))
    }
}

impl Number for Fixed {
    type Gain = Gain;
    compared!();

    const ZERO: Fixed = Fixed(I6F26::ZERO);
    const ONE: Fixed = Fixed(I6F26::ONE);
    const HALF: Fixed = Fixed(I6F26::lit("0.5"));

    /// Beyond 32768 a constant stops; below 2⁻³³ it is zero.
    fn gain(value: f64) -> Gain {
        if libm::fabs(value) >= 0.125 {
            let large = nearest_f64::<I16F16>(value);
            return Gain { mantissa: I1F31::from_bits(large.to_bits()), power: 0 };
        }
        let (fraction, exponent) = libm::frexp(value);
        let bits = 33 + exponent;
        if value == 0.0 || !value.is_finite() || bits < 0 {
            return Gain::default();
        }
        // The fraction lies between ½ and 1.
        let mantissa = libm::round(fraction * 2_147_483_648.0 * 2.0) as i64 / 2;
        Gain {
            mantissa: I1F31::from_bits(mantissa.min(i64::from(i32::MAX)) as i32),
            power: 1 << bits,
        }
    }
    fn from_f64(value: f64) -> Fixed {
        Fixed(nearest_f64(value))
    }
    fn to_f64(self) -> f64 {
        f64::from(self.0)
    }
    #[inline(always)]
    fn times(self, gain: Gain) -> Fixed {
        let product = gain.product(self);
        if gain.power == 0 {
            return Self::from_bits(from_place::<16>(product));
        }
        Self::from_bits(nearest_upper((product >> 32) as i32, gain.power))
    }
    #[inline(always)]
    fn times_nearest(self, gain: Gain) -> Fixed {
        let product = gain.product(self);
        if gain.power == 0 {
            return Self::from_bits(from_place::<16>(product + (1 << 15)));
        }
        Self::from_bits(nearest_upper(((product + (1 << 31)) >> 32) as i32, gain.power))
    }
    #[inline]
    fn ratio(self, at_least_self: Fixed) -> Fixed {
        // Both moved up as far as they go, so that a small divisor is as good as a large one.
        let room = at_least_self.to_bits().max(1).leading_zeros().saturating_sub(2);
        let up = |number: Fixed| Self::from_bits(number.to_bits() << room);
        up(self).quotient(up(at_least_self))
    }
    #[inline(always)]
    fn over(self, at_least_one: Fixed) -> Fixed {
        self.quotient(at_least_one)
    }
    #[inline(always)]
    fn abs(self) -> Fixed {
        // Without a comparison, after which the compiler multiplies by what it then knows to be above zero
        // in three instructions more.
        let sign: I6F26 = self.0 >> 31;
        Fixed((self.0 ^ sign).saturating_sub(sign))
    }
    /// The square as minus the product with minus itself, for the same reason.
    #[inline(always)]
    fn squared(self) -> Fixed {
        -(self * -self)
    }
    #[inline(always)]
    fn nearest(self, other: Fixed) -> Fixed {
        Self::from_bits(from_place::<PLACES>(self.product(other) + i64::from(UNIT / 2)))
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
        if direction.0.is_negative() { -self } else { self }
    }
}

impl Sums for Fixed {
    /// Of one exponent, so that no sum of products leaves 64 bits; constants of an eighth or more together
    /// are in steps of 2⁻²⁰ and stop at 512, which neither a kick nor a
    /// correction comes near.
    fn gains<const K: usize>(values: [f64; K]) -> [Gain; K] {
        let whole = Self::gain(values.iter().map(|value| libm::fabs(*value)).sum());
        if whole.power == 0 {
            let large = |value: f64| nearest_f64::<I12F20>(value.clamp(-512.0, 511.0)).to_bits();
            return values.map(|value| Gain { mantissa: I1F31::from_bits(large(value)), power: 0 });
        }
        let unit = 18_446_744_073_709_551_616.0 / f64::from(whole.power);
        values.map(|value| {
            let mantissa = libm::round(value * unit) as i32;
            Gain { mantissa: I1F31::from_bits(mantissa), power: whole.power }
        })
    }
    #[inline(always)]
    fn weighed(self, gain: Gain) -> Fixed {
        gain.summed(gain.product(self))
    }
    #[inline(always)]
    fn weighed_sum<const K: usize>(terms: [(Fixed, &Gain); K]) -> Fixed {
        let products = terms.iter().map(|(value, gain)| gain.product(*value));
        let sum = products.fold(0, i64::wrapping_add);
        terms.last().map_or(Self::ZERO, |(_, gain)| gain.summed(sum))
    }
    #[inline(always)]
    fn corrected<const K: usize>(self, terms: [(Fixed, &Gain); K]) -> Fixed {
        self + Self::weighed_sum(terms)
    }
    #[inline(always)]
    fn gained(plus: [(Fixed, &Gain); 3], minus: (Fixed, &Gain)) -> Fixed {
        minus.1.summed(difference(plus, minus))
    }
    #[inline(always)]
    fn ended(self, plus: [(Fixed, &Gain); 2], minus: (Fixed, &Gain)) -> Fixed {
        self + minus.1.summed(difference(plus, minus))
    }
}

/// Exact sum of products less one.
#[inline(always)]
fn difference<const K: usize>(plus: [(Fixed, &Gain); K], minus: (Fixed, &Gain)) -> i64 {
    let products = plus.iter().map(|(value, gain)| gain.product(*value));
    products.fold(0, i64::wrapping_add).wrapping_sub(minus.1.product(minus.0))
}

impl Limits for Fixed {
    const LARGEST: f64 = 32.0;
    const LARGEST_GAIN: f64 = 32_768.0;
    const IMPLICIT: bool = false;

    /// A large constant's product stops up to 2¹⁶ steps before the last one.
    #[inline(always)]
    fn is_at_limit(self) -> bool {
        const LIMIT: I6F26 = I6F26::from_bits(i32::MAX - (1 << 16));
        self.0 > LIMIT || self.0 < -LIMIT
    }
}

impl Elementary for Fixed {
    /// `2^−p`, the whole part of `p` as a shift and a polynomial of fourth order for the rest.
    #[inline(always)]
    fn exp_minus(self) -> Fixed {
        let capped = self.to_bits().min(20 * UNIT);
        // Times log2(e).
        let power = upper(capped, I2F30::LOG2_E.to_bits()) << 2;
        let whole = (power >> PLACES) as u32;
        // In units of 2⁻³¹; coefficients in units of 2⁻³⁰.
        let part = (power & (UNIT - 1)) << (31 - PLACES);
        let mut sum = 7_339_192;
        for coefficient in [-57_137_150, 257_086_653, -744_155_626, 1_073_739_719] {
            sum = (upper(sum, part) << 1) + coefficient;
        }
        if whole > PLACES {
            return Self::ZERO;
        }
        Self::from_bits((sum + (8 << whole)) >> (whole + 4))
    }
    #[inline(always)]
    fn sin_turns(self) -> Fixed {
        let p = self * (Fixed::HALF - self.abs());
        let a = p.abs();
        // A quarter of the coefficients of the f32 sine, in units of 2⁻²⁶.
        let mut sum = Self::from_bits(941_953_445);
        for coefficient in [1_194_425_888, 843_383_602, 210_828_268] {
            sum = sum * a + Self::from_bits(coefficient);
        }
        let quarter = p * sum;
        quarter + quarter + quarter + quarter
    }
}

impl Wide for Fixed {
    #[inline(always)]
    fn again<T>(constants: &T) -> &T {
        core::hint::black_box(constants)
    }
}

#[cfg(test)]
mod tests;
