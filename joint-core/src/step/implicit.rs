//! The second method: linearly implicit, for chains too stiff to be divided.
//!
//! A gear of 10⁷ Nm/rad between light masses swings a million times a second. The splitting of
//! [`crate::step`] would have to follow every swing; nothing of it is to be seen in a drive. This
//! method damps it away: SDIRK2 (Alexander 1977), two stages of implicit Euler with γ = 1 − 1/√2 and
//! an extrapolation between them, of second order and L-stable. Bristles and current are eliminated
//! in closed form from every stage, so that Newton's iteration, of which one is enough, is on the
//! speeds alone, whose matrix is tridiagonal. It takes the same number of operations whatever the
//! data.
//!
//! What it damps away is missing where friction sets such a swing off: as long as the splitting is
//! stable, it is the better one, and [`crate::pace`] chooses it.

use super::constants::{Joint, STAGE};
use super::kick::OUTER;
use super::levels::changed;
use crate::angle::Angle;
use crate::effect::{Effects, Motion, Winding};
use crate::friction::{Changed, Friction};
use crate::scalar::Scalar;
use crate::state::{Input, Mass, State};
use crate::work::widely;

/// Whether this build has the implicit method.
pub const IMPLICIT: bool = cfg!(feature = "implicit");

/// (1 − γ)/γ: how far the second stage starts along the first one's change.
const BEYOND: f64 = 1.0 + core::f64::consts::SQRT_2;
/// Least pivot: the falling Stribeck curve may turn a mass's own negative.
const LEAST_PIVOT: f64 = 0.25;

/// One mass in Newton's equations, and what its friction does.
#[derive(Clone, Copy, Default)]
struct Row<S> {
    mobility: S,
    /// Speed that the mass is short of.
    missing: S,
    /// Torque per speed that holds it against the ground.
    held: S,
    /// The same of the spring before it.
    spring: S,
    /// Change of its bristle in the stage.
    bent: S,
    pivot: S,
}

/// A mass's friction at the end of a stage.
struct Rubbed<S> {
    torque: S,
    /// Torque per speed, the bristle following.
    slope: S,
    /// Change of ζ.
    bent: S,
}

impl<S: Scalar> Friction<S> {
    /// ζ after a stage of implicit Euler from `zeta`, `(ζ + y)/(1 + |y| ρ)` with the slip y at the
    /// stage's own speed, and the torque there.
    #[inline(always)]
    fn implicit(&self, speed: S, zeta: S, changed: Changed<S>) -> Rubbed<S> {
        let curve = self.curve(speed);
        let Changed { inverse_level, creep } = changed;
        let rho = curve.rho * inverse_level;
        let per_speed = S::from_f64(2.0 * STAGE) * S::PER_REACH;
        let slip = speed.times(self.kappa) * per_speed;
        let (mut rate, mut slipped, mut slope) = (speed.abs(), slip.abs() * rho, curve.slope());
        if let Some(creep) = creep {
            let (faster, bend) = creep.rate(speed);
            (rate, slipped) = (faster, faster.times(self.kappa) * per_speed * rho);
            slope = slope - curve.rho * (S::ONE - bend);
        }
        let kept = S::ONE.over(S::ONE + slipped);
        let bent = (slip - slipped * zeta) * kept;
        let zeta = zeta + bent;
        let bending = S::ONE - zeta.along(speed) * (slope * inverse_level);
        Rubbed {
            torque: self.level * zeta + self.sigma1 * (speed - rate * rho * zeta),
            slope: (self.level.times(self.kappa) * per_speed + self.sigma1) * bending * kept,
            bent,
        }
    }
}

/// [`Friction::implicit`] of a mass whose friction effects change, by its number, as a function of its own.
#[inline(never)]
fn implicitly<S: Scalar, E: Effects<S>>(
    at: (&E, usize),
    friction: &Friction<S>,
    [speed, zeta, inverse_level]: [S; 3],
) -> Rubbed<S> {
    let changed = changed(at, inverse_level);
    widely!(<S>(
        friction: &'a Friction<S> = friction,
        speed: S = speed,
        zeta: S = zeta,
        changed: Changed<S> = changed,
    ) -> Rubbed<S> { friction.implicit(speed, zeta, changed) })
}

impl<S: Scalar, const N: usize, E: Effects<S>> Joint<S, N, E> {
    /// [`Joint::step`] by this method.
    #[inline(never)]
    pub(super) fn step_implicitly(&self, state: &mut State<S, N>, input: Input<S>) {
        for _ in 0..self.implicit.micro_steps.max(1) {
            self.implicit_micro_step(state, input);
        }
        // What the splitting caches: the next step may be another joint's.
        self.refresh(state);
    }

