//! What effects remember.

use super::constants::Joint;
use crate::effect::{Effects, Flow, MEMORIES, Relaxation};
use crate::scalar::Scalar;
use crate::state::{Input, State};
use crate::work::widely;

/// Most masses that what effects remember may follow.
const MOST_MASSES: usize = 9;

impl<S: Scalar, const N: usize, E: Effects<S>> Joint<S, N, E> {
    /// What effects remember, over half a micro-step at constant speed, current and input.
    #[inline(never)]
    pub(super) fn remember(&self, state: &mut State<S, N>, input: Input<S>) {
        widely!(<S, N, E>(
            joint: &'a Joint<S, N, E> = self,
            state: &'a mut State<S, N> = state,
            input: Input<S> = input,
        ) -> () {
            let mut speeds = [S::ZERO; MOST_MASSES];
            let masses = core::iter::once(&state.rotor).chain(state.stages.iter().map(|s| &s.mass));
            for (speed, mass) in speeds.iter_mut().zip(masses) {
                *speed = mass.speed;
            }
            let flow = Flow { current: state.current, drive: input.drive, speeds: &speeds };
            let mut all = [None; MEMORIES];
            joint.effects.relax(&flow, &mut all);
            for (value, relaxation) in state.memory.iter_mut().zip(all) {
                if let Some(Relaxation { reach, target }) = relaxation {
                    *value = target + (*value - target) * reach.exp_minus();
                }
            }
        });
    }
}
