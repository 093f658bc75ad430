//! The step: a forward fourth-order splitting with closed flows for what is stiff.
//!
//! Chin's 4A: kick ⅙, drift ½, kick ⅔ with a force gradient, drift ½, kick ⅙ (Chin, "Symplectic
//! integrators from composite operator factorizations", 1997). The chain itself is not stiff at a
//! drive's step; what is, the bristles and the current, are scalars carried by their own closed
//! flows ([`crate::friction`], [`crate::motor`]). Implicit schemes would damp and shift the chain's
//! fastest mode; this keeps its frequency to 0.2 % at 1.6 rad a micro-step. Every micro-step of a
//! joint without effects does the same operations whatever the data.

use crate::angle::Angle;
use crate::effect::{Effects, Felt, Flow, MEMORIES, Memory, Motion, Relaxation, Winding};
use crate::friction::{Friction, Half, Turn};
use crate::joint::{IMPLICIT, Input, Joint, Mass, StageState, State};
use crate::scalar::Scalar;
use crate::work::{MicroStep, Refresh, Remember};

/// Most masses that what effects remember may follow.
const MOST_MASSES: usize = 9;

/// How the forces change with the angles, at the middle of a micro-step.
struct Gradient<S, const N: usize> {
    /// Minus the slope of torque effects, on the rotor and each mass.
    rotor: S,
    masses: [S; N],
    /// Tangent stiffness of each spring.
    springs: [S; N],
    /// One where the spring is in contact, for its damper.
    contact: [S; N],
}

/// One of something for every mass.
pub(crate) struct Each<T, const N: usize> {
    pub(crate) rotor: T,
    pub(crate) masses: [T; N],
}

impl<S: Scalar, const N: usize> Each<S, N> {
    #[inline(always)]
    fn of(state: &State<S, N>, of: impl Fn(&Mass<S>) -> S) -> Self {
        let mut masses = [S::ZERO; N];
        for (value, stage) in masses.iter_mut().zip(&state.stages) {
            *value = of(&stage.mass);
        }
        Self { rotor: of(&state.rotor), masses }
    }
}

/// The mass that carries the load.
#[inline(always)]
fn last<S: Scalar, const N: usize>(state: &mut State<S, N>) -> &mut Mass<S> {
    match state.stages.last_mut() {
        Some(stage) => &mut stage.mass,
        None => &mut state.rotor,
    }
}