    #[inline(never)]
    fn implicit_micro_step(&self, state: &mut State<S, N>, input: Input<S>) {
        if self.effects.has_memory() {
            self.remember(state, input);
        }
        let began = *state;
        let bent = self.stage(&began, state, input);
        let start = beyond(&began, state, self.half_turn);
        let first = state.rotor.speed;
        let bent = bent * S::from_f64(BEYOND) + self.stage(&start, state, input);
        let (zeta, lost) = began.rotor.bristle.zeta.plus(bent, began.rotor.bristle.lost);
        state.rotor.bristle.zeta = zeta;
        state.rotor.bristle.lost = lost;
        let (early, late) = (S::from_f64(2.0 - 2.0 * STAGE), S::from_f64(2.0 * STAGE));
        state.angle = began.angle;
        state.angle.turn(first * early + state.rotor.speed * late, self.half_turn);
        if self.effects.has_memory() {
            self.remember(state, input);
        }
    }

    /// One stage of implicit Euler from `from`, with the speeds of `state` to begin with. Answers with
    /// what it bent the rotor's bristle by.
    #[inline(always)]
    fn stage(&self, from: &State<S, N>, state: &mut State<S, N>, input: Input<S>) -> S {
        // One is enough, but where a tooth may meet its flank within the stage.
        let iterations = if self.effects.has_stages() { 2 } else { 1 };
        for _ in 0..iterations {
            let (mut rotor, mut rows) = self.rows(from, state, input);
            improve(&mut rotor, &mut rows, state);
        }
        self.rows(from, state, input).0.bent
    }

    /// Everything at the end of the stage that ends at the speeds of `state`, and by how much those
    /// miss.
    #[inline(never)]
    fn rows(
        &self,
        from: &State<S, N>,
        state: &mut State<S, N>,
        input: Input<S>,
    ) -> (Row<S>, [Row<S>; N]) {
        let reach = S::from_f64(2.0 * STAGE);
        let angle = from.angle.ahead(state.rotor.speed.times(self.half_turn) * reach);
        let mut before = state.rotor.speed;
        for (stage, from) in state.stages.iter_mut().zip(&from.stages) {
            let after = stage.mass.speed;
            stage.deflection = from.deflection + (before - after).times(self.half_drift) * reach;
            before = after;
        }
        let (motor, motor_slope) = self.motor(from, state, angle, input.drive);
        let (level, levels) = if self.effects.has_levels() {
            self.levels(state, angle)
        } else {
            (S::ONE, [S::ONE; N])
        };
        let per_angle = S::ONE.times(self.half_drift) * reach;

        let mut rotor =
            self.row(&self.rotor, 0, (&from.rotor, &mut state.rotor), level, &state.memory);
        rotor.mobility = S::ONE.times(self.implicit.mobility);
        rotor.missing = rotor.missing + motor;
        rotor.held = rotor.held + motor_slope;
        if self.effects.has_torque(0) {
            let at = Motion { angle, speed: state.rotor.speed };
            let torque = self.effects.torque(0, at, &state.memory);
            rotor.missing = rotor.missing + torque.value;
            rotor.held = rotor.held - torque.slope * per_angle;
        }
        let mut rows = [Row::default(); N];
        let mobility = S::from_f64(STAGE / OUTER);
        let (mut wound, mut input_angle, mut number) = (S::ZERO, angle, 0);
        let mut ahead = (&mut rotor, state.rotor.speed);
        let stages = state.stages.iter_mut().zip(&from.stages).zip(&self.stages);
        for (((stage, from), own), (row, level)) in stages.zip(rows.iter_mut().zip(levels)) {
            let felt = self.felt(number, stage.deflection, input_angle);
            let mut elastic = own.spring.torque(felt.deflection);
            let mut slope = own.spring.slope(felt.deflection) * felt.contact;
            if self.effects.has_stage(number) {
                let beside = self.effects.stage_torque(number, felt.deflection, &state.memory);
                elastic = elastic + beside.value;
                slope = slope + beside.slope;
            }
            number += 1;
            *row = self.row(
                &own.friction,
                number,
                (&from.mass, &mut stage.mass),
                level,
                &state.memory,
            );
            row.spring = slope * per_angle;
            let mut damper = S::ZERO;
            if self.damped {
                damper = own.spring.damping_torque(ahead.1 - stage.mass.speed) * felt.contact;
                row.spring = row.spring + own.spring.damping_torque(S::ONE) * felt.contact;
            }
            ahead.0.missing = ahead.0.missing - elastic * felt.leverage - damper;
            row.missing = row.missing + elastic + damper;
            row.mobility = S::ONE.times(own.mobility[0]) * mobility;
            wound = wound + stage.deflection;
            if self.effects.has_torque(number) || self.effects.has_stages() {
                let motor = angle.ahead(-wound.times(self.turns));
                input_angle = own.own_angle(motor);
                let at = Motion { angle: motor, speed: stage.mass.speed };
                let torque = self.effects.torque(number, at, &state.memory);
                row.missing = row.missing + torque.value;
                row.held = row.held - torque.slope * per_angle;
            }
            ahead = (row, stage.mass.speed);
        }
        ahead.0.missing = ahead.0.missing - input.load;

        // Torques become speeds.
        let short = |row: &mut Row<S>, from: &Mass<S>, mass: &Mass<S>| {
            row.missing = row.missing * row.mobility - (mass.speed - from.speed);
        };
        short(&mut rotor, &from.rotor, &state.rotor);
        for ((row, from), stage) in rows.iter_mut().zip(&from.stages).zip(&state.stages) {
            short(row, &from.mass, &stage.mass);
        }
        (rotor, rows)
    }

