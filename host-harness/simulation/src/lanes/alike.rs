//! Joints that differ by their numbers alone.

use std::slice;

use joint_core::batch::{Batch, Numbers};
use joint_core::effect::EffectSet;
use joint_core::joint::Joint;

use super::number::{LANES, Lanes};

/// Share by which the rates over one step and over two may differ, and what rounding makes of a number.
const SMOOTH: f64 = 1e-3;
const ROUNDING: f64 = 1e-14;

/// A joint in plain numbers.
pub(super) type Plain<const N: usize> = Joint<f64, N, EffectSet<f64>>;

/// Some joints with the same laws at the same places, and the numbers of each in the same order.
pub(super) struct Alike<'a, const N: usize, const L: usize> {
    first: &'a Plain<N>,
    numbers: [Vec<f64>; L],
}

impl<'a, const N: usize, const L: usize> Alike<'a, N, L> {
    /// `None` where the joints differ by more than their numbers.
    pub(super) fn of(joints: [&'a Plain<N>; L]) -> Option<Self> {
        let first = *joints.first()?;
        let numbers = joints.map(|joint| {
            let mut list = List(Vec::new());
            let _same: Plain<N> = joint.batch(&mut list);
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

#[cfg(test)]
mod tests {
    use joint_core::effect::{EffectParameters, Kind};
    use joint_core::joint::{Drive, Settings};
    use joint_core::params::{Friction, Load, Location, Motor};

    use joint_core::number::Number;

    use super::*;

    fn joint(resistance: f64, micro_steps: u32, effects: &[EffectParameters]) -> Plain<0> {
        let motor = Motor {
            phase_resistance_ohm: resistance,
            phase_inductance_h: 0.8e-3,
            torque_constant_nm_per_a: 0.11,
            rotor_inertia_kg_m2: 1.1e-4,
            friction: Friction {
                sigma0_nm_per_rad: 15.0,
                coulomb_nm: 0.006,
                ..Friction::default()
            },
            ..Motor::default()
        };
        let settings = Settings {
            micro_steps: Some(micro_steps),
            effects,
            ..Settings::new(Drive::Voltage, 5e-5)
        };
        Plain::<0>::new(&motor, &[], &Load::default(), &settings).unwrap()
    }

    #[test]
    fn joints_that_differ_by_more_than_their_numbers_are_not_alike() {
        let effect = |kind| [EffectParameters::new(kind, Location::Motor).with("order", 7.0)];
        let [cogging, ripple] = [Kind::Cogging, Kind::TorqueRipple].map(effect);
        let plain = joint(2.8, 1, &[]);
        assert!(Alike::of([&plain, &joint(3.1, 1, &[])]).is_some());
        assert!(Alike::of([&plain, &joint(2.8, 2, &[])]).is_none());
        assert!(Alike::of([&plain, &joint(2.8, 1, &cogging)]).is_none());
        assert!(Alike::of([&joint(2.8, 1, &ripple), &joint(2.8, 1, &cogging)]).is_none());
    }

    #[test]
    fn numbers_that_leap_between_one_step_and_two_do_not_move_smoothly() {
        let smooth = |two: f64| {
            let joints = [2.8, 2.8 + 1e-7, two].map(|resistance| joint(resistance, 1, &[]));
            Alike::of(joints.each_ref()).unwrap().moves_smoothly()
        };
        assert!(smooth(2.8 + 2e-7));
        assert!(!smooth(2.8 + 3e-7));
    }

    #[test]
    fn a_joint_of_lanes_steps_each_as_it_would_alone() {
        let joints: [Plain<0>; LANES] = std::array::from_fn(|k| joint(2.8 + k as f64, 1, &[]));
        let abreast = Alike::of(joints.each_ref()).unwrap().side_by_side();
        let mut state = abreast.rest();
        abreast.step(&mut state, abreast.input(Lanes::all(1.0), Lanes::ZERO));
        for (joint, speed) in joints.iter().zip(abreast.speed(&state, 0).0) {
            let mut alone = joint.rest();
            joint.step(&mut alone, joint.input(1.0, 0.0));
            assert_eq!(joint.speed(&alone, 0).to_bits(), speed.to_bits());
            assert!(speed > 0.0);
        }
    }
}
