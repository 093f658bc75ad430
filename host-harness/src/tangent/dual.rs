//! A number with its derivatives: what the joint is computed in where its slopes are asked for.
//!
//! The value takes exactly the operations of an `f64`, and every operation carries all derivatives
//! along by the chain rule, so that one step gives the state and its derivatives with each state and
//! each parameter. They are `f32`: a slope needs no more, and a processor takes four or more of them
//! at once.

use std::cmp::Ordering;
use std::ops::{Add, Mul, Neg, Sub};

use joint_core::scalar::Scalar;
use joint_core::work::Work;
use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
use serde::ser::{Serialize, SerializeTupleStruct, Serializer};

use crate::wide;

/// Derivatives that are carried at once, at most.
pub const LANES: usize = 16;
/// The derivatives of one number.
pub type Slopes<const L: usize = LANES> = [f32; L];

/// Name by which a reader of constants knows this number from a plain one.
pub(super) const NAME: &str = "Dual";

/// A value and its derivatives, `L` of them.
#[derive(Clone, Copy, Debug)]
pub struct Dual<const L: usize = LANES> {
    /// The value.
    pub value: f64,
    /// Its derivatives.
    pub slopes: Slopes<L>,
}

impl<const L: usize> Default for Dual<L> {
    fn default() -> Self {
        Self::constant(0.0)
    }
}

impl<const L: usize> Dual<L> {
    /// A number that depends on nothing.
    pub const fn constant(value: f64) -> Self {
        Self { value, slopes: [0.0; L] }
    }

    /// Its product with a number that depends on nothing.
    #[inline(always)]
    pub fn scaled(self, by: f64) -> Self {
        self.mapped(self.value * by, by)
    }

    /// A number that is one of those with which derivatives are taken.
    pub fn variable(value: f64, lane: usize) -> Self {
        let mut variable = Self::constant(value);
        variable.slopes[lane] = 1.0;
        variable
    }

    /// A function's value at this number, and the function's slope there.
    #[inline(always)]
    fn mapped(self, value: f64, slope: f64) -> Self {
        Self { value, slopes: scaled(&self.slopes, slope) }
    }
}

#[inline(always)]
fn scaled<const L: usize>(slopes: &Slopes<L>, by: f64) -> Slopes<L> {
    let by = by as f32;
    let mut scaled = [0.0; L];
    for (scaled, slope) in scaled.iter_mut().zip(slopes) {
        *scaled = slope * by;
    }
    scaled
}

#[inline(always)]
fn combined<const L: usize>(a: &Slopes<L>, by_a: f64, b: &Slopes<L>, by_b: f64) -> Slopes<L> {
    let (by_a, by_b) = (by_a as f32, by_b as f32);
    let mut combined = [0.0; L];
    for ((sum, a), b) in combined.iter_mut().zip(a).zip(b) {
        *sum = a * by_a + b * by_b;
    }
    combined
}

impl<const L: usize> Add for Dual<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let mut slopes = self.slopes;
        for (slope, other) in slopes.iter_mut().zip(&other.slopes) {
            *slope += other;
        }
        Self { value: self.value + other.value, slopes }
    }
}

impl<const L: usize> Sub for Dual<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let mut slopes = self.slopes;
        for (slope, other) in slopes.iter_mut().zip(&other.slopes) {
            *slope -= other;
        }
        Self { value: self.value - other.value, slopes }
    }
}

impl<const L: usize> Mul for Dual<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let slopes = combined(&self.slopes, other.value, &other.slopes, self.value);
        Self { value: self.value * other.value, slopes }
    }
}

impl<const L: usize> Neg for Dual<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.mapped(-self.value, -1.0)
    }
}

impl<const L: usize> PartialEq for Dual<L> {
    #[inline(always)]
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl<const L: usize> PartialOrd for Dual<L> {
    #[inline(always)]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.value.partial_cmp(&other.value)
    }
}

impl<const L: usize> Scalar for Dual<L> {
    type Gain = Self;
    type Mask = bool;
    type Whole = i32;

