//! The step: a forward fourth-order splitting with closed flows for what is stiff.
//!
//! Chin's 4A: kick ⅙, drift ½, kick ⅔ with a force gradient, drift ½, kick ⅙ (Chin, "Symplectic
//! integrators from composite operator factorizations", 1997). The chain itself is not stiff at a
//! drive's step; what is, the bristles and the current, are scalars carried by their own closed
//! flows ([`crate::friction`], [`crate::motor`]). Implicit schemes would damp and shift the chain's
//! fastest mode; this keeps its frequency to 0.2 % at 1.6 rad a micro-step. Every micro-step of a
//! joint without effects does the same operations whatever the data.

mod constants;
mod drift;
mod forces;
mod implicit;
mod kick;
mod levels;
mod memory;
mod torques;

pub use constants::Joint;
pub(crate) use constants::{Implicit, StageConstants, Units};
pub use implicit::IMPLICIT;
pub(crate) use kick::{MIDDLE, OUTER};
pub use torques::Torques;

use crate::effect::Effects;
use crate::scalar::Scalar;
use crate::state::{Each, Input, State};
use crate::work::widely;
use levels::settle;

impl<S: Scalar, const N: usize, E: Effects<S>> Joint<S, N, E> {
    /// Advances the state by one step under an input that is held over it.
    #[inline]
    pub fn step(&self, state: &mut State<S, N>, input: Input<S>) {
        for _ in 0..self.micro_steps {
            self.micro_step(state, input);
        }
        if IMPLICIT && S::IMPLICIT && self.micro_steps == 0 {
            self.step_implicitly(state, input);
        }
    }

    /// A function of its own: inlined into the loop over micro-steps, its constants would all be
    /// loaded before the loop, spilled, and loaded again.
    #[inline(never)]
    fn micro_step(&self, state: &mut State<S, N>, input: Input<S>) {
        widely!(<S, N, E>(
            joint: &'a Joint<S, N, E> = self,
            state: &'a mut State<S, N> = state,
            input: Input<S> = input,
        ) -> () { joint.micro_step_here(state, input) });
    }

    #[inline(always)]
    fn micro_step_here(&self, state: &mut State<S, N>, input: Input<S>) {
        self.load(state, input);
        let began = Each::of(state, |mass| mass.force);
        self.kick::<0>(state, input, state.angle, &began);
        let first = Each::of(state, |mass| mass.speed);
        let ahead = state.angle.ahead(first.rotor.times(self.half_turn));
        let halves = self.half_drift(state, input, state.angle, None);
        let gradient = self.forces(state, ahead);
        let joint = S::again(self);
        joint.load(state, input);
        joint.correct(state, &gradient);
        if joint.damped {
            joint.damp(state, &gradient);
        }
        joint.kick::<1>(state, input, ahead, &began);
        if joint.damped {
            joint.damp_back(state, &gradient);
        }
        joint.half_drift(state, input, ahead, Some((&first, &halves)));
        state.angle.turn(first.rotor + state.rotor.speed, joint.half_turn);
        joint.forces(state, state.angle);
        // The load may change before the next micro-step.
        let kept = state.last().force;
        joint.load(state, input);
        let joint = S::again(joint);
        joint.kick::<2>(state, input, state.angle, &began);
        state.last().force = kept;
    }

    /// Lets the load act on the last mass.
    #[inline(always)]
    fn load(&self, state: &mut State<S, N>, input: Input<S>) {
        let mass = state.last();
        mass.force = mass.force - input.load;
    }

    /// Computes what the state caches: after a speed, an angle, a deflection or a bristle was set
    /// from outside.
    #[inline(never)]
    pub fn refresh(&self, state: &mut State<S, N>) {
        widely!(<S, N, E>(
            joint: &'a Joint<S, N, E> = self,
            state: &'a mut State<S, N> = state,
        ) -> () {
            let (rotor, stages) = joint.levels_found(state);
            settle((&joint.effects, 0), &joint.rotor, &mut state.rotor, rotor);
            let levels = stages.into_iter().zip(1..);
            for ((stage, own), (level, k)) in state.stages.iter_mut().zip(&joint.stages).zip(levels) {
                settle((&joint.effects, k), &own.friction, &mut stage.mass, level);
            }
            joint.forces(state, state.angle);
        });
    }
}
