//! How the next state follows from this one: the derivatives with every state and with the drive, in
//! as few lanes as hold them.

use joint_core::effect::EffectSet;
use joint_core::joint::Joint;

use super::{Built, Dual, LANES, Tangent, built};

/// Few lanes, and more: half a joint's time goes into them.
const FEW: usize = 8;
const SOME: usize = 12;

/// A plant's derivatives with its own state.
pub trait Linear: Send + Sync {
    /// Advances a state over the interval after sample `k`, as [`crate::plant::Plant::propagate`],
    /// and adds to `transition` by rows the derivative of each state with each, to `by_drive` that
    /// with the drive.
    fn propagate(
        &self,
        k: usize,
        state: &mut [f64],
        inputs: [f64; 2],
        transition: &mut Vec<f64>,
        by_drive: &mut Vec<f64>,
    );
}

/// The derivatives of joints with `states` states; `None` for more than there are lanes for.
pub(crate) fn linear<const N: usize>(
    joints: &[Joint<f64, N, EffectSet<f64>>],
    serves: &[u32],
    states: usize,
) -> Option<Box<dyn Linear>> {
    // A lane for every state and one for the drive; a rotor has four states and a stage three.
    if const { 4 + 3 * N < FEW } && states < FEW {
        Some(Box::new(built::<N, FEW>(joints, serves, &[])?))
    } else if const { 4 + 3 * N < SOME } && states < SOME {
        Some(Box::new(built::<N, SOME>(joints, serves, &[])?))
    } else if states < LANES {
        Some(Box::new(built::<N, LANES>(joints, serves, &[])?))
    } else {
        None
    }
}

impl<const N: usize, const L: usize> Linear for Built<N, L> {
    fn propagate(
        &self,
        k: usize,
        state: &mut [f64],
        [drive, load]: [f64; 2],
        transition: &mut Vec<f64>,
        by_drive: &mut Vec<f64>,
    ) {
        let n = state.len();
        let mut dual = [Dual::<L>::constant(0.0); L];
        for (lane, (dual, value)) in dual.iter_mut().zip(&*state).enumerate() {
            *dual = Dual::variable(*value, lane);
        }
        Tangent::propagate(self, k, &mut dual[..n], Dual::variable(drive, n), load);
        for (state, dual) in state.iter_mut().zip(&dual) {
            *state = dual.value;
            transition.extend(dual.slopes[..n].iter().map(|slope| f64::from(*slope)));
            by_drive.push(f64::from(dual.slopes[n]));
        }
    }
}
