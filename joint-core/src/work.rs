//! The step as work that a number may have done in its own way.
//!
//! A drive is compiled for its one processor. A host is not: a program for every processor of its kind
//! leaves half the width of most of them idle. So a number of many lanes gets the step whole, to
//! compile it for wider registers as well.

use crate::effect::Effects;
use crate::friction::{Friction, Half, Turn};
use crate::joint::{Input, Joint, Mass, State};
use crate::scalar::Scalar;

/// Work whose functions are inlined into whoever runs it.
pub trait Work {
    /// What comes of it.
    type Output;
    /// Does it.
    fn run(self) -> Self::Output;
}

/// One micro-step of a joint.
pub(crate) struct MicroStep<'a, S: Scalar, const N: usize, E> {
    pub(crate) joint: &'a Joint<S, N, E>,
    pub(crate) state: &'a mut State<S, N>,
    pub(crate) input: Input<S>,
}

impl<S: Scalar, const N: usize, E: Effects<S>> Work for MicroStep<'_, S, N, E> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.joint.micro_step_here(self.state, self.input);
    }
}

/// What effects remember, half a micro-step on.
pub(crate) struct Remember<'a, S: Scalar, const N: usize, E> {
    pub(crate) joint: &'a Joint<S, N, E>,
    pub(crate) state: &'a mut State<S, N>,
}

impl<S: Scalar, const N: usize, E: Effects<S>> Work for Remember<'_, S, N, E> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.joint.remember_here(self.state);
    }
}

/// What is kept beside one bristle, found anew.
pub(crate) struct Settle<'a, S: Scalar> {
    pub(crate) friction: &'a Friction<S>,
    pub(crate) mass: &'a mut Mass<S>,
    pub(crate) inverse_level: S,
}

impl<S: Scalar> Work for Settle<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.friction.settle_here(self.mass, self.inverse_level);
    }
}

/// One bristle's flow along a level that changes.
pub(crate) struct FlowAlong<'a, S: Scalar> {
    pub(crate) friction: &'a Friction<S>,
    pub(crate) mass: &'a mut Mass<S>,
    pub(crate) turn: Option<&'a Turn<S>>,
    pub(crate) inverse_levels: Option<[S; 2]>,
}

impl<S: Scalar> Work for FlowAlong<'_, S> {
    type Output = Half<S>;

    #[inline(always)]
    fn run(self) -> Half<S> {
        self.friction.flow_along_here(self.mass, self.turn, self.inverse_levels)
    }
}

/// What the state of a joint caches, computed anew.
pub(crate) struct Refresh<'a, S: Scalar, const N: usize, E> {
    pub(crate) joint: &'a Joint<S, N, E>,
    pub(crate) state: &'a mut State<S, N>,
}

impl<S: Scalar, const N: usize, E: Effects<S>> Work for Refresh<'_, S, N, E> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.joint.refresh_here(self.state);
    }
}
