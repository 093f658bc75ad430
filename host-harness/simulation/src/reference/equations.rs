//! The joint's equations of motion, written out for the reference.
//!
//! What the step is judged by must not share its tricks. Here is the plain right-hand side in SI
//! with everything reflected to the motor shaft: no per-unit numbers, no closed flows, the exact
//! exponential of the Stribeck curve, any number of stages. Only the laws of added effects are
//! the ones the drive runs, because an effect's physics stands once.
//!
//! The state is `[i, θ, d…, v…, z…]`: current, rotor angle, deflections, speeds, bristles, all at
//! the motor, so an angle q of mass k is q/N_k and a torque on it T·N_k; then what effects remember, and
//! what a friction law has beside one bristle a mass. Deflections are states themselves: as
//! differences of angles they would drown in the turns.

use std::f64::consts::TAU;

use joint_core::angle::Angle;
use joint_core::effect::{
    Constants, EffectSet, Effects, Felt, Flow, MEMORIES, Memory, Motion, Relaxation, Rubbing,
};
use joint_core::joint::Drive;
use joint_core::params::Friction;
use joint_core::per_unit::{Bases, reflected_inertia};

use super::ReferenceError;
use super::friction::{Contact, Family, elastoplastic, limited_viscous, maxwell_slip, tanh};
use crate::acting::stepped;
use crate::model::Model;
use crate::plant::Layout;

/// From this power on the Stribeck exponential is below the last bit of what it is added to.
const FORGOTTEN: f64 = 45.0;

/// What acts on the joint over one sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Held {
    /// Voltage, V, or current, A.
    pub drive: f64,
    /// Load at the output, Nm, positive against positive motion.
    pub load: f64,
    /// Further torque on the rotor, Nm.
    pub torque: f64,
    /// Relative change of the level of all friction; zero leaves it as it is.
    pub friction_change: f64,
}

pub(super) struct Mass {
    pub(super) per_inertia: f64,
    pub(super) sigma0: f64,
    pub(super) sigma1: f64,
    pub(super) sigma2: f64,
    pub(super) alpha0: f64,
    pub(super) alpha1: f64,
    pub(super) per_stribeck_velocity: f64,
    /// Product of the ratios η up to this mass.
    pub(super) shaft: f64,
}

pub(super) struct Spring {
    pub(super) linear: f64,
    pub(super) cubic: f64,
    pub(super) damping: f64,
}

/// The equations of one joint.
pub struct Equations {
    pub(super) masses: Vec<Mass>,
    springs: Vec<Spring>,
    pub(super) torque_constant: f64,
    pub(super) resistance: f64,
    /// One over 2L; `None` where the current follows at once.
    pub(super) per_inductance: Option<f64>,
    pub(super) drive: Drive,
    stribeck_exponent: f64,
    /// Speed over Stribeck velocity from which the exponential is forgotten.
    forgotten: f64,
    pub(super) standing_rate: f64,
    pub(super) effects: Option<EffectSet<f64>>,
    memories: usize,
    pub(super) family: Family,
}

