//! A rotor angle that keeps its resolution over any number of turns.
//!
//! Whole turns are counted apart from the part of a turn, and the part is summed with
//! compensation, so an f32 joint that has turned for hours resolves the same fraction of a turn as
//! at the start.

use crate::scalar::Scalar;

/// An angle in turns: a whole number and a part between −½ and ½.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Angle<S: Scalar> {
    /// Whole turns; wraps after 2³¹.
    pub whole: S::Whole,
    /// Part of a turn, −½ to ½.
    pub part: S,
    /// What the sum has lost by rounding, and is still owed; see [`Scalar::summed`].
    pub lost: S,
}

impl<S: Scalar> Angle<S> {
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
pub struct Ratio<S: Scalar> {
    per_part: S::Gain,
    per_turn: S::Gain,
}

impl<S: Scalar> Ratio<S> {
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
