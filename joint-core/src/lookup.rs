//! How each format looks into a table of values.

use crate::number::Number;

/// How a format looks into a table.
pub trait Lookup: Number {
    /// The value of the curve through `knots` at a part of its length from 0 to 1, and its change from
    /// the knot before to the knot behind.
    fn looked_up(self, knots: &[Self]) -> [Self; 2];
}

/// Knot before and behind number `at`, and how far a place lies from the first to the second.
#[inline(always)]
pub(crate) fn between<S: Number>(knots: &[S], at: usize) -> [S; 2] {
    let knot = |k: usize| knots.get(k).copied().unwrap_or_default();
    let before = knot(at);
    [before, knot(at + 1) - before]
}

macro_rules! float {
    ($float:ident) => {
        impl Lookup for $float {
            #[inline(always)]
            fn looked_up(self, knots: &[Self]) -> [Self; 2] {
                let last = knots.len().saturating_sub(2);
                let place = self * (last + 1) as $float;
                // A float becomes the nearest whole number that there is, zero where it is none.
                let at = (place as usize).min(last);
                let [before, change] = between(knots, at);
                [before + change * (place - at as $float), change]
            }
        }
    };
}

float!(f32);
float!(f64);
