//! A rotor angle that keeps its resolution over any number of turns.
//!
//! Whole turns are counted apart from the part of a turn, and the part is summed with what rounding
//! takes, so an f32 joint that has turned for hours resolves the same fraction of a turn as
//! at the start. A float sums the part with compensation; a fixed-point part is exact, and wraps for
//! free.

use core::fmt::Debug;

use crate::batch::batch;
use crate::number::Elementary;

/// How a format counts turns.
pub trait Turns: Elementary {
    /// Whole turns.
    type Whole: Copy + Debug + Default + PartialEq;

    /// Whole turns from their exact number; not for the hot path.
    fn whole(turns: i32) -> Self::Whole;
    /// Their number; not for the hot path.
    fn whole_to_f64(whole: Self::Whole) -> f64;
    /// Whole turns and some more; wraps after 2³¹.
    fn counted(whole: Self::Whole, more: Self::Whole) -> Self::Whole;
    /// Turns between −½ and ½ from an encoder's counts of 2⁻³² turn.
    fn from_turn_counts(counts: i32) -> Self;
    /// Whole turns and the rest between −½ and ½, of an angle in turns between −1 and 1.
    fn split_turns(self) -> (Self::Whole, Self);
    /// A part of a turn and what it has lost, after less than half a turn more: whole turns, the part
    /// and the loss.
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
}

/// One number's whole turns are a count.
macro_rules! counted {
    () => {
        type Whole = i32;

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

pub(crate) use counted;

macro_rules! float {
    ($float:ident) => {
        impl Turns for $float {
            counted!();

            #[inline(always)]
            fn from_turn_counts(counts: i32) -> $float {
                counts as $float * (1.0 / 4_294_967_296.0)
            }
            #[inline(always)]
            fn split_turns(self) -> (i32, $float) {
                let whole = (self + self) as i32;
                (whole, self - whole as $float)
            }
            #[inline(always)]
            fn wrapped_turns(
                whole: i32,
                whole_ratio: $float,
                part: $float,
                ratio: $float,
            ) -> $float {
                let turns = whole as $float * whole_ratio + part * ratio;
                let nearest = (turns + if turns < 0.0 { -0.5 } else { 0.5 }) as i32;
                turns - nearest as $float
            }
            #[inline(always)]
            fn wide_turns(whole: i32, part: $float, ratio: $float) -> $float {
                (whole as $float + part) * ratio
            }
        }
    };
}

float!(f32);
float!(f64);

/// An angle in turns: a whole number and a part between −½ and ½.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S::Whole: serde::Serialize",
        deserialize = "S::Whole: serde::Deserialize<'de>"
    ))
)]
pub struct Angle<S: Turns> {
    /// Whole turns; wraps after 2³¹.
    pub whole: S::Whole,
    /// Part of a turn, −½ to ½.
    pub part: S,
    /// What the sum has lost by rounding, and is still owed; see [`Turns::summed`].
    pub lost: S,
}

impl<S: Turns> Angle<S> {
    /// From an angle in turns; not for the hot path.
    pub fn from_turns(turns: f64) -> Self {
        let whole = libm::round(turns);
        Self { whole: S::whole(whole as i32), part: S::from_f64(turns - whole), lost: S::ZERO }
    }

    /// The angle in turns; not for the hot path.
    pub fn to_turns(self) -> f64 {
        S::whole_to_f64(self.whole) + self.part.to_f64() - self.lost.lost_to_f64()
    }

    /// Adds less than half a turn.
    #[inline(always)]
    pub fn advance(&mut self, turns: S) {
        let (whole, part, lost) = S::summed(self.part, self.lost, turns);
        self.whole = S::counted(self.whole, whole);
        self.part = part;
        self.lost = lost;
    }

    /// Adds a motion at this speed, less than half a turn, with what rounding would take of it.
    #[inline(always)]
    pub fn turn(&mut self, speed: S, turns_per_speed: S::Gain) {
        let (whole, part, lost) = S::turned(self.part, self.lost, speed, turns_per_speed);
        self.whole = S::counted(self.whole, whole);
        self.part = part;
        self.lost = lost;
    }

    /// The angle a little further, without the book-keeping of [`Angle::advance`].
    #[inline(always)]
    pub fn ahead(&self, turns: S) -> Self {
        Self { whole: self.whole, part: self.part + turns, lost: S::ZERO }
    }
}

/// A ratio by which angles are multiplied before they are wrapped: an order, or one over a gear's
/// reduction. For whole orders the turn count drops out without rounding.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct Ratio<S: Turns> {
    per_part: S::Gain,
    per_turn: S::Gain,
}

batch!(Ratio<Turns>: per_part, per_turn);

impl<S: Turns> Ratio<S> {
    /// From its exact value.
    pub fn new(ratio: f64) -> Self {
        Self { per_part: S::gain(ratio), per_turn: S::gain(ratio - libm::round(ratio)) }
    }

    /// The product's part of a turn, −½ to ½.
    #[inline(always)]
    pub fn of(&self, angle: Angle<S>) -> S {
        S::wrapped_turns(angle.whole, self.per_turn, angle.part, self.per_part)
    }

    /// The product with all its turns.
    #[inline(always)]
    pub fn wide(&self, angle: Angle<S>) -> S {
        S::wide_turns(angle.whole, angle.part, self.per_part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_million_small_steps_in_f32_lose_less_than_a_millionth_of_a_turn() {
        let mut angle = Angle::<f32>::default();
        let step = 0.012_345_679_f32;
        for _ in 0..1_000_000 {
            angle.advance(step);
        }
        // The wrap itself rounds: half an ulp of ½ each time a turn is completed.
        let bound = 12_346.0 * 3e-8 + 1e-6;
        assert!((angle.to_turns() - 1e6 * f64::from(step)).abs() < bound);
    }

    #[test]
    fn turns_wrap_to_the_nearest_whole_turn_in_both_directions() {
        assert!((f64::wrapped_turns(10, 0.1, 0.25, 0.1) - 0.025).abs() < 1e-12);
        assert!((f64::wrapped_turns(-10, 0.1, -0.25, 0.1) + 0.025).abs() < 1e-12);
        let ratio = 1.0 / 1024.0;
        assert!((f32::wrapped_turns(1000, ratio, 0.0, ratio) + 24.0 / 1024.0).abs() < 1e-6);
    }

    #[test]
    fn a_whole_order_is_exact_after_any_number_of_turns() {
        let angle = Angle::<f32> { whole: 1_234_567, part: 0.125, lost: 0.0 };
        assert_eq!(Ratio::new(42.0).of(angle), 42.0 * 0.125 - 5.0);
    }

    #[test]
    fn a_reduction_keeps_the_turn_count() {
        let angle = Angle::<f64> { whole: -40, part: 0.25, lost: 0.0 };
        let wanted: f64 = -39.75 / 32.0 + 1.0;
        assert!((Ratio::new(1.0 / 32.0).of(angle) - wanted).abs() < 1e-12);
    }
}
