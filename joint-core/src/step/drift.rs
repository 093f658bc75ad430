//! The half drifts: deflections and bristles at speeds that are held.

use super::constants::Joint;
use crate::angle::Angle;
use crate::effect::Effects;
use crate::friction::{Friction, Half, Turn};
use crate::scalar::Scalar;
use crate::state::{Each, Input, Mass, StageState, State};

impl<S: Scalar, const N: usize, E: Effects<S>> Joint<S, N, E> {
    /// Deflections and bristles over half a micro-step at constant speed; in the second half with what
    /// the kick between did to the first one's speeds. Answers with what the second asks of the first.
    #[inline(always)]
    pub(super) fn half_drift(
        &self,
        state: &mut State<S, N>,
        input: Input<S>,
        from: Angle<S>,
        first: Option<(&Each<S, N>, &Each<Half<S>, N>)>,
    ) -> Each<Half<S>, N> {
        if self.effects.has_memory() {
            self.remember(state, input);
        }
        if self.effects.has_levels() {
            return self.half_drift_along(state, from, first);
        }
        let rotor = &mut state.rotor;
        let turn = first.map(|(speeds, halves)| self.rotor.turn(rotor, speeds.rotor, halves.rotor));
        let half = self.rotor.flow_exactly(rotor, turn.as_ref());
        let mut halves = Each { rotor: half, masses: [half; N] };
        let mut before = rotor.speed;
        let stages = state.stages.iter_mut().zip(&self.stages);
        for (((stage, own), half), k) in stages.zip(&mut halves.masses).zip(0..N) {
            let turn = turn_of(&own.friction, &mut stage.mass, first, k);
            let after = stage.mass.speed;
            self.wind(stage, before - after);
            before = after;
            *half = own.friction.flow(&mut stage.mass, turn.as_ref());
        }
        halves
    }

    /// Winds a spring up for half a micro-step.
    #[inline(always)]
    pub(super) fn wind(&self, stage: &mut StageState<S>, relative: S) {
        let (wound, lost) = stage.deflection.drifted(stage.lost, relative, self.half_drift);
        stage.deflection = wound;
        stage.lost = lost;
    }
}

/// What the kick made of one stage's speed.
#[inline(always)]
pub(super) fn turn_of<S: Scalar, const N: usize>(
    friction: &Friction<S>,
    mass: &mut Mass<S>,
    first: Option<(&Each<S, N>, &Each<Half<S>, N>)>,
    k: usize,
) -> Option<Turn<S>> {
    let (speeds, halves) = first?;
    Some(friction.turn(mass, *speeds.masses.get(k)?, *halves.masses.get(k)?))
}
