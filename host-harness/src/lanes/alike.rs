//! Joints that differ by their numbers alone.

use std::slice;

use joint_core::batch::{Batch, Numbers};
use joint_core::effect::EffectSet;
use joint_core::joint::Joint;

use super::number::{LANES, Lanes};

/// Share by which the rates over one step and over two may differ, and what rounding makes of a number.
const SMOOTH: f64 = 1e-3;
const ROUNDING: f64 = 1e-14;

/// Some joints with the same laws at the same places, and the numbers of each in the same order.
pub(super) struct Alike<'a, const N: usize, const L: usize> {
    first: &'a Joint<f64, N, EffectSet<f64>>,
    numbers: [Vec<f64>; L],
}

impl<'a, const N: usize, const L: usize> Alike<'a, N, L> {
    /// `None` where the joints differ by more than their numbers.
    pub(super) fn of(joints: [&'a Joint<f64, N, EffectSet<f64>>; L]) -> Option<Self> {
        let first = *joints.first()?;
        let numbers = joints.map(|joint| {
            let mut list = List(Vec::new());
            let _same: Joint<f64, N, EffectSet<f64>> = joint.batch(&mut list);
            list.0
        });
        let alike = joints.iter().zip(&numbers).all(|(joint, own)| {
            own.len() == numbers[0].len() && first.batch(&mut Row(own.iter())) == **joint
        });
        alike.then_some(Self { first, numbers })
    }

    /// Whether the second and the third are reached at the same rate, by one step and by two.
    pub(super) fn moves_smoothly(&self) -> bool {
        let [here, one, two, ..] = self.numbers.as_slice() else { return false };
        here.iter().zip(one).zip(two).all(|((here, one), two)| {
            // What is infinite in both does not move.
            let rate =
                |there: &f64, steps| if there == here { 0.0 } else { (there - here) / steps };
            let (one, two) = (rate(one, 1.0), rate(two, 2.0));
            let rounding = ROUNDING * here.abs();
            let unlike = (one - two).abs() > SMOOTH * one.abs().max(two.abs()) + rounding;
            !unlike
        })
    }
}

impl<const N: usize> Alike<'_, N, LANES> {
    /// All of them as one joint whose numbers have lanes.
    pub(super) fn side_by_side(&self) -> Joint<Lanes, N, EffectSet<Lanes>> {
        self.first.batch(&mut Columns { rows: &self.numbers, next: 0 })
    }
}

/// Lists numbers.
struct List(Vec<f64>);

impl Numbers<f64> for List {
    fn number(&mut self, own: f64) -> f64 {
        self.0.push(own);
        own
    }
    fn exact(&mut self, own: f64) -> f64 {
        self.number(own)
    }
}

/// Takes listed numbers instead.
struct Row<'a>(slice::Iter<'a, f64>);

impl Numbers<f64> for Row<'_> {
    fn number(&mut self, own: f64) -> f64 {
        self.0.next().copied().unwrap_or(own)
    }
    fn exact(&mut self, own: f64) -> f64 {
        self.number(own)
    }
}

/// Takes the listed numbers of every lane; what is exact is the first one's.
struct Columns<'a> {
    rows: &'a [Vec<f64>; LANES],
    next: usize,
}

impl Numbers<Lanes> for Columns<'_> {
    fn number(&mut self, _own: f64) -> Lanes {
        let place = self.next;
        self.next += 1;
        Lanes(self.rows.each_ref().map(|row| row[place]))
    }
    fn exact(&mut self, own: f64) -> f64 {
        self.next += 1;
        own
    }
}
