//! Tables: what a law is along a coordinate for which there is no equation.
//!
//! A table holds a piecewise linear curve over even knots, or two of them, one for each direction of
//! motion. It stands beside the laws that look into it: inside of them it would make every law of an
//! effect set as large as the largest table. Its values are relative to the largest of them, so that
//! fixed point resolves them whatever their unit.

use heapless::Vec;

use crate::angle::{Angle, Ratio};
use crate::batch::{Batch, Numbers, batch};
use crate::params::{Check, ParameterError, Reason};
use crate::scalar::Scalar;

/// Most knots of one table, those of both directions counted.
pub const MAX_KNOTS: usize = 64;
/// Most tables of one joint.
pub const MAX_TABLES: usize = 1;
/// Numbers of a table: a periodic curve has its first knot again at its end.
const ROOM: usize = MAX_KNOTS + 2;

/// What a kind's table is like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableSpec {
    /// Key in the model file, with its unit, of the knots in both directions, or in the positive one.
    pub forward: &'static str,
    /// Key of the knots in the negative direction; where it is left out both have the same.
    pub backward: &'static str,
    /// Most knots of one curve.
    pub most: usize,
    /// Smallest admissible knot.
    pub low: f64,
    /// Largest admissible knot.
    pub high: f64,
    /// The knots of the spec's example, forward and backward.
    pub example: [&'static [f64]; 2],
}

/// The knots of an effect in SI: one curve, or as many again for the negative direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knots {
    values: [f64; MAX_KNOTS],
    count: usize,
    both: bool,
}

impl Default for Knots {
    fn default() -> Self {
        Self::NONE
    }
}

impl Knots {
    /// None.
    pub const NONE: Self = Self { values: [0.0; MAX_KNOTS], count: 0, both: false };

    /// A curve, and one of its own for the negative direction if `backward` is not empty; `None` where
    /// that has another number of knots, or there are more than [`MAX_KNOTS`].
    pub const fn new(forward: &[f64], backward: &[f64]) -> Option<Self> {
        let both = !backward.is_empty();
        if both && backward.len() != forward.len() {
            return None;
        }
        let mut knots = Self { count: forward.len(), both, ..Self::NONE };
        let Some(rest) = filled(&mut knots.values, forward) else { return None };
        if filled(rest, backward).is_some() { Some(knots) } else { None }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The knots in the positive direction, or in both.
    pub fn forward(&self) -> &[f64] {
        self.values.get(..self.count).unwrap_or_default()
    }

    /// The knots in the negative direction; empty where they are those of the positive one.
    pub fn backward(&self) -> &[f64] {
        let end = if self.both { 2 * self.count } else { self.count };
        self.values.get(self.count..end).unwrap_or_default()
    }

    /// All of them.
    pub fn all(&self) -> impl Iterator<Item = f64> + '_ {
        self.forward().iter().chain(self.backward()).copied()
    }

    /// Largest magnitude.
    pub fn largest(&self) -> f64 {
        self.all().fold(0.0, |most, value| libm::fabs(value).max(most))
    }

    /// Largest step from one knot to the next, that from the last to the first counted where the curve
    /// is periodic.
    pub fn steepest(&self, periodic: bool) -> f64 {
        let of = |curve: &[f64]| {
            let ends = match (periodic, curve) {
                (true, [first, .., last]) => libm::fabs(first - last),
                _ => 0.0,
            };
            curve.windows(2).fold(ends, |most, pair| match pair {
                [from, to] => libm::fabs(to - from).max(most),
                _ => most,
            })
        };
        of(self.forward()).max(of(self.backward()))
    }

    /// Largest difference of the two directions.
    pub fn apart(&self) -> f64 {
        let pairs = self.forward().iter().zip(self.backward());
        pairs.fold(0.0, |most, (forward, backward)| libm::fabs(forward - backward).max(most))
    }

    /// Checks the knots against what their kind asks for.
    pub(super) fn validate(&self, spec: &TableSpec, check: &Check) -> Result<(), ParameterError> {
        if self.count < 2 || self.count > spec.most {
            let reason = Reason::Knots { least: 2, most: spec.most };
            return Err(check.fail(spec.forward, self.count as f64, reason));
        }
        for (key, curve) in [(spec.forward, self.forward()), (spec.backward, self.backward())] {
            for value in curve {
                check.finite(key, *value)?;
                if *value < spec.low || *value > spec.high {
                    let reason = Reason::OutOfRange { low: spec.low, high: spec.high };
                    return Err(check.fail(key, *value, reason));
                }
            }
        }
        Ok(())
    }
}