impl Equations {
    /// The equations of a model; `stribeck_exponent` is δ of `exp(−|v/v0|^δ)`, 2 in the model.
    ///
    /// # Errors
    /// The first parameter that the equations cannot take.
    pub fn new(
        model: &Model,
        drive: Drive,
        stribeck_exponent: f64,
    ) -> Result<Self, ReferenceError> {
        let Model { motor, stages, load, .. } = model;
        joint_core::params::validate(motor, stages, load)?;
        joint_core::effect::validate(&model.effects, stages.len())?;
        let bases = Bases::si(motor, stages);
        let resistance = bases.resistance;
        if drive == Drive::Voltage && resistance <= 0.0 {
            return Err(ReferenceError::NoResistance);
        }
        let effects = EffectSet::new(&stepped(&model.effects), load, &bases)
            .ok_or(ReferenceError::Effects)?;
        let inductance = 2.0 * motor.phase_inductance_h;
        let lags = drive == Drive::Voltage && inductance > 0.0;
        let mass = |number: usize, friction: &Friction| {
            let inertia = reflected_inertia(motor, stages, load, number);
            Mass::new(friction, bases.shaft(number), inertia)
        };
        let mut masses = vec![mass(0, &motor.friction)];
        masses.extend(stages.iter().enumerate().map(|(k, stage)| mass(k + 1, &stage.friction)));
        let springs = stages.iter().enumerate().map(|(k, stage)| {
            let square = bases.shaft(k + 1).powi(2);
            Spring {
                linear: stage.stiffness_nm_per_rad * square,
                cubic: stage.cubic_stiffness_nm_per_rad3 * square * square,
                damping: stage.damping_nm_s_per_rad * square,
            }
        });
        let springs: Vec<Spring> = springs.collect();
        let electric = if lags { resistance / inductance } else { 0.0 };
        Ok(Self {
            standing_rate: standing_rate(&masses, &springs, electric),
            masses,
            springs,
            torque_constant: motor.torque_constant_nm_per_a,
            resistance,
            per_inductance: lags.then(|| 1.0 / inductance),
            drive,
            stribeck_exponent,
            forgotten: FORGOTTEN.powf(1.0 / stribeck_exponent),
            effects: (!effects.is_empty()).then_some(effects),
            memories: Layout::of(model).memories,
            family: Family::LuGre,
        })
    }

    /// The same joint with friction of another family.
    #[must_use]
    pub fn with_friction(mut self, family: Family) -> Self {
        self.family = family;
        self
    }

    /// Where each quantity stands in the state.
    pub fn layout(&self) -> Layout {
        Layout { stages: self.springs.len(), memories: self.memories }
    }

    /// The joint at rest, relaxed, at angle zero.
    pub fn rest(&self) -> Vec<f64> {
        vec![0.0; self.layout().len() + self.masses.len() * self.family.slots()]
    }

    /// Where the further states of a mass's friction begin.
    fn further(&self, mass: usize) -> usize {
        self.layout().len() + mass * self.family.slots()
    }

    /// Ends a step, where friction has distinct states: whether one changed, so that the rates have
    /// to be taken anew. `rate` is the derivative at `state`.
    #[inline]
    pub(super) fn end_step(&self, state: &mut [f64], rate: &[f64]) -> bool {
        let Family::MaxwellSlip { elements, .. } = self.family else { return false };
        let layout = self.layout();
        let mut changed = false;
        for (k, mass) in self.masses.iter().enumerate() {
            let (speed, from) = (state[layout.speed(k)], self.further(k));
            let to = from + self.family.slots();
            let (own, level) = (&mut state[from..to], rate[to - 1]);
            changed |= maxwell_slip::change(elements, speed, level, own);
            if mass.sigma0 > 0.0 {
                let bristle = own[..elements].iter().sum::<f64>() / mass.sigma0;
                state[layout.bristle(k)] = bristle;
            }
        }
        changed
    }

