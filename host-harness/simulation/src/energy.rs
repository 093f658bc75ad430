//! Where the energy goes: what is put in is heat, stored, or work on the load.
//!
//! The equations make no energy, and a method that integrates them may not either. The ledger takes a
//! state, says what power flows and what is stored in it, and knows nothing of how the state came about.
//! Of what lies beside the plain joint it counts the mesh of a worm and the coating, whose law it asks
//! in `joint-core`; other effects not.

use std::f64::consts::TAU;

use joint_core::angle::Angle;
use joint_core::effect::worm;
use joint_core::effect::{EffectSet, Effects, Kind, MEMORIES, Motion};
use joint_core::params::{Load, Stage};
use joint_core::per_unit::{Bases, reflected_inertia};

use crate::layout::{Layout, remembers};
use crate::model::Model;

/// Powers at one instant, W.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Powers {
    /// Heat in the winding, 2R i².
    pub winding: f64,
    /// Taken by the springs' dampers.
    pub dampers: f64,
    /// Taken by friction: heat, and what bends bristles.
    pub friction: f64,
    /// Put into the coating: stored in it, and heat of its loop.
    pub coating: f64,
    /// Put into the load per Nm of it.
    pub load_per_nm: f64,
}

/// Energy stored in a state, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stored {
    /// In the winding, L i².
    pub winding: f64,
    /// In the masses.
    pub kinetic: f64,
    /// In the springs.
    pub springs: f64,
    /// In the bristles.
    pub bristles: f64,
}

impl Stored {
    /// What the balance of the masses and springs holds; bristles are part of friction's work.
    pub fn outside_friction(&self) -> f64 {
        self.winding + self.kinetic + self.springs
    }
}

struct Mass {
    inertia: f64,
    shaft: f64,
    sigma0: f64,
    sigma1: f64,
    sigma2: f64,
    alpha0: f64,
    beta: f64,
    stribeck: f64,
    /// Where the mass is a worm: friction per torque passed on, driving and driven.
    mesh: Option<[f64; 2]>,
}

/// The coating of the output.
struct Coating {
    /// Its law alone.
    law: EffectSet<f64>,
    /// Its place among what effects remember.
    slot: usize,
}

/// The ledger of one joint.
pub struct Ledger {
    layout: Layout,
    resistance: f64,
    inductance: f64,
    masses: Vec<Mass>,
    /// Linear and cubic stiffness, damping; reflected.
    springs: Vec<[f64; 3]>,
    coating: Option<Coating>,
}

impl Ledger {
    /// Of a model, without its effects but the coating.
    pub fn new(model: &Model) -> Self {
        let Model { motor, stages, load, .. } = model;
        let bases = Bases::si(motor, stages);
        let frictions =
            std::iter::once(&motor.friction).chain(stages.iter().map(|stage| &stage.friction));
        let masses = frictions.enumerate().map(|(k, friction)| {
            let shaft = bases.shaft(k);
            let square = shaft * shaft;
            let alpha0 = friction.coulomb_nm * shaft.abs();
            Mass {
                inertia: reflected_inertia(motor, stages, load, k),
                shaft,
                sigma0: friction.sigma0_nm_per_rad * square,
                sigma1: friction.sigma1_nm_s_per_rad * square,
                sigma2: friction.sigma2_nm_s_per_rad * square,
                alpha0,
                beta: if alpha0 > 0.0 { friction.stribeck_nm / friction.coulomb_nm } else { 0.0 },
                stribeck: friction.stribeck_velocity_rad_per_s / shaft.abs(),
                mesh: stages.get(k).and_then(mesh),
            }
        });
        let springs = stages.iter().enumerate().map(|(k, stage)| {
            let square = bases.shaft(k + 1).powi(2);
            [
                stage.stiffness_nm_per_rad * square,
                stage.cubic_stiffness_nm_per_rad3 * square * square,
                stage.damping_nm_s_per_rad * square,
            ]
        });
        let remembering = model.effects.iter().filter(|effect| remembers(effect.kind));
        let coating = remembering.enumerate().find(|(_, effect)| effect.kind == Kind::Coating);
        let coating = coating.and_then(|(slot, effect)| {
            let law = EffectSet::new(std::slice::from_ref(effect), &Load::default(), &bases)?;
            Some(Coating { law, slot })
        });
        Self {
            coating,
            layout: Layout::of(model),
            resistance: bases.resistance,
            inductance: 2.0 * motor.phase_inductance_h,
            masses: masses.collect(),
            springs: springs.collect(),
        }
    }

    /// Powers in a state, as a plant has it.
    pub fn powers(&self, state: &[f64]) -> Powers {
        let current = state[Layout::CURRENT];
        let dampers = self.springs.iter().enumerate().map(|(k, [_, _, damping])| {
            let relative = state[self.layout.speed(k)] - state[self.layout.speed(k + 1)];
            damping * relative * relative
        });
        let friction = (0..self.masses.len()).map(|k| self.friction_of(k, state));
        let last = self.masses.len() - 1;
        Powers {
            winding: self.resistance * current * current,
            dampers: dampers.sum(),
            friction: friction.sum(),
            coating: self.coating_power(state),
            load_per_nm: self.masses[last].shaft * state[self.layout.speed(last)],
        }
    }

