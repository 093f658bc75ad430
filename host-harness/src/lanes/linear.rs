//! How the next state follows from this one: the derivatives with every state and with the drive, by
//! states a small step apart that are run side by side.

use std::f64::consts::TAU;

use joint_core::angle::Angle;
use joint_core::effect::{EffectSet, MEMORIES};
use joint_core::joint::Joint;
use joint_core::scalar::Scalar;

use super::{Built, LANES, Lanes, constants};
use crate::plant::{Layout, MAX_STAGES};

/// A plant's derivatives with its own state.
pub trait Linear: Send + Sync {
    /// Advances a state over the interval after sample `k`, as [`crate::plant::Plant::propagate`],
    /// and adds to `transition` by rows the derivative of each state with each, to `by_drive` that
    /// with the drive. `steps` are those of the states, then that of the drive.
    fn propagate(
        &self,
        k: usize,
        state: &mut [f64],
        inputs: [f64; 2],
        steps: &[f64],
        derivatives: (&mut Vec<f64>, &mut Vec<f64>),
    );
}

/// The derivatives of joints.
pub(crate) fn linear<const N: usize>(
    joints: &[Joint<f64, N, EffectSet<f64>>],
    serves: &[u32],
) -> Box<dyn Linear> {
    let own = constants(joints).and_then(|own| Built::<N>::new(&[&own], serves));
    Box::new(own.expect("a joint's constants are those of a joint"))
}

/// Most numbers of a state.
const MOST: usize = 4 + 3 * MAX_STAGES + MEMORIES;

impl<const N: usize> Linear for Built<N> {
    fn propagate(
        &self,
        k: usize,
        state: &mut [f64],
        [drive, load]: [f64; 2],
        steps: &[f64],
        (transition, by_drive): (&mut Vec<f64>, &mut Vec<f64>),
    ) {
        let (joint, n) = (self.joint(k), state.len());
        let begun = transition.len();
        transition.resize(begun + n * n, 0.0);
        let transition = &mut transition[begun..];
        let by_drive_begun = by_drive.len();
        by_drive.resize(by_drive_begun + n, 0.0);
        let by_drive = &mut by_drive[by_drive_begun..];
        let mut next = [0.0; MOST];
        let mut turned = None;
        // The first lane of all is moved nowhere; the others in one number each, the drive last.
        for first in (0..n + 2).step_by(LANES) {
            let mut flat = [[0.0; LANES]; MOST];
            for (lanes, value) in flat.iter_mut().zip(&*state) {
                *lanes = [*value; LANES];
            }
            let mut driven = [drive; LANES];
            let mut moved = [0.0; LANES];
            let columns = first.max(1)..(first + LANES).min(n + 2);
            for column in columns.clone() {
                let (lane, number) = (column - first, column - 1);
                let value = if number == n { &mut driven[lane] } else { &mut flat[number][lane] };
                let here = *value;
                *value += steps[number];
                moved[lane] = *value - here;
            }
            let flat = &mut flat[..n];
            let mut states = joint.unpack(flat);
            joint.step(&mut states, driven, load);
            joint.pack(&states, flat);
            // Of an angle of many turns the last digits are too coarse to be differenced.
            let Angle { whole, part, lost } = states.angle;
            let [whole_0, part_0, lost_0] =
                *turned.get_or_insert([whole, part, lost].map(|of| Lanes::all(of.to_f64())));
            let angle = ((whole - whole_0) + (part - part_0) - (lost - lost_0)) * Lanes::all(TAU);
            if first == 0 {
                for (next, lanes) in next.iter_mut().zip(&*flat) {
                    *next = lanes[0];
                }
            }
            for column in columns {
                let (lane, number) = (column - first, column - 1);
                for i in 0..n {
                    let change = match i {
                        Layout::ANGLE => angle.0[lane],
                        _ => flat[i][lane] - next[i],
                    };
                    let slope = change / moved[lane];
                    if number == n {
                        by_drive[i] = slope;
                    } else {
                        transition[i * n + number] = slope;
                    }
                }
            }
        }
        state.copy_from_slice(&next[..n]);
    }
}
