//! Several numbers side by side: what joints are computed in that are run together.
//!
//! Every lane takes exactly the operations of an `f64`, so that a joint gives the same bits in a lane as
//! alone; a processor takes four or eight of them at once, in the time of one. They are an array, which
//! [`crate::wide`] has compiled for the registers at hand: the vectors of `wide` are those that all
//! processors have, and those of `pulp` ask every sum for a proof of the processor. Loops over lanes count: a
//! step has thousands, and iterators in them take three times as long to compile.

use std::f64::consts::LOG2_E;
use std::ops::{Add, Mul, Neg, Sub};

use joint_core::angle::Turns;
use joint_core::friction::{Damped, Relaxation, Stribeck};
use joint_core::gear::Deflection;
use joint_core::lookup::Lookup;
use joint_core::number::{Elementary, Limits, Number, Sums, halved, halved_in_part};
use joint_core::work::{Wide, Work};

use crate::wide;

/// Numbers side by side.
pub const LANES: usize = 8;

/// As many numbers as there are lanes.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[repr(align(64))]
pub struct Lanes(pub [f64; LANES]);

/// Where something holds, by lane: all bits of a lane, or none.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Mask([u64; LANES]);

impl Lanes {
    /// The same number in every lane.
    #[inline(always)]
    pub const fn all(value: f64) -> Self {
        Self([value; LANES])
    }

    #[inline(always)]
    fn each(self, of: impl Fn(f64) -> f64) -> Self {
        let mut lanes = self.0;
        let mut k = 0;
        while k < LANES {
            lanes[k] = of(lanes[k]);
            k += 1;
        }
        Self(lanes)
    }

    #[inline(always)]
    fn both(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        let mut lanes = self.0;
        let mut k = 0;
        while k < LANES {
            lanes[k] = of(lanes[k], other.0[k]);
            k += 1;
        }
        Self(lanes)
    }
}

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.both(other, |a, b| a + b)
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.both(other, |a, b| a - b)
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.both(other, |a, b| a * b)
    }
}

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.each(|a| -a)
    }
}

impl Number for Lanes {
    type Gain = Self;
    type Mask = Mask;

    const ZERO: Self = Self::all(f64::ZERO);
    const ONE: Self = Self::all(f64::ONE);
    const HALF: Self = Self::all(f64::HALF);

    fn gain(value: f64) -> Self {
        Self::all(value)
    }
    fn from_f64(value: f64) -> Self {
        Self::all(value)
    }
    /// That of the first lane.
    fn to_f64(self) -> f64 {
        self.0[0]
    }
    #[inline(always)]
    fn times(self, gain: Self) -> Self {
        self * gain
    }
    #[inline(always)]
    fn over(self, divisor: Self) -> Self {
        self.both(divisor, |a, b| a / b)
    }
    #[inline(always)]
    fn ratio(self, at_least_self: Self) -> Self {
        self.over(at_least_self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.each(f64::abs)
    }
    #[inline(always)]
    fn below(self, other: Self) -> Mask {
        let mut mask = [0; LANES];
        let mut k = 0;
        while k < LANES {
            mask[k] = if self.0[k] < other.0[k] { u64::MAX } else { 0 };
            k += 1;
        }
        Mask(mask)
    }
    #[inline(always)]
    fn choose(mask: Mask, there: Self, elsewhere: Self) -> Self {
        let mut lanes = elsewhere.0;
        let mut k = 0;
        while k < LANES {
            lanes[k] = if mask.0[k] != 0 { there.0[k] } else { lanes[k] };
            k += 1;
        }
        Self(lanes)
    }
    #[inline(always)]
    fn anywhere(mask: Mask) -> bool {
        mask.0.iter().fold(0, |any, lane| any | lane) != 0
    }
}

impl Sums for Lanes {}

impl Limits for Lanes {
    #[inline(always)]
    fn is_at_limit(self) -> bool {
        self.0.iter().any(|lane| !lane.is_finite())
    }
}

impl Elementary for Lanes {
    #[inline(always)]
    fn exp_minus(self) -> Self {
        let power = self.each(|own| LOG2_E * if own < 64.0 { own } else { 64.0 });
        let whole = power.each(f64::trunc);
        (power - whole).each(halved_in_part) * whole.each(halved)
    }
    #[inline(always)]
    fn sin_turns(self) -> Self {
        self.each(f64::sin_turns)
    }
}

impl Lookup for Lanes {
    #[inline(always)]
    fn looked_up(self, knots: &[Self]) -> [Self; 2] {
        let last = knots.len().saturating_sub(2);
        let place = self.each(|part| part * (last + 1) as f64);
        let at = place.0.map(|place| (place as usize).min(last));
        let knot = |beyond: usize| {
            Self(std::array::from_fn(|lane| {
                knots.get(at[lane] + beyond).map_or(0.0, |knot| knot.0[lane])
            }))
        };
        let before = knot(0);
        let change = knot(1) - before;
        let share = place - Self(at.map(|at| at as f64));
        [before + change * share, change]
    }
}

impl Turns for Lanes {
    /// Whole numbers of turns: a float counts them exactly, and needs no registers of another kind.
    type Whole = Self;