    /// Power that one mass's friction takes, W.
    pub fn friction_of(&self, mass: usize, state: &[f64]) -> f64 {
        let (speed, bristle) = (self.layout.speed(mass), self.layout.bristle(mass));
        let passed_on =
            if mass < self.springs.len() { self.stage_torque(mass, state) } else { 0.0 };
        self.masses[mass].friction(state[speed], state[bristle], passed_on)
    }

    /// Torque of a stage's spring and damper, seen from the motor, Nm; stages from 0.
    pub fn stage_torque(&self, stage: usize, state: &[f64]) -> f64 {
        let [linear, cubic, damping] = self.springs[stage];
        let deflection = state[self.layout.deflection(stage)];
        let [before, behind] = [stage, stage + 1].map(|mass| state[self.layout.speed(mass)]);
        deflection * (linear + cubic * deflection * deflection) + damping * (before - behind)
    }

    /// A state of the reference as the drive's step has it: bristle torques over the Coulomb level in
    /// place of bristle deflections.
    pub fn of_reference(&self, state: &[f64]) -> Vec<f64> {
        let mut own = state.to_vec();
        for (k, mass) in self.masses.iter().enumerate() {
            let scale = if mass.alpha0 > 0.0 { mass.sigma0 / mass.alpha0 } else { 0.0 };
            own[self.layout.bristle(k)] *= scale;
        }
        own
    }

    /// Power that the coating takes, W.
    fn coating_power(&self, state: &[f64]) -> f64 {
        let Some(Coating { law, slot }) = &self.coating else { return 0.0 };
        let last = self.masses.len() - 1;
        let windup: f64 = (0..last).map(|k| state[self.layout.deflection(k)]).sum();
        let turns = (state[Layout::ANGLE] - windup) / TAU;
        let speed = state[self.layout.speed(last)];
        let mut memory = [0.0; MEMORIES];
        // Alone in its set it has the first place there.
        memory[0] = state[self.layout.memory(*slot)];
        let at = Motion { angle: Angle::from_turns(turns), speed };
        -law.torque(last, at, &memory).value * speed
    }

    /// Energy in one mass's bristles, J.
    pub fn bristles_of(&self, mass: usize, state: &[f64]) -> f64 {
        self.masses[mass].bristles(state[self.layout.bristle(mass)])
    }

    /// Energy stored in a state.
    pub fn stored(&self, state: &[f64]) -> Stored {
        let current = state[Layout::CURRENT];
        let masses = || self.masses.iter().enumerate();
        let speed = |k: usize| state[self.layout.speed(k)];
        let springs = self.springs.iter().enumerate().map(|(k, [linear, cubic, _])| {
            let square = state[self.layout.deflection(k)].powi(2);
            square * (0.5 * linear + 0.25 * cubic * square)
        });
        Stored {
            winding: 0.5 * self.inductance * current * current,
            kinetic: masses().map(|(k, mass)| 0.5 * mass.inertia * speed(k) * speed(k)).sum(),
            springs: springs.sum(),
            bristles: masses().map(|(k, m)| m.bristles(state[self.layout.bristle(k)])).sum(),
        }
    }
}

impl Mass {
    /// `F v`, with F of (2) from the bristle torque over the Coulomb level and, for a worm, the torque
    /// that it passes on.
    fn friction(&self, speed: f64, zeta: f64, passed_on: f64) -> f64 {
        if self.alpha0 <= 0.0 {
            return (self.sigma1 + self.sigma2) * speed * speed;
        }
        let mesh = self.mesh.map_or(1.0, |[driving, driven]| {
            let share = if (speed < 0.0) == (passed_on < 0.0) { driving } else { driven };
            1.0 + share * passed_on.abs() / self.alpha0
        });
        let level = mesh * (1.0 + self.beta * (-(speed / self.stribeck).powi(2)).exp());
        let bending = 1.0 - speed.signum() * zeta / level;
        (self.alpha0 * zeta + (self.sigma1 * bending + self.sigma2) * speed) * speed
    }

    /// `½ σ0 z²`.
    fn bristles(&self, zeta: f64) -> f64 {
        if self.sigma0 > 0.0 { 0.5 * (self.alpha0 * zeta).powi(2) / self.sigma0 } else { 0.0 }
    }
}

/// Friction of a worm's mesh per torque that it passes on, driving and driven.
fn mesh(stage: &Stage) -> Option<[f64; 2]> {
    Some([1.0 / worm::efficiency(stage)? - 1.0, 1.0 - worm::back_efficiency(stage)?])
}