/// Writes values into the first of these places and gives the others; `None` where there are too few.
const fn filled<'a>(mut places: &'a mut [f64], mut values: &[f64]) -> Option<&'a mut [f64]> {
    while let [value, other_values @ ..] = values {
        let [place, others @ ..] = places else { return None };
        *place = *value;
        (places, values) = (others, other_values);
    }
    Some(places)
}

/// A table in the numbers of a joint.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct Table<S: Scalar> {
    /// Those of the positive direction, then those of the negative one if it has its own; relative to
    /// the largest.
    knots: Vec<S, ROOM>,
    both: bool,
}

impl<U: Scalar<Gain = U>> Batch<U> for Table<f64> {
    type Batched = Table<U>;
    fn batch(&self, numbers: &mut impl Numbers<U>) -> Table<U> {
        let knots = self.knots.iter().map(|knot| numbers.number(*knot)).collect();
        Table { knots, both: self.both }
    }
}

impl<S: Scalar> Table<S> {
    /// Of an effect's knots; a periodic curve ends where it begins.
    pub fn new(knots: &Knots, periodic: bool) -> Self {
        let largest = knots.largest();
        let per_largest = if largest > 0.0 { 1.0 / largest } else { 0.0 };
        let mut table = Self { knots: Vec::new(), both: knots.both };
        for curve in [knots.forward(), knots.backward()] {
            let again = curve.first().filter(|_| periodic);
            for value in curve.iter().chain(again) {
                table.knots.push(S::from_f64(value * per_largest)).ok();
            }
        }
        table
    }

    /// Value and change from knot to knot at a part of the length, in the positive and in the negative
    /// direction, relative to the largest knot.
    #[inline(always)]
    pub fn at(&self, part: S) -> [[S; 2]; 2] {
        if !self.both {
            let one = part.looked_up(&self.knots);
            return [one; 2];
        }
        let (forward, backward) = self.knots.split_at(self.knots.len() / 2);
        [part.looked_up(forward), part.looked_up(backward)]
    }
}

/// The tables of a joint.
pub type Tables<S> = Vec<Table<S>, MAX_TABLES>;

/// The table with this number.
#[inline(always)]
pub(super) fn table<S: Scalar>(tables: &Tables<S>, number: u8) -> Option<&Table<S>> {
    tables.get(usize::from(number))
}

/// A number from 0 to 1.
#[inline(always)]
pub(super) fn unit<S: Scalar>(value: S) -> S {
    let value = S::choose(value.below(S::ZERO), S::ZERO, value);
    S::choose(S::ONE.below(value), S::ONE, value)
}

/// Where an angle stands on a curve, as a part of its length.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub(super) struct Course<S: Scalar> {
    ratio: Ratio<S>,
    start: S,
    periodic: bool,
}

batch!(Course<Scalar>: ratio, start; periodic);

impl<S: Scalar> Course<S> {
    /// From `start` over `length`, rad of the mass, again and again where it is periodic; `shaft` is the
    /// product of the ratios from the motor to the mass.
    pub(super) fn new(start: f64, length: f64, periodic: bool, shaft: f64) -> Self {
        let begins = start / length;
        let start = if periodic { begins - libm::round(begins) } else { begins };
        let ratio = Ratio::new(shaft * core::f64::consts::TAU / length);
        Self { ratio, start: S::from_f64(start), periodic }
    }

