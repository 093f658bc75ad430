//! How the next state follows from this one: the derivatives with every state and with the drive, by
//! states a small step apart that are run side by side.

use std::f64::consts::TAU;

use joint_core::angle::Angle;
use joint_core::effect::MEMORIES;
use joint_core::number::Number;
use joint_core::work::Work;

use super::{Built, Joints, LANES, Lanes, Woven};
use crate::layout::{Layout, MAX_STAGES};
use crate::wide;

/// A plant's derivatives with its own state.
pub trait Linear: Send + Sync {
    /// Advances a state over the interval after sample `k`, as
    /// [`crate::plant::Plant::propagate_switched`], and adds to `transition` by rows the derivative of
    /// each state with each, to `by_drive` that with a change of the drive that lasts over the interval.
    /// `steps` are those of the states, then that of the drive.
    fn propagate(
        &self,
        k: usize,
        state: &mut [f64],
        inputs: ([f64; 2], f64),
        steps: &[f64],
        derivatives: (&mut Vec<f64>, &mut Vec<f64>),
    );
}

/// The derivatives of joints.
pub fn linear<const N: usize>(
    joints: &Joints<N>,
    serves: &[u32],
    switched: bool,
) -> Box<dyn Linear> {
    let own = Built::new(&[joints], serves, switched);
    Box::new(own.expect("a joint's constants are those of a joint"))
}

/// Most numbers of a state.
const MOST: usize = 4 + 3 * MAX_STAGES + MEMORIES;

impl<const N: usize> Linear for Built<N> {
    fn propagate(
        &self,
        k: usize,
        state: &mut [f64],
        (drives, load): ([f64; 2], f64),
        steps: &[f64],
        (transition, by_drive): (&mut Vec<f64>, &mut Vec<f64>),
    ) {
        let n = state.len();
        let [transitions, slopes] = [transition.len(), by_drive.len()];
        transition.resize(transitions + n * n, 0.0);
        by_drive.resize(slopes + n, 0.0);
        let transition = &mut transition[transitions..];
        let by_drive = &mut by_drive[slopes..];
        let mut before: Option<(Vec<f64>, Vec<f64>)> = None;
        for (joint, drive) in self.parts(k, drives) {
            let inputs = [drive, load];
            wide::run(Linearised {
                joint,
                state: &mut *state,
                inputs,
                steps,
                transition: &mut *transition,
                by_drive: &mut *by_drive,
            });
            if let Some((first, driven)) = &before {
                follow(n, (first, driven), transition, by_drive);
            } else if self.switched {
                before = Some((transition.to_vec(), by_drive.to_vec()));
            }
        }
    }
}

/// Makes the derivatives over a part of an interval those over what was before it too.
fn follow(
    n: usize,
    (first, driven): (&[f64], &[f64]),
    transition: &mut [f64],
    by_drive: &mut [f64],
) {
    for (row, slope) in transition.chunks_exact_mut(n).zip(by_drive) {
        let mut own = [0.0; MOST];
        own[..n].copy_from_slice(row);
        *slope += own.iter().zip(&driven[..n]).map(|(a, b)| a * b).sum::<f64>();
        for (column, value) in row.iter_mut().enumerate() {
            *value = (0..n).map(|j| own[j] * first[j * n + column]).sum();
        }
    }
}

/// One step of a joint and its derivatives.
struct Linearised<'a, const N: usize> {
    joint: &'a Woven<N>,
    state: &'a mut [f64],
    inputs: [f64; 2],
    steps: &'a [f64],
    transition: &'a mut [f64],
    by_drive: &'a mut [f64],
}

impl<const N: usize> Work for Linearised<'_, N> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { joint, state, inputs: [drive, load], steps, transition, by_drive } = self;
        let n = state.len();
        let mut next = [0.0; MOST];
        let mut turned = None;
        // The first lane of all is moved nowhere; the others in one number each, the drive last.
        for first in (0..n + 2).step_by(LANES) {
            let mut flat = [Lanes::ZERO; MOST];
            for (lanes, value) in flat.iter_mut().zip(&*state) {
                *lanes = Lanes::all(*value);
            }
            let mut driven = Lanes::all(drive);
            // What nobody asked for is divided by one.
            let mut moved = Lanes::ONE;
            let columns = first.max(1)..(first + LANES).min(n + 2);
            for column in columns.clone() {
                let (lane, number) = (column - first, column - 1);
                let value = if number == n { &mut driven } else { &mut flat[number] };
                let here = value.0[lane];
                value.0[lane] += steps[number];
                moved.0[lane] = value.0[lane] - here;
            }
            let flat = &mut flat[..n];
            let Angle { whole, part, lost } = joint.step(flat, driven, load);
            // Of an angle of many turns the last digits are too coarse to be differenced.
            let [whole_0, part_0, lost_0] =
                *turned.get_or_insert([whole, part, lost].map(|of| Lanes::all(of.to_f64())));
            let angle = ((whole - whole_0) + (part - part_0) - (lost - lost_0)) * Lanes::all(TAU);
            if first == 0 {
                for (next, lanes) in next.iter_mut().zip(&*flat) {
                    *next = lanes.to_f64();
                }
            }
            for (i, lanes) in flat.iter_mut().enumerate() {
                let change = if i == Layout::ANGLE { angle } else { *lanes - Lanes::all(next[i]) };
                *lanes = change.over(moved);
            }
            for column in columns {
                let (lane, number) = (column - first, column - 1);
                let (slopes, stride) = match number == n {
                    true => (&mut by_drive[..], 1),
                    false => (&mut transition[number..], n),
                };
                for (slope, lanes) in slopes.iter_mut().step_by(stride).zip(&*flat) {
                    *slope = lanes.0[lane];
                }
            }
        }
        state.copy_from_slice(&next[..n]);
    }
}
