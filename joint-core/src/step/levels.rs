//! Friction levels that effects change while a joint moves.
//!
//! A level that follows the load or an angle is not the same at both ends of a drift, and the bristle
//! follows it with a lag. So a drift of such a joint asks for every level twice and lets the bristles flow
//! along; a mass that no effect touches flows as ever.

use super::constants::Joint;
use super::drift::turn_of;
use crate::angle::Angle;
use crate::effect::{Effects, Rubbing};
use crate::friction::{Changed, Creep, Friction, Half, Turn};
use crate::scalar::Scalar;
use crate::state::{Each, Mass, State};
use crate::work::widely;

impl<S: Scalar, const N: usize, E: Effects<S>> Joint<S, N, E> {
    /// The half drift where effects change friction levels on the way.
    #[inline(always)]
    pub(super) fn half_drift_along(
        &self,
        state: &mut State<S, N>,
        from: Angle<S>,
        first: Option<(&Each<S, N>, &Each<Half<S>, N>)>,
    ) -> Each<Half<S>, N> {
        let rotor = &mut state.rotor;
        let of_rotor =
            first.map(|(speeds, halves)| self.rotor.turn(rotor, speeds.rotor, halves.rotor));
        let mut turns = [of_rotor; N];
        for (((stage, own), turn), k) in
            state.stages.iter_mut().zip(&self.stages).zip(&mut turns).zip(0..N)
        {
            *turn = turn_of(&own.friction, &mut stage.mass, first, k);
        }
        let before = self.levels(state, from);
        let mut behind = state.rotor.speed;
        for stage in &mut state.stages {
            let after = stage.mass.speed;
            self.wind(stage, behind - after);
            behind = after;
        }
        let turned = match first {
            Some((speeds, _)) => speeds.rotor + state.rotor.speed,
            None => state.rotor.speed,
        };
        let after = self.levels(state, state.angle.ahead(turned.times(self.half_turn)));
        let levels = [before.0, after.0];
        let half = if self.effects.has_level(0) {
            let at = (&self.effects, 0);
            flow_along(at, &self.rotor, &mut state.rotor, of_rotor.as_ref(), Some(levels))
        } else {
            self.rotor.flow_exactly(&mut state.rotor, of_rotor.as_ref())
        };
        let mut halves = Each { rotor: half, masses: [half; N] };
        let levels = before.1.into_iter().zip(after.1);
        let stages = state.stages.iter_mut().zip(&self.stages).zip(&turns).zip(1..=N);
        for (((((stage, own), turn), number), (before, after)), half) in
            stages.zip(levels).zip(&mut halves.masses)
        {
            let (own, at) = (&own.friction, (&self.effects, number));
            let levels = self.effects.has_level(number).then_some([before, after]);
            *half = flow_along(at, own, &mut stage.mass, turn.as_ref(), levels);
        }
        halves
    }

    /// Friction torque on the rotor and on the mass behind each stage as they were last found; not for the step.
    #[inline(never)]
    pub(crate) fn friction(&self, state: &State<S, N>) -> (S, [S; N]) {
        let (rotor, mut felt) = self.levels_found(state);
        let changed = |number, inverse_level| changed((&self.effects, number), inverse_level);
        let rotor = self.rotor.felt(&state.rotor, changed(0, rotor));
        let stages = state.stages.iter().zip(&self.stages).zip(1..);
        for (felt, ((stage, own), number)) in felt.iter_mut().zip(stages) {
            *felt = own.friction.felt(&stage.mass, changed(number, *felt));
        }
        (rotor, felt)
    }

