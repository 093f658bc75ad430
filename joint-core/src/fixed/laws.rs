//! The joint's laws where fixed point computes them in its own way: turns, springs, bristles, kicks.

use ::fixed::types::{I0F32, I6F26, I102F26};

use super::lines::{EXPONENTIAL, RELAXATION};
use super::{Fixed, Gain, PLACES, UNIT, from_place, nearest_upper};
use crate::angle::{Turns, counted};
use crate::friction::{Damped, Relaxation, Stribeck};
use crate::gear::Deflection;
use crate::lookup::{Lookup, between};
use crate::number::Number;

impl Turns for Fixed {
    counted!();

    #[inline(always)]
    fn from_turn_counts(counts: i32) -> Fixed {
        Fixed(I6F26::wrapping_from_num(I0F32::from_bits(counts)))
    }
    #[inline(always)]
    fn split_turns(self) -> (i32, Fixed) {
        let whole = (self.to_bits() + UNIT / 2) >> PLACES;
        (whole, Self::from_bits(self.to_bits() - (whole << PLACES)))
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
        let sum = (i64::from(part.to_bits()) << 32) - i64::from(lost.to_bits()) + moved;
        // To the nearest part: the loss then is a signed word.
        let near = ((sum + (1 << 31)) >> 32) as i32;
        let lost = (i64::from(near) << 32) - sum;
        let (whole, part) = Self::from_bits(near).split_turns();
        (whole, part, Self::from_bits(lost as i32))
    }
    fn lost_to_f64(self) -> f64 {
        self.to_f64() / 4_294_967_296.0
    }
    #[inline]
    fn wrapped_turns(whole: i32, whole_ratio: Gain, part: Fixed, ratio: Gain) -> Fixed {
        let turns = (scaled(i64::from(whole) << PLACES, whole_ratio) as i64)
            .wrapping_add(i64::from(part.times(ratio).to_bits()));
        let nearest = (turns + i64::from(UNIT / 2)) >> PLACES;
        Self::from_bits((turns - (nearest << PLACES)) as i32)
    }
    fn wide_turns(whole: i32, part: Fixed, ratio: Gain) -> Fixed {
        let turns = (i64::from(whole) << PLACES) + i64::from(part.to_bits());
        Fixed(I6F26::saturating_from_num(I102F26::from_bits(scaled(turns, ratio))))
    }
}

impl Deflection for Fixed {
    #[inline(always)]
    fn drifted(self, lost: Fixed, change: Fixed, gain: Gain) -> (Fixed, Fixed) {
        let moved = gain.exactly(change);
        let (low, carry) = (lost.to_bits() as u32).overflowing_add(moved as u32);
        let whole = (moved >> 32) as i32 + i32::from(carry);
        (self + Self::from_bits(whole), Self::from_bits(low as i32))
    }
}

impl Stribeck for Fixed {
    const SQUARE: f64 = 1.0;

    /// The exponential from a table with straight lines, to 5e-4. β stands between −0.96 and 7; a level
    /// below 1/32 is taken for that.
    #[inline(always)]
    fn stribeck(self, beta: Fixed) -> (Fixed, Fixed) {
        let decayed = EXPONENTIAL.at(self.to_bits()) as i32;
        let excess = nearest_upper(beta.to_bits() << 2, decayed);
        let level = Self::ONE + Self::from_bits(excess);
        (Self::ONE - level.inverse(), level)
    }
}

impl Relaxation for Fixed {
    const REACH: f64 = 1.0;
    const PER_REACH: Fixed = Self::ONE;
    const RELAXING: [Fixed; 2] = [Self::ONE, Self::HALF];
    const SIXTH: Fixed = Fixed(I6F26::lit("0.1666666667"));
    const ELEVEN_TWELFTHS: Fixed = Fixed(I6F26::lit("0.9166666667"));

    #[inline(always)]
    fn reached(self, gain: Gain, lost: Fixed) -> (Fixed, Fixed) {
        let (reach, rest) = if gain.power == 0 {
            let product = gain.product(self);
            (from_place::<16>(product), (product as u32) << 16)
        } else {
            let moved = gain.exactly(self);
            ((moved >> 32) as i32, moved as u32)
        };
        let (low, carry) = (lost.to_bits() as u32).overflowing_add(rest);
        (Self::from_bits(reach.saturating_add(i32::from(carry))), Self::from_bits(low as i32))
    }
    /// The exact flow, ζ + (1 − exp(−x)) (±level − ζ), as a share of the way to the slip value: the parts of
    /// the quotient that floats take would leave the range. The share over the reach comes from a table
    /// with straight lines, to 6e-5; beyond a reach of 8 the bristle is there.
    #[inline(always)]
    fn relaxed(self, reach: Fixed, rho: Fixed, level: Fixed) -> Fixed {
        let x = reach.abs().nearest(rho).to_bits().clamp(-8 * UNIT, 8 * UNIT - 1);
        let per_reach = RELAXATION.at(x);
        // In steps of 2⁻²⁸.
        let share = (u64::from((x as u32) << 3) * u64::from(per_reach)) >> 32;
        let way = (level.along(reach) - self).to_bits().clamp(-8 * UNIT, 8 * UNIT - 1);
        // To the nearest: rounded down, a bristle in stick would creep.
        self + Self::from_bits(nearest_upper(way << 2, (share as i32) << 2))
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
        Fixed(self.0.wrapping_add(I6F26::from_bits(8)) >> 4)
    }
}

impl Damped for Fixed {
    #[inline(always)]
    fn settled(self) -> Fixed {
        let sign = |bits: i32| (bits as u32 >> 31) as i32;
        let bits = self.to_bits();
        Self::from_bits(bits + sign(bits) - sign(bits.wrapping_neg()))
    }
    /// By products with the share that is lost, in steps of 2⁻³²; a share stops at a half.
    #[inline(always)]
    fn kicked<const SQUARE: bool>(self, gained: Fixed, lost: Fixed) -> Fixed {
        let half = lost.to_bits().clamp(-UNIT, UNIT - 1) << 5;
        let damped = nearest_upper(gained.to_bits(), half);
        let back = if SQUARE { nearest_upper(damped, half) } else { 0 };
        self + (gained - Self::from_bits(damped - back))
    }
    #[inline(always)]
    fn risen(self, _began: Fixed, _lost: Fixed) -> Fixed {
        self
    }
}

impl Lookup for Fixed {
    #[inline(always)]
    fn looked_up(self, knots: &[Fixed]) -> [Fixed; 2] {
        let last = knots.len().saturating_sub(2);
        // A place beside the table is one of its ends: a part is between zero and one.
        let place = i64::from(self.to_bits()) * (last as i64 + 1);
        let at = ((place >> PLACES) as usize).min(last);
        let [before, change] = between(knots, at);
        let share = Self::from_bits((place - ((at as i64) << PLACES)) as i32);
        [before + change * share, change]
    }
}

/// A long number times a constant; not for the plain step.
fn scaled(value: i64, gain: Gain) -> i128 {
    let product = i128::from(value) * i128::from(gain.mantissa.to_bits());
    if gain.power == 0 { product >> 16 } else { (product * i128::from(gain.power)) >> 64 }
}