    const ZERO: Self = Self::constant(f64::ZERO);
    const ONE: Self = Self::constant(f64::ONE);
    const HALF: Self = Self::constant(f64::HALF);
    const SIXTH: Self = Self::constant(f64::SIXTH);
    const ELEVEN_TWELFTHS: Self = Self::constant(f64::ELEVEN_TWELFTHS);
    const REACH: f64 = f64::REACH;
    const PER_REACH: Self = Self::constant(f64::PER_REACH);
    const RELAXING: [Self; 2] =
        [Self::constant(f64::RELAXING[0]), Self::constant(f64::RELAXING[1])];
    const SQUARE: f64 = f64::SQUARE;

    fn gain(value: f64) -> Self {
        Self::constant(value)
    }
    fn from_f64(value: f64) -> Self {
        Self::constant(value)
    }
    fn to_f64(self) -> f64 {
        self.value
    }
    #[inline(always)]
    fn times(self, gain: Self) -> Self {
        self * gain
    }
    fn from_small(value: u8) -> Self {
        Self::constant(f64::from(value))
    }
    #[inline(always)]
    fn ratio(self, at_least_self: Self) -> Self {
        self.over(at_least_self)
    }
    #[inline(always)]
    fn over(self, divisor: Self) -> Self {
        let value = self.value / divisor.value;
        let share = 1.0 / divisor.value;
        Self { value, slopes: combined(&self.slopes, share, &divisor.slopes, -value * share) }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.mapped(self.value.abs(), if self.value < 0.0 { -1.0 } else { 1.0 })
    }
    #[inline(always)]
    fn exp_minus(self) -> Self {
        let value = self.value.exp_minus();
        self.mapped(value, -value)
    }
    #[inline(always)]
    fn sin_turns(self) -> Self {
        let slope = std::f64::consts::TAU * self.value.cos_turns();
        self.mapped(self.value.sin_turns(), slope)
    }
    #[inline(always)]
    fn below(self, other: Self) -> bool {
        self.value < other.value
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
    #[inline(always)]
    fn split_turns(self) -> (i32, Self) {
        let (whole, value) = self.value.split_turns();
        (whole, Self { value, ..self })
    }
    #[inline(always)]
    fn wrapped_turns(whole: i32, whole_ratio: Self, part: Self, ratio: Self) -> Self {
        let value = f64::wrapped_turns(whole, whole_ratio.value, part.value, ratio.value);
        let turned = Self::constant(f64::from(whole)) * whole_ratio + part * ratio;
        Self { value, ..turned }
    }
    #[inline(always)]
    fn wide_turns(whole: i32, part: Self, ratio: Self) -> Self {
        (Self::constant(f64::from(whole)) + part) * ratio
    }
    fn from_turn_counts(counts: i32) -> Self {
        Self::constant(f64::from_turn_counts(counts))
    }
    #[inline(always)]
    fn stribeck(self, beta: Self) -> (Self, Self) {
        let (share, curve) = self.value.stribeck(beta.value);
        let falling = (0.5 * self.value).exp_minus();
        let excess = combined(&self.slopes, -0.5 * beta.value * falling, &beta.slopes, falling);
        let flattened = 1.0 / (curve * curve);
        (
            Self { value: share, slopes: scaled(&excess, flattened) },
            Self { value: curve, slopes: excess },
        )
    }
    /// The sum's compensation concerns its value alone.
    #[inline(always)]
    fn plus(self, increment: Self, lost: Self) -> (Self, Self) {
        let (value, lost) = self.value.plus(increment.value, lost.value);
        (Self { value, ..(self + increment) }, Self::constant(lost))
    }
    #[inline(always)]
    fn half(self) -> Self {
        self.mapped(self.value.half(), 0.5)
    }
    #[inline(always)]
    fn eighth(self) -> Self {
        self.mapped(self.value.eighth(), 0.125)
    }
    #[inline(always)]
    fn swing(self) -> Self {
        self.mapped(self.value.swing(), 0.0625 / f64::REACH)
    }
    #[inline(always)]
    fn per_square(self) -> Self {
        self.mapped(self.value.per_square(), f64::ONE.per_square())
    }
    #[inline(always)]
    fn is_at_limit(self) -> bool {
        !self.value.is_finite()
    }
    #[inline(always)]
    fn widely<W: Work>(work: W) -> W::Output {
        wide::run(work)
    }
}

impl<const L: usize> Serialize for Dual<L> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut parts = serializer.serialize_tuple_struct(NAME, 1 + L)?;
        parts.serialize_field(&self.value)?;
        for slope in &self.slopes {
            parts.serialize_field(&f64::from(*slope))?;
        }
        parts.end()
    }
}