    /// The part of the length, from 0 to 1, at an angle at the motor.
    #[inline(always)]
    pub(super) fn part(&self, angle: Angle<S>) -> S {
        if self.periodic {
            let part = self.ratio.of(angle) - self.start;
            return unit(S::choose(part.below(S::ZERO), part + S::ONE, part));
        }
        unit(self.ratio.wide(angle) - self.start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixed::Fixed;
    use crate::number::Number;

    const FORWARD: [f64; 4] = [1.0, -2.0, 0.5, 4.0];
    const BACKWARD: [f64; 4] = [0.0, 1.0, 1.0, -3.0];

    fn line(curve: &[f64], part: f64) -> f64 {
        let place = part * (curve.len() - 1) as f64;
        let at = (place as usize).min(curve.len() - 2);
        curve[at] + (curve[at + 1] - curve[at]) * (place - at as f64)
    }

    fn assert_lines<S: Scalar>(within: f64) {
        let knots = Knots::new(&FORWARD, &BACKWARD).unwrap();
        let table = Table::<S>::new(&knots, false);
        for k in 0..=1000 {
            let part = f64::from(k) / 1000.0;
            let found = table.at(S::from_f64(part));
            for (curve, [value, _]) in [FORWARD, BACKWARD].iter().zip(found) {
                let error = value.to_f64() - line(curve, part) / 4.0;
                assert!(error.abs() < within, "{part}: {error}");
            }
        }
    }

    #[test]
    fn every_format_follows_the_lines_between_the_knots() {
        assert_lines::<f64>(1e-12);
        // A part in 2²⁴ of a slope of three, and of one in 2²⁶.
        assert_lines::<f32>(1e-6);
        assert_lines::<Fixed>(2e-7);
    }

    #[test]
    fn beyond_its_ends_a_part_is_taken_for_the_nearest() {
        for part in [-1e9_f64, -0.1, 0.0, 0.4, 1.0, 1.1, 31.0, 1e9] {
            assert_eq!(unit(part), part.clamp(0.0, 1.0));
            let part = part.clamp(-31.0, 31.0);
            assert!((unit(Fixed::from_f64(part)).to_f64() - part.clamp(0.0, 1.0)).abs() < 1e-7);
        }
        let table = Table::<f32>::new(&Knots::new(&FORWARD, &[]).unwrap(), false);
        let [[last, change], _] = table.at(1.0);
        assert_eq!((last, change), (1.0, 0.875));
    }

    #[test]
    fn a_periodic_course_goes_on_where_it_ends_at_any_number_of_turns() {
        use core::f64::consts::TAU;
        let (start, period, shaft) = (0.3, 2.5, -0.25);
        let table = Table::<f64>::new(&Knots::new(&FORWARD, &[]).unwrap(), true);
        let course = Course::<f64>::new(start, period, true, shaft);
        let closed = [FORWARD[0], FORWARD[1], FORWARD[2], FORWARD[3], FORWARD[0]];
        for k in -400..400 {
            let q = 0.173 * f64::from(k);
            let angle = Angle::from_turns(q / shaft / TAU);
            let [[value, _], _] = table.at(course.part(angle));
            let wanted = line(&closed, ((q - start) / period).rem_euclid(1.0)) / 4.0;
            assert!((value - wanted).abs() < 1e-9, "{q}: {value}, {wanted}");
        }
    }

    #[test]
    fn a_span_ends_at_its_ends() {
        use core::f64::consts::TAU;
        let (start, span) = (-4.0, 30.0);
        let course = Course::<f64>::new(start, span, false, 0.5);
        for q in [-100.0_f64, -4.0, 0.0, 13.7, 26.0, 900.0] {
            let part = course.part(Angle::from_turns(q / 0.5 / TAU));
            assert!((part - ((q - start) / span).clamp(0.0, 1.0)).abs() < 1e-9, "{q}");
        }
    }

    #[test]
    fn knots_are_taken_as_one_curve_or_as_two_of_one_length() {
        let one = Knots::new(&FORWARD, &[]).unwrap();
        assert_eq!((one.forward(), one.backward().len()), (&FORWARD[..], 0));
        assert_eq!((one.largest(), one.steepest(false), one.steepest(true)), (4.0, 3.5, 3.5));
        let two = Knots::new(&FORWARD, &BACKWARD).unwrap();
        assert_eq!((two.backward(), two.steepest(false), two.apart()), (&BACKWARD[..], 4.0, 7.0));
        assert!(Knots::new(&FORWARD, &BACKWARD[..3]).is_none());
        assert!(Knots::new(&[0.0; MAX_KNOTS], &[]).is_some());
        assert!(Knots::new(&[0.0; MAX_KNOTS + 1], &[]).is_none());
        assert!(Knots::new(&[0.0; 33], &[0.0; 33]).is_none());
    }
}