    /// [`Joint::levels`] of a state as it stands. On a chip there is one copy, since flash is short; a host's lanes
    /// need it in place.
    #[cfg_attr(target_os = "none", inline(never))]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub(super) fn levels_found(&self, state: &State<S, N>) -> (S, [S; N]) {
        match self.effects.has_levels() {
            true => self.levels(state, state.angle),
            false => (S::ONE, [S::ONE; N]),
        }
    }

    /// One over the effects' factor on every friction level.
    #[inline(always)]
    pub(super) fn levels(&self, state: &State<S, N>, angle: Angle<S>) -> (S, [S; N]) {
        let (mut rotor, mut levels) = (S::ONE, [S::ONE; N]);
        let (mut wound, mut input) = (S::ZERO, angle);
        let (speed, transmitted) = (state.rotor.speed, state.current);
        // A mass's level is found once the stage behind it is known.
        let mut at = Rubbing { speed, transmitted, passed_on: S::ZERO, angle };
        let mut level = &mut rotor;
        let stages = state.stages.iter().zip(&self.stages);
        for ((next, (stage, constants)), number) in levels.iter_mut().zip(stages).zip(0..N) {
            let mut torque = S::ZERO;
            if self.effects.has_level(number) || self.effects.has_level(number + 1) {
                let felt = self.felt(number, stage.deflection, input);
                let relative = at.speed - stage.mass.speed;
                torque = constants.spring.torque(felt.deflection)
                    + constants.spring.damping_torque(relative) * felt.contact;
                if self.effects.has_stage(number) {
                    let beside = self.effects.stage_torque(number, felt.deflection, &state.memory);
                    torque = torque + beside.value;
                }
            }
            at.passed_on = torque;
            if self.effects.has_level(number) {
                *level = self.effects.inverse_level(number, at);
            }
            level = next;
            wound = wound + stage.deflection;
            if self.effects.has_angled_levels() || self.effects.has_stages() {
                at.angle = angle.ahead(-wound.times(self.turns));
            }
            if self.effects.has_stages() {
                input = constants.own_angle(at.angle);
            }
            at = Rubbing {
                speed: stage.mass.speed,
                transmitted: torque,
                passed_on: S::ZERO,
                angle: at.angle,
            };
        }
        if self.effects.has_level(N) {
            *level = self.effects.inverse_level(N, at);
        }
        (rotor, levels)
    }
}

/// What effects change of the friction of a mass, by its number, whose level they divide by `inverse_level`.
#[inline(always)]
pub(super) fn changed<S: Scalar, E: Effects<S>>(
    (effects, number): (&E, usize),
    inverse_level: S,
) -> Changed<S> {
    let creep = if effects.has_level(number) { effects.creep(number) } else { None };
    Changed { inverse_level, creep }
}

/// [`Friction::settle`] of a mass by its number.
#[inline(always)]
pub(super) fn settle<S: Scalar, E: Effects<S>>(
    (effects, number): (&E, usize),
    friction: &Friction<S>,
    mass: &mut Mass<S>,
    inverse_level: S,
) {
    if E::CHOSEN || effects.has_level(number) {
        settle_changed((effects, number), friction, mass, inverse_level);
    } else {
        friction.settle(mass, Changed { inverse_level: S::ONE, creep: None });
    }
}

/// The same of one whose friction effects change, as a function of its own.
#[inline(never)]
fn settle_changed<S: Scalar, E: Effects<S>>(
    at: (&E, usize),
    friction: &Friction<S>,
    mass: &mut Mass<S>,
    inverse_level: S,
) {
    let changed = changed(at, inverse_level);
    widely!(<S>(
        friction: &'a Friction<S> = friction,
        mass: &'a mut Mass<S> = mass,
        changed: Changed<S> = changed,
    ) -> () { friction.settle(mass, changed) });
}

/// [`Friction::flow_along`] as a function of its own: every mass calls the same one.
#[inline(never)]
fn flow_along<S: Scalar, E: Effects<S>>(
    (effects, number): (&E, usize),
    friction: &Friction<S>,
    mass: &mut Mass<S>,
    turn: Option<&Turn<S>>,
    inverse_levels: Option<[S; 2]>,
) -> Half<S> {
    let creep = inverse_levels.and_then(|_| effects.creep(number));
    widely!(<S>(
        friction: &'a Friction<S> = friction,
        mass: &'a mut Mass<S> = mass,
        turn: Option<&'a Turn<S>> = turn,
        inverse_levels: Option<[S; 2]> = inverse_levels,
        creep: Option<Creep<S>> = creep,
    ) -> Half<S> { friction.flow_along(mass, turn, inverse_levels, creep) })
}