impl<'de, const L: usize> Deserialize<'de> for Dual<L> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_tuple_struct(NAME, 1 + L, Parts::<L>)
    }
}

struct Parts<const L: usize>;

impl<'de, const L: usize> Visitor<'de> for Parts<L> {
    type Value = Dual<L>;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "a number and {L} derivatives")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut parts: A) -> Result<Dual<L>, A::Error> {
        let mut next = |place: usize| {
            let part: Option<f64> = parts.next_element()?;
            part.ok_or_else(|| A::Error::invalid_length(place, &self))
        };
        let mut dual = Dual::constant(next(0)?);
        for (lane, slope) in dual.slopes.iter_mut().enumerate() {
            *slope = next(lane + 1)? as f32;
        }
        Ok(dual)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two numbers that depend on two variables, and the same a little further along either.
    fn check(
        name: &str,
        of: impl Fn(Dual<8>, Dual<8>) -> Dual<8>,
        plain: impl Fn(f64, f64) -> f64,
    ) {
        for (x, y) in [(0.3, 1.7), (-0.4, 2.5), (0.01, 1.01), (-0.49, 30.0)] {
            let found = of(Dual::variable(x, 0), Dual::variable(y, 5));
            assert_eq!(found.value, plain(x, y), "{name} at {x}, {y}");
            let step = 1e-6;
            for (lane, wanted) in [
                (0, (plain(x + step, y) - plain(x - step, y)) / (2.0 * step)),
                (5, (plain(x, y + step) - plain(x, y - step)) / (2.0 * step)),
                (7, 0.0),
            ] {
                let error = (f64::from(found.slopes[lane]) - wanted).abs();
                assert!(error < 1e-5 * wanted.abs() + 1e-6, "{name} at {x}, {y}: lane {lane}");
            }
        }
    }

    #[test]
    fn every_operation_has_the_value_of_a_float_and_the_slope_of_its_differences() {
        check("sum", |x, y| x + y, |x, y| x + y);
        check("difference", |x, y| x - y, |x, y| x - y);
        check("product", |x, y| -(x * y), |x, y| -(x * y));
        check("quotient", |x, y| x.over(y), |x, y| x / y);
        check("magnitude", |x, y| (x * y).abs(), |x, y| (x * y).abs());
        check("decay", |x, y| (x * x * y).exp_minus(), |x, y| (x * x * y).exp_minus());
        check("sine", |x, _| x.sin_turns(), |x, _| x.sin_turns());
        check("cosine", |x, _| x.cos_turns(), |x, _| x.cos_turns());
        check("tangent", |x, y| (x * y).tanh(), |x, y| Scalar::tanh(x * y));
        check("curve", |x, y| (x * x).stribeck(y).1, |x, y| (x * x).stribeck(y).1);
        check("share", |x, y| (x * x).stribeck(y).0, |x, y| (x * x).stribeck(y).0);
        check("swing", |x, y| (x * y).swing(), |x, y| (x * y).swing());
        check("thrice", |x, y| (x * y).thrice().eighth(), |x, y| (x * y).thrice().eighth());
        check("part", |x, y| (x + y).over(y).split_turns().1, |x, y| ((x + y) / y).split_turns().1);
        check("bend", |x, y| y.relaxed(x, y, y), |x, y| y.relaxed(x, y, y));
        check("sum kept", |x, y| x.plus(y, Dual::ZERO).0, |x, y| x.plus(y, 0.0).0);
        let turns = |x: Dual<8>, y: Dual<8>| Dual::wrapped_turns(2, y - Dual::ONE, x, y);
        check("turns", turns, |x, y| f64::wrapped_turns(2, y - 1.0, x, y));
        check("all turns", |x, y| Dual::wide_turns(3, x, y), |x, y| f64::wide_turns(3, x, y));
    }
}