    /// Time derivative of the state. Slices shorter than the state are a caller's mistake and
    /// leave the rest untouched.
    #[inline]
    pub fn derivative(&self, held: &Held, state: &[f64], rate: &mut [f64]) {
        let stages = self.springs.len();
        if state.len() < 4 + 3 * stages || rate.len() < state.len() {
            return;
        }
        let (head, tail) = state.split_at(2);
        let (deflections, tail) = tail.split_at(stages);
        let (speeds, tail) = tail.split_at(stages + 1);
        let (bristles, tail) = tail.split_at(stages + 1);
        let (remembered, further) = tail.split_at(self.memories.min(tail.len()));
        let (head_rate, tail) = rate.split_at_mut(2);
        let (deflection_rate, tail) = tail.split_at_mut(stages);
        let (speed_rate, tail) = tail.split_at_mut(stages + 1);
        let (bristle_rate, tail) = tail.split_at_mut(stages + 1);
        let (memory_rate, further_rate) = tail.split_at_mut(self.memories.min(tail.len()));
        let slots = self.family.slots();

        let mut memory = [0.0; MEMORIES];
        for (slot, value) in memory.iter_mut().zip(remembered) {
            *slot = *value;
        }
        let current = self.current(held, head[0], speeds[0], &memory);
        let constants = self.constants(head[1], current);
        head_rate[0] = self.current_rate(held, current, speeds[0], constants.back_emf, &memory);
        head_rate[1] = speeds[0];
        if let Some(effects) = &self.effects {
            let mut all = [None; MEMORIES];
            effects.relax(&Flow { current, drive: self.held_drive(held), speeds }, &mut all);
            for ((rate, value), relaxation) in memory_rate.iter_mut().zip(memory).zip(all) {
                if let Some(Relaxation { reach, target }) = relaxation {
                    *rate = reach * (target - value);
                }
            }
        }

        let motor = self.torque_constant * current * (1.0 + constants.torque);
        let mut driving = motor + held.torque;
        let mut transmitted = self.torque_constant * current;
        let mut angle = head[1];
        for (k, mass) in self.masses.iter().enumerate() {
            let speed = speeds[k];
            let motor = Angle::from_turns(angle / TAU);
            let mut at = Rubbing { speed, transmitted, passed_on: 0.0, angle: motor };
            let mut force = driving;
            if let Some(spring) = self.springs.get(k) {
                deflection_rate[k] = speed - speeds[k + 1];
                let (felt, beside) = match &self.effects {
                    Some(effects) => {
                        let own = Angle::from_turns(angle * mass.shaft / TAU);
                        let felt = effects.stage(k, deflections[k], own);
                        (felt, effects.stage_torque(k, felt.deflection, &memory).value)
                    }
                    None => {
                        let deflection = deflections[k];
                        (Felt { deflection, contact: 1.0, leverage: 1.0 }, 0.0)
                    }
                };
                let x = felt.deflection;
                let elastic = x * (spring.linear + spring.cubic * x * x) + beside;
                let damping = felt.contact * spring.damping * deflection_rate[k];
                driving = elastic + damping;
                force -= elastic * felt.leverage + damping;
                transmitted = driving;
                at.passed_on = driving;
            } else {
                force -= held.load * mass.shaft;
            }
            let states = k * slots..(k + 1) * slots;
            let bristle = Bristle {
                deflection: bristles[k],
                further: further.get(states.clone()).unwrap_or_default(),
                further_rate: further_rate.get_mut(states).unwrap_or_default(),
                level: 1.0 + held.friction_change,
            };
            let (friction, slip) = self.friction(k, mass, at, bristle, &memory);
            bristle_rate[k] = slip;
            force -= friction;
            if let Some(effects) = &self.effects {
                let at = Motion { angle: motor, speed };
                force += effects.torque(k, at, &memory).value - effects.drag(k, speed) * speed;
                angle -= deflections.get(k).copied().unwrap_or(0.0);
            }
            speed_rate[k] = force * mass.per_inertia;
        }
    }

    /// The input in units of current: a voltage as a share of 2R.
    fn held_drive(&self, held: &Held) -> f64 {
        match self.drive {
            Drive::Voltage => held.drive / self.resistance,
            Drive::Current => held.drive,
        }
    }

    /// By how much the motor constants differ at a rotor angle and a current.
    fn constants(&self, angle: f64, current: f64) -> Constants<f64> {
        match &self.effects {
            Some(effects) if effects.has_constants() => {
                effects.constants(Angle::from_turns(angle / TAU), current)
            }
            _ => Constants::NONE,
        }
    }