/// What the kick made of one stage's speed.
#[inline(always)]
pub(crate) fn turn_of<S: Scalar, const N: usize>(
    friction: &Friction<S>,
    mass: &mut Mass<S>,
    first: Option<(&Each<S, N>, &Each<Half<S>, N>)>,
    k: usize,
) -> Option<Turn<S>> {
    let (speeds, halves) = first?;
    Some(friction.turn(mass, *speeds.masses.get(k)?, *halves.masses.get(k)?))
}

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
        S::widely(MicroStep { joint: self, state, input });
    }

    #[inline(always)]
    pub(crate) fn micro_step_here(&self, state: &mut State<S, N>, input: Input<S>) {
        self.load(state, input);
        let began = Each::of(state, |mass| mass.force);
        self.kick::<0>(state, input, state.angle, &began);
        let first = Each::of(state, |mass| mass.speed);
        let ahead = state.angle.ahead(first.rotor.times(self.half_turn));
        let halves = self.half_drift(state, state.angle, None);
        let gradient = self.forces(state, ahead);
        self.load(state, input);
        self.correct(state, &gradient);
        if self.damped {
            self.damp(state, &gradient);
        }
        self.kick::<1>(state, input, ahead, &began);
        if self.damped {
            self.damp_back(state, &gradient);
        }
        self.half_drift(state, ahead, Some((&first, &halves)));
        state.angle.turn(first.rotor + state.rotor.speed, self.half_turn);
        self.forces(state, state.angle);
        // The load may change before the next micro-step.
        let kept = last(state).force;
        self.load(state, input);
        self.kick::<2>(state, input, state.angle, &began);
        last(state).force = kept;
    }

    /// Lets the load act on the last mass.
    #[inline(always)]
    fn load(&self, state: &mut State<S, N>, input: Input<S>) {
        let mass = last(state);
        mass.force = mass.force - input.load;
    }

    /// Computes what the state caches: after a speed, an angle, a deflection or a bristle was set
    /// from outside.
    #[inline(never)]
    pub fn refresh(&self, state: &mut State<S, N>) {
        S::widely(Refresh { joint: self, state });
    }

    #[inline(always)]
    pub(crate) fn refresh_here(&self, state: &mut State<S, N>) {
        let (rotor, stages) = self.levels(state, state.angle);
        self.rotor.settle(&mut state.rotor, rotor);
        for ((stage, own), level) in state.stages.iter_mut().zip(&self.stages).zip(stages) {
            own.friction.settle(&mut stage.mass, level);
        }
        self.forces(state, state.angle);
    }

    /// Deflections and bristles over half a micro-step at constant speed; in the second half with what
    /// the kick between did to the first one's speeds. Answers with what the second asks of the first.
    #[inline(always)]
    fn half_drift(
        &self,
        state: &mut State<S, N>,
        from: Angle<S>,
        first: Option<(&Each<S, N>, &Each<Half<S>, N>)>,
    ) -> Each<Half<S>, N> {
        if self.effects.has_memory() {
            self.remember(state);
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
    pub(crate) fn wind(&self, stage: &mut StageState<S>, relative: S) {
        let (wound, lost) = stage.deflection.drifted(stage.lost, relative, self.half_drift);
        stage.deflection = wound;
        stage.lost = lost;
    }

    /// What effects remember, over half a micro-step at constant speed and current.
    #[inline(never)]
    pub(crate) fn remember(&self, state: &mut State<S, N>) {
        S::widely(Remember { joint: self, state });
    }

    #[inline(always)]
    pub(crate) fn remember_here(&self, state: &mut State<S, N>) {
        let mut speeds = [S::ZERO; MOST_MASSES];
        let masses = core::iter::once(&state.rotor).chain(state.stages.iter().map(|s| &s.mass));
        for (speed, mass) in speeds.iter_mut().zip(masses) {
            *speed = mass.speed;
        }
        let flow = Flow { current: state.current, speeds: &speeds };
        let mut all = [None; MEMORIES];
        self.effects.relax(&flow, &mut all);
        for (value, relaxation) in state.memory.iter_mut().zip(all) {
            if let Some(Relaxation { reach, target }) = relaxation {
                *value = target + (*value - target) * reach.exp_minus();
            }
        }
    }

    /// What a stage's spring feels.
    #[inline(always)]
    pub(crate) fn felt(&self, stage: usize, deflection: S, input: Angle<S>) -> Felt<S> {
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
    fn forces(&self, state: &mut State<S, N>, angle: Angle<S>) -> Gradient<S, N> {
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
            let at = Motion { angle, turns: self.whole_turn.wide(angle), speed: rotor.speed };
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
                input = own.own_angle(motor);
                if self.effects.has_torque(number) {
                    let turns = own.shaft.wide(motor);
                    let at = Motion { angle: input, turns, speed: mass.speed };
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
    fn correct(&self, state: &mut State<S, N>, gradient: &Gradient<S, N>) {
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
    fn damp(&self, state: &mut State<S, N>, gradient: &Gradient<S, N>) {
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
    fn damp_back(&self, state: &mut State<S, N>, gradient: &Gradient<S, N>) {
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

    /// Speeds and current over one kick: `WHICH` is 0 for the first, 1 for the middle one, 2 for the
    /// last, each at the angle where its forces are.
    #[inline(always)]
    fn kick<const WHICH: usize>(
        &self,
        state: &mut State<S, N>,
        input: Input<S>,
        angle: Angle<S>,
        began: &Each<S, N>,
    ) {
        let kick = if WHICH == 1 { &self.middle } else { &self.outer };
        let rotor = &mut state.rotor;
        let mut force = rotor.force;
        let mut drive = input.drive;
        let mut lagging = S::ZERO;
        if self.effects.has_constants() {
            // The winding follows an EMF that changes over the kick as it follows a speed that does.
            let turned = rotor.speed.times(self.kick_turn);
            let [from, to] = match WHICH {
                0 => [angle, angle.ahead(turned)],
                1 => [angle.ahead(-(turned + turned)), angle.ahead(turned + turned)],
                _ => [angle.ahead(-turned), angle],
            };
            let mean = kick.mean_current(rotor.speed, state.current, drive);
            let [from, to] = [from, to].map(|at| self.effects.constants(at, mean));
            let emf = [from.back_emf * rotor.speed, to.back_emf * rotor.speed];
            let extra = kick.followed(emf);
            let share = (from.torque + to.torque) * S::HALF;
            force = force + share * (mean + extra.mean) + extra.mean;
            lagging = extra.end;
        }
        let (speed, current, damping) = (rotor.speed, state.current, rotor.damping);
        if self.effects.has_drops() && !self.current_imposed {
            let (_, current) = kick.apply::<WHICH>(speed, current, force, damping, drive);
            let at = Winding {
                current: current + lagging,
                per_drop: kick.approach(),
                drive: input.drive,
            };
            drive = drive - self.effects.voltage_drop(at, &state.memory);
        }
        let (speed, current) = kick.apply::<WHICH>(speed, current, force, damping, drive);
        rotor.speed = speed;
        state.current = if self.effects.has_constants() { current + lagging } else { current };
        let stages = state.stages.iter_mut().zip(&self.stages).zip(&began.masses);
        for ((stage, own), began) in stages {
            let mass = &mut stage.mass;
            let [outer, middle] = own.mobility;
            let mobility = if WHICH == 1 { middle } else { outer };
            let lost = mass.damping.times(mobility);
            let rises = WHICH == 1 && S::RISES;
            let risen = if rises { rise(mass.force - *began, lost) } else { S::ZERO };
            let force = if rises { mass.force + risen } else { mass.force };
            // Together to the nearest: a damping rounded on its own would leave small swings alone.
            let gained = (force - mass.damping.nearest(mass.speed)).times_nearest(mobility);
            mass.speed = match WHICH {
                1 => mass.speed.kicked::<true>(gained, lost),
                _ => mass.speed.kicked::<false>(gained, lost),
            };
        }
    }
}

/// What the middle kick's damping makes of a force that rises through the step, `lost` being the
/// share of the speed that it takes: the part −(ḟ ∂a/∂v) h²/48 of the splitting's double commutator, ḟ
/// as the rise from the step's start to its middle.
#[inline(always)]
fn rise<S: Scalar>(risen: S, lost: S) -> S {
    lost.half().eighth().nearest(risen)
}
