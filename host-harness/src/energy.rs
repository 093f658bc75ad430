//! Where the energy goes: what is put in is heat, stored, or work on the load.
//!
//! The equations make no energy, and a method that integrates them may not either. The ledger takes a
//! state, says what power flows and what is stored in it, and knows nothing of how the state came about.
//! Effects are not counted.

use joint_core::per_unit::{Bases, reflected_inertia};

use crate::model::Model;
use crate::plant::Layout;

/// Powers at one instant, W.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Powers {
    /// Heat in the winding, 2R i².
    pub winding: f64,
    /// Taken by the springs' dampers.
    pub dampers: f64,
    /// Taken by friction: heat, and what bends bristles.
    pub friction: f64,
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
}

/// The ledger of one joint.
pub struct Ledger {
    layout: Layout,
    resistance: f64,
    inductance: f64,
    masses: Vec<Mass>,
    /// Linear and cubic stiffness, damping; reflected.
    springs: Vec<[f64; 3]>,
}

impl Ledger {
    /// Of a model, without its effects.
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
        Self {
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
        let friction = self.masses.iter().enumerate().map(|(k, mass)| {
            mass.friction(state[self.layout.speed(k)], state[self.layout.bristle(k)])
        });
        let last = self.masses.len() - 1;
        Powers {
            winding: self.resistance * current * current,
            dampers: dampers.sum(),
            friction: friction.sum(),
            load_per_nm: self.masses[last].shaft * state[self.layout.speed(last)],
        }
    }

    /// Power that one mass's friction takes, W.
    pub fn friction_of(&self, mass: usize, state: &[f64]) -> f64 {
        let (speed, bristle) = (self.layout.speed(mass), self.layout.bristle(mass));
        self.masses[mass].friction(state[speed], state[bristle])
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
    /// `F v`, with F of (2) from the bristle torque over the Coulomb level.
    fn friction(&self, speed: f64, zeta: f64) -> f64 {
        if self.alpha0 <= 0.0 {
            return (self.sigma1 + self.sigma2) * speed * speed;
        }
        let level = 1.0 + self.beta * (-(speed / self.stribeck).powi(2)).exp();
        let bending = 1.0 - speed.signum() * zeta / level;
        (self.alpha0 * zeta + (self.sigma1 * bending + self.sigma2) * speed) * speed
    }

    /// `½ σ0 z²`.
    fn bristles(&self, zeta: f64) -> f64 {
        if self.sigma0 > 0.0 { 0.5 * (self.alpha0 * zeta).powi(2) / self.sigma0 } else { 0.0 }
    }
}