    fn whole(turns: i32) -> Self {
        Self::all(f64::from(turns))
    }
    fn whole_to_f64(whole: Self) -> f64 {
        whole.to_f64()
    }
    #[inline(always)]
    fn counted(whole: Self, more: Self) -> Self {
        whole + more
    }
    fn from_turn_counts(counts: i32) -> Self {
        Self::all(f64::from_turn_counts(counts))
    }
    #[inline(always)]
    fn split_turns(self) -> (Self, Self) {
        let whole = (self + self).each(f64::trunc);
        (whole, self - whole)
    }
    #[inline(always)]
    fn wrapped_turns(whole: Self, whole_ratio: Self, part: Self, ratio: Self) -> Self {
        let turns = whole * whole_ratio + part * ratio;
        turns - turns.each(|turns| (turns + if turns < 0.0 { -0.5 } else { 0.5 }).trunc())
    }
    #[inline(always)]
    fn wide_turns(whole: Self, part: Self, ratio: Self) -> Self {
        (whole + part) * ratio
    }
}

impl Deflection for Lanes {}

impl Stribeck for Lanes {
    const SQUARE: f64 = f64::SQUARE;

    #[inline(always)]
    fn stribeck(self, beta: Self) -> (Self, Self) {
        let excess = beta * (Self::HALF * self).exp_minus();
        let level = Self::ONE + excess;
        (excess.over(level), level)
    }
}

impl Relaxation for Lanes {
    const REACH: f64 = f64::REACH;
    const PER_REACH: Self = Self::all(f64::PER_REACH);
    const RELAXING: [Self; 2] = [Self::all(f64::RELAXING[0]), Self::all(f64::RELAXING[1])];
    const SIXTH: Self = Self::all(f64::SIXTH);
    const ELEVEN_TWELFTHS: Self = Self::all(f64::ELEVEN_TWELFTHS);

    #[inline(always)]
    fn swing(self) -> Self {
        self.each(f64::swing)
    }
}

impl Damped for Lanes {}

impl Wide for Lanes {
    #[inline(always)]
    fn widely<W: Work>(work: W) -> W::Output {
        wide::run(work)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers over the ranges that the step has, among them those at which it takes another way.
    const SOME: [f64; LANES] = [0.3, -0.4, 0.01, -0.49, 0.0, 2.5e-7, 0.4999, -1e-3];
    const OTHERS: [f64; LANES] = [1.7, 2.5, 1.01, 30.0, 1.0, 63.9, 64.1, 700.0];

    fn check(name: &str, of: impl Fn(Lanes, Lanes) -> Lanes, plain: impl Fn(f64, f64) -> f64) {
        let found = of(Lanes(SOME), Lanes(OTHERS)).0;
        for lane in 0..LANES {
            let wanted = plain(SOME[lane], OTHERS[lane]);
            assert_eq!(found[lane].to_bits(), wanted.to_bits(), "{name}, lane {lane}");
        }
    }

    /// The same of lanes and of a plain number.
    macro_rules! check {
        ($name:literal, |$x:ident, $y:ident| $of:expr) => {
            check($name, |$x: Lanes, $y: Lanes| $of, |$x: f64, $y: f64| $of)
        };
    }

    #[test]
    fn every_lane_has_the_bits_of_a_float() {
        check!("sum", |x, y| x + y);
        check!("difference", |x, y| x - y);
        check!("product", |x, y| -(x * y));
        check!("quotient", |x, y| x.over(y));
        check!("magnitude", |x, y| Number::abs(x * y));
        check!("decay", |x, y| (x * x + y).exp_minus());
        check!("sine", |x, _y| x.sin_turns());
        check!("cosine", |x, _y| x.cos_turns());
        check!("tangent", |x, y| Elementary::tanh(x * y));
        check!("curve", |x, y| (x * x).stribeck(y).1);
        check!("share", |x, y| (x * x).stribeck(y).0);
        check!("swing", |x, y| (x * y).swing());
        check!("thrice", |x, y| (x * y).thrice().eighth());
        check!("part", |x, y| (x + x).over(y).split_turns().1);
        check!("kick", |x, y| x.kicked::<true>(y, x).risen(y, x));
        check!("bend", |x, y| y.relaxed(x, y, y));
        check!("sum kept", |x, y| x.plus(y, x).0);
        check!("along", |x, y| y.along(x));
        check(
            "turns",
            |x, y| Lanes::wrapped_turns(Lanes::whole(-7), y, x, y),
            |x, y| f64::wrapped_turns(-7, y, x, y),
        );
        check(
            "all turns",
            |x, y| Lanes::wide_turns(Lanes::whole(3), x, y),
            |x, y| f64::wide_turns(3, x, y),
        );
    }
}