    /// Torque of a mass's friction, equation (2), and the rate of its bristle, equation (3).
    #[inline]
    fn friction(
        &self,
        number: usize,
        mass: &Mass,
        at: Rubbing<f64>,
        bristle: Bristle<'_>,
        memory: &Memory<f64>,
    ) -> (f64, f64) {
        let speed = at.speed;
        let (viscous, level) = match &self.effects {
            Some(effects) => {
                let viscous = mass.sigma2 * effects.viscous(number, speed, memory);
                (viscous, 1.0 / effects.inverse_level(number, at))
            }
            None => (mass.sigma2, 1.0),
        };
        if mass.sigma0 <= 0.0 {
            return ((mass.sigma1 + viscous) * speed, 0.0);
        }
        let slip_level = level * bristle.level * self.slip_level(mass, speed);
        let contact = Contact {
            speed,
            level: slip_level,
            sigma0: mass.sigma0,
            sigma1: mass.sigma1,
            stribeck_velocity: 1.0 / mass.per_stribeck_velocity,
        };
        match self.family {
            Family::LuGre | Family::LimitedViscous { .. } => {
                let deflection = bristle.deflection;
                let slip = match &self.effects {
                    Some(effects) => {
                        effects.creep(number).map_or(speed.abs(), |creep| creep.rate(speed).0)
                    }
                    None => speed.abs(),
                };
                let rate = speed - mass.sigma0 * slip * deflection / slip_level;
                let viscous = match self.family {
                    Family::LimitedViscous { limit } => {
                        limited_viscous::torque(viscous * speed, limit * mass.alpha0)
                    }
                    _ => viscous * speed,
                };
                (mass.sigma0 * deflection + mass.sigma1 * rate + viscous, rate)
            }
            Family::ElastoPlastic { breakaway } => {
                let deflection = bristle.deflection;
                let rate = elastoplastic::rate(&contact, deflection, breakaway);
                (mass.sigma0 * deflection + mass.sigma1 * rate + viscous * speed, rate)
            }
            Family::MaxwellSlip { elements, attraction } => {
                let Bristle { further, further_rate, .. } = bristle;
                let torque =
                    maxwell_slip::rate(&contact, elements, attraction, further, further_rate);
                (torque + viscous * speed, 0.0)
            }
            Family::Tanh { width } => (tanh::torque(&contact, width) + viscous * speed, 0.0),
        }
    }

    /// g(v) = α0 + α1 exp(−|v/v0|^δ), equation (3).
    #[inline]
    fn slip_level(&self, mass: &Mass, speed: f64) -> f64 {
        let relative = (speed * mass.per_stribeck_velocity).abs();
        if relative > self.forgotten {
            return mass.alpha0;
        }
        let power = if self.stribeck_exponent == 2.0 {
            relative * relative
        } else {
            relative.powf(self.stribeck_exponent)
        };
        mass.alpha0 + mass.alpha1 * (-power).exp()
    }

    /// Deflection of a mass's bristle at its Coulomb level, rad at the motor; zero without friction.
    pub fn bristle_reach(&self, mass: usize) -> f64 {
        self.masses
            .get(mass)
            .filter(|mass| mass.sigma0 > 0.0)
            .map_or(0.0, |mass| mass.alpha0 / mass.sigma0)
    }
}

/// What a mass's friction remembers, and by what factor its level differs.
struct Bristle<'a> {
    deflection: f64,
    further: &'a [f64],
    further_rate: &'a mut [f64],
    level: f64,
}

impl Mass {
    fn new(friction: &Friction, shaft: f64, inertia: f64) -> Self {
        let (size, square) = (shaft.abs(), shaft * shaft);
        Self {
            per_inertia: 1.0 / inertia,
            sigma0: friction.sigma0_nm_per_rad * square,
            sigma1: friction.sigma1_nm_s_per_rad * square,
            sigma2: friction.sigma2_nm_s_per_rad * square,
            alpha0: friction.coulomb_nm * size,
            alpha1: friction.stribeck_nm * size,
            per_stribeck_velocity: size / friction.stribeck_velocity_rad_per_s,
            shaft,
        }
    }

    /// Bristle torque over the Coulomb level.
    pub(super) fn zeta(&self, bristle: f64) -> f64 {
        if self.alpha0 > 0.0 { self.sigma0 * bristle / self.alpha0 } else { 0.0 }
    }
}

/// The fastest rate at standstill: of the current, of the chain's modes, and of damping.
fn standing_rate(masses: &[Mass], springs: &[Spring], electric: f64) -> f64 {
    masses.iter().enumerate().fold(electric, |fastest, (k, mass)| {
        let around = [k.checked_sub(1), Some(k)].into_iter().flatten();
        let (mut stiffness, mut damping) = (mass.sigma0, mass.sigma1 + mass.sigma2);
        for spring in around.filter_map(|spring| springs.get(spring)) {
            stiffness += 2.0 * spring.linear;
            damping += 2.0 * spring.damping;
        }
        fastest.max((stiffness * mass.per_inertia).sqrt()).max(damping * mass.per_inertia)
    })
}
