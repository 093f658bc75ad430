//! The forces on every mass, and how they change with the angles.

use super::constants::Joint;
use crate::angle::Angle;
use crate::effect::{Effects, Felt, Memory, Motion};
use crate::friction::Friction;
use crate::scalar::Scalar;
use crate::state::{Mass, State};

/// How the forces change with the angles, at the middle of a micro-step.
pub(super) struct Gradient<S, const N: usize> {
    /// Minus the slope of torque effects, on the rotor and each mass.
    rotor: S,
    masses: [S; N],
    /// Tangent stiffness of each spring.
    springs: [S; N],
    /// One where the spring is in contact, for its damper.
    contact: [S; N],
}

impl<S: Scalar, const N: usize, E: Effects<S>> Joint<S, N, E> {
    /// What a stage's spring feels.
    #[inline(always)]
    pub(super) fn felt(&self, stage: usize, deflection: S, input: Angle<S>) -> Felt<S> {
        if self.effects.has_stage(stage) {
            self.effects.stage(stage, deflection, input)
        } else {
            Felt { deflection, contact: S::ONE, leverage: S::ONE }
        }
    }

    /// Damping of a mass, with what effects make of it.
    #[inline(always)]
    fn damping(
        &self,
        friction: &Friction<S>,
        number: usize,
        mass: &Mass<S>,
        memory: &Memory<S>,
    ) -> S {
        if self.effects.has_damping(number) {
            let viscous = self.effects.viscous(number, mass.speed, memory);
            friction.damping_with(&mass.bristle, viscous) + self.effects.drag(number, mass.speed)
        } else {
            friction.damping(&mass.bristle)
        }
    }

    /// Forces and damping of every mass, but for the load and the motor; and how they change.
    #[inline(always)]
    pub(super) fn forces(&self, state: &mut State<S, N>, angle: Angle<S>) -> Gradient<S, N> {
        let mut gradient = Gradient {
            rotor: S::ZERO,
            masses: [S::ZERO; N],
            springs: [S::ZERO; N],
            contact: [S::ONE; N],
        };
        let rotor = &mut state.rotor;
        let memory = &state.memory;
        rotor.damping = self.damping(&self.rotor, 0, rotor, memory);
        if self.effects.has_torque(0) {
            let at = Motion { angle, speed: rotor.speed };
            let torque = self.effects.torque(0, at, memory);
            rotor.force = rotor.force + torque.value;
            gradient.rotor = -torque.slope;
        }

        let mut wound = S::ZERO;
        let mut number = 0;
        let mut input = angle;
        let mut before = &mut rotor.force;
        let slopes = gradient.springs.iter_mut().zip(&mut gradient.contact);
        let rows = slopes.zip(&mut gradient.masses);
        for (((stage, own), stage_number), ((slope, contact), mass_slope)) in
            state.stages.iter_mut().zip(&self.stages).zip(0..N).zip(rows)
        {
            number += 1;
            let felt = self.felt(stage_number, stage.deflection, input);
            let mut torque = own.spring.torque(felt.deflection);
            *slope = own.spring.slope(felt.deflection) * felt.contact;
            if self.effects.has_stage(stage_number) {
                let beside = self.effects.stage_torque(stage_number, felt.deflection, memory);
                torque = torque + beside.value;
                *slope = *slope + beside.slope;
            }
            *contact = felt.contact;
            *before = *before - torque * felt.leverage;
            let mass = &mut stage.mass;
            mass.force = mass.force + torque;
            mass.damping = self.damping(&own.friction, number, mass, memory);
            wound = wound + stage.deflection;
            // The next stage's laws ask for this mass's angle too.
            if self.effects.has_torque(number) || self.effects.has_stage(number) {
                let motor = angle.ahead(-wound.times(self.turns));
                if self.effects.has_stage(number) {
                    input = own.own_angle(motor);
                }
                if self.effects.has_torque(number) {
                    let at = Motion { angle: motor, speed: mass.speed };
                    let torque = self.effects.torque(number, at, memory);
                    mass.force = mass.force + torque.value;
                    *mass_slope = -torque.slope;
                }
            }
            before = &mut mass.force;
        }
        gradient
    }

    /// Adds the force gradient `h²/24 · ∂f/∂q · M⁻¹ f` to the forces of the middle kick.
    #[inline(always)]
    pub(super) fn correct(&self, state: &mut State<S, N>, gradient: &Gradient<S, N>) {
        let motor = state.current;
        let whole = state.rotor.force + motor;
        let moved = whole.times(self.rotor_gamma);
        state.rotor.force = state.rotor.force - self.rotor.shift(&state.rotor.bristle, whole);
        if self.effects.has_torque(0) {
            state.rotor.force = state.rotor.force - gradient.rotor * moved;
        }
        let mut before = (&mut state.rotor.force, moved);
        let slopes = gradient.springs.iter().zip(&gradient.masses);
        for (((stage, own), number), (spring, mass_slope)) in
            state.stages.iter_mut().zip(&self.stages).zip(1..=N).zip(slopes)
        {
            let shift = |loaded| own.friction.shift(&stage.mass.bristle, loaded);
            let force = &mut stage.mass.force;
            let moved = force.times(own.gamma);
            let exchanged = *spring * (before.1 - moved);
            *before.0 = *before.0 - exchanged;
            *force = *force - shift(*force) + exchanged;
            if self.effects.has_torque(number) {
                *force = *force - *mass_slope * moved;
            }
            before = (force, moved);
        }
    }

    /// Lets the springs' dampers act for half a micro-step, from the motor on.
    #[inline(always)]
    pub(super) fn damp(&self, state: &mut State<S, N>, gradient: &Gradient<S, N>) {
        let mut before = &mut state.rotor.speed;
        for ((stage, own), contact) in
            state.stages.iter_mut().zip(&self.stages).zip(&gradient.contact)
        {
            own.spring.damp(before, &mut stage.mass.speed, *contact);
            before = &mut stage.mass.speed;
        }
    }

    /// The same from the output back: neighbouring dampers do not commute, and only both orders
    /// together leave no error of first order.
    #[inline(always)]
    pub(super) fn damp_back(&self, state: &mut State<S, N>, gradient: &Gradient<S, N>) {
        let rows = self.stages.iter().zip(&gradient.contact).rev();
        let mut stages = state.stages.as_mut_slice();
        for (own, contact) in rows {
            let Some((after, others)) = stages.split_last_mut() else { return };
            let before = match others.last_mut() {
                Some(stage) => &mut stage.mass.speed,
                None => &mut state.rotor.speed,
            };
            own.spring.damp(before, &mut after.mass.speed, *contact);
            stages = others;
        }
    }
}