    /// Friction and damping of one mass, whose bristle it moves.
    #[inline(always)]
    fn row(
        &self,
        friction: &Friction<S>,
        number: usize,
        (from, mass): (&Mass<S>, &mut Mass<S>),
        inverse_level: S,
        memory: &crate::effect::Memory<S>,
    ) -> Row<S> {
        let (speed, zeta) = (mass.speed, from.bristle.zeta);
        let rubbed = if self.effects.has_level(number) {
            implicitly((&self.effects, number), friction, [speed, zeta, inverse_level])
        } else {
            friction.implicit(speed, zeta, Changed { inverse_level: S::ONE, creep: None })
        };
        mass.bristle.zeta = from.bristle.zeta + rubbed.bent;
        let viscous = if self.effects.has_damping(number) {
            friction.sigma2 * self.effects.viscous(number, mass.speed, memory)
                + self.effects.drag(number, mass.speed)
        } else {
            friction.sigma2
        };
        Row {
            missing: -(rubbed.torque + viscous * mass.speed),
            held: rubbed.slope + viscous,
            bent: rubbed.bent,
            ..Row::default()
        }
    }

    /// Torque of the motor at the end of the stage, whose current it moves, and how it falls with the
    /// speed.
    #[inline(always)]
    fn motor(
        &self,
        from: &State<S, N>,
        state: &mut State<S, N>,
        angle: Angle<S>,
        drive: S,
    ) -> (S, S) {
        let followed = self.implicit.followed;
        let (mut torque, mut back_emf) = (S::ONE, S::ONE);
        if self.effects.has_constants() {
            let constants = self.effects.constants(angle, state.current);
            torque = torque + constants.torque;
            back_emf = back_emf + constants.back_emf;
        }
        let mut settled = drive - self.outer.induced_current(state.rotor.speed) * back_emf;
        let mut follows = back_emf;
        if self.effects.has_limit() && !self.current_imposed {
            let excess = self.effects.excess(settled);
            settled = settled - excess.value;
            follows = back_emf * (S::ONE - excess.slope);
        }
        let mut current = from.current + (settled - from.current) * followed;
        if self.effects.has_drops() && !self.current_imposed {
            let at = Winding { current, per_drop: followed, drive };
            current = current - self.effects.voltage_drop(at, &state.memory) * followed;
        }
        state.current = current;
        (current * torque, self.outer.induced_current(followed) * follows * torque)
    }
}

/// Newton's step: the tridiagonal equations from the output to the motor, and the speeds back.
#[inline(always)]
fn improve<S: Scalar, const N: usize>(
    rotor: &mut Row<S>,
    rows: &mut [Row<S>; N],
    state: &mut State<S, N>,
) {
    // What all behind a mass adds to its own: torque, and torque per speed.
    let (mut pushed, mut held) = (S::ZERO, S::ZERO);
    for row in rows.iter_mut().rev() {
        let free = own(row, pushed, held);
        let stiff = row.spring * row.mobility;
        row.pivot = S::ONE.over(free + stiff);
        let share = row.spring * row.pivot;
        pushed = share * row.missing;
        held = share * free;
    }
    let free = own(rotor, pushed, held);
    let mut gained = rotor.missing.over(free);
    state.rotor.speed = state.rotor.speed + gained;
    for (row, stage) in rows.iter().zip(&mut state.stages) {
        gained = (row.missing + row.spring * row.mobility * gained) * row.pivot;
        stage.mass.speed = stage.mass.speed + gained;
    }
}

/// A mass's pivot but for the spring before it.
#[inline(always)]
fn own<S: Scalar>(row: &mut Row<S>, pushed: S, held: S) -> S {
    row.missing = row.missing + row.mobility * pushed;
    let free = S::ONE + row.mobility * (row.held + held);
    let least = S::from_f64(LEAST_PIVOT);
    S::choose(least.below(free), free, least)
}

/// Where the second stage starts.
#[inline(always)]
fn beyond<S: Scalar, const N: usize>(
    began: &State<S, N>,
    first: &State<S, N>,
    half_turn: S::Gain,
) -> State<S, N> {
    let along = |from: S, to: S| from + (to - from) * S::from_f64(BEYOND);
    let turned = first.rotor.speed.times(half_turn) * S::from_f64(2.0 - 2.0 * STAGE);
    let mass = |began: &Mass<S>, first: &Mass<S>| {
        let mut mass = *began;
        mass.speed = along(began.speed, first.speed);
        mass.bristle.zeta = along(began.bristle.zeta, first.bristle.zeta);
        mass
    };
    let mut start = *began;
    start.angle = began.angle.ahead(turned);
    start.current = along(began.current, first.current);
    start.rotor = mass(&began.rotor, &first.rotor);
    for (start, first) in start.stages.iter_mut().zip(&first.stages) {
        start.deflection = along(start.deflection, first.deflection);
        start.mass = mass(&start.mass, &first.mass);
    }
    start
}
