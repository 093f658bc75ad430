//! How fast a joint can change, and how many micro-steps that asks for.
//!
//! A step costs the same whatever the data, so it is divided once, when the joint is built, for the
//! worst that its parameters allow: the fastest vibration, the strongest damping, and the fastest
//! growth of a slip that the falling Stribeck curve feeds.

use crate::joint::MIDDLE;
use crate::params::{Load, Motor, Stage};
use crate::per_unit::{Bases, reflected_inertia};

/// Most micro-steps one step is divided into.
pub const MAX_MICRO_STEPS: u32 = 64;

/// Largest turn of the fastest mode in a micro-step, rad: there the splitting's frequency error is
/// below 0.1 %.
const LARGEST_PHASE: f64 = 1.2;
/// Largest growth of slip in a micro-step, as the logarithm of a speed: with this and the phase, nine
/// of ten random plants stay within 1 %.
const LARGEST_GROWTH: f64 = 0.75;
/// Steepest slope of exp(−x²).
const STEEPEST: f64 = 0.857_763_884_960_706_8;

/// The rates that bound a micro-step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pace {
    /// Bound for the fastest mode of the chain, rad/s, with every spring at its tangent under twice
    /// the breakaway torque and every bristle stuck.
    pub mode_rad_per_s: f64,
    /// Strongest damping of a mass, 1/s, as a bristle that bends doubles it: (2σ1 + σ2)/J.
    pub damping_per_s: f64,
    /// Fastest growth of a mass's slip where the Stribeck curve falls steepest, 1/s; zero where
    /// viscous friction outweighs it.
    pub growth_per_s: f64,
}

impl Pace {
    /// Of a joint.
    pub fn of(motor: &Motor, stages: &[Stage], load: &Load) -> Self {
        let bases = Bases::si(motor, stages);
        let breakaway: f64 = (0..=stages.len()).map(|mass| bases.breakaway(mass)).sum();
        let inertia = |mass| reflected_inertia(motor, stages, load, mass);
        let spring = |mass: usize| {
            mass.checked_sub(1).and_then(|k| stages.get(k)).map_or(0.0, |stage| {
                let shaft = bases.shaft(mass);
                tangent(stage, 2.0 * breakaway / libm::fabs(shaft)) * shaft * shaft
            })
        };
        // Gershgorin's rows of M^-1 (K + diag σ0) with the couplings symmetrised bound the mode.
        let mut fastest: f64 = 0.0;
        let mut pace = Self::default();
        for mass in 0..=stages.len() {
            let friction = bases.friction(mass);
            let square = bases.shaft(mass) * bases.shaft(mass);
            let (own, before, after) = (inertia(mass), spring(mass), spring(mass + 1));
            let mut row = (friction.sigma0_nm_per_rad * square + before + after) / own;
            if mass > 0 {
                row += before / libm::sqrt(own * inertia(mass - 1));
            }
            if mass < stages.len() {
                row += after / libm::sqrt(own * inertia(mass + 1));
            }
            fastest = fastest.max(row);
            let loss = 2.0 * friction.sigma1_nm_s_per_rad + friction.sigma2_nm_s_per_rad;
            pace.damping_per_s = pace.damping_per_s.max(loss * square / own);
            let falling = STEEPEST * friction.stribeck_nm / friction.stribeck_velocity_rad_per_s;
            let gained = (falling - friction.sigma2_nm_s_per_rad) * square / own;
            pace.growth_per_s = pace.growth_per_s.max(gained);
        }
        pace.mode_rad_per_s = libm::sqrt(fastest);
        pace
    }

    /// Micro-steps that a step of `step_s` seconds is to be divided into: the fastest mode turns by
    /// at most 1.2 rad in one, no mass loses more than half its speed to damping in the middle
    /// kick, and slip grows by at most e^¾.
    pub fn micro_steps(&self, step_s: f64) -> u32 {
        let by_mode = self.mode_rad_per_s / LARGEST_PHASE;
        let by_damping = self.damping_per_s * MIDDLE;
        let by_growth = self.growth_per_s / LARGEST_GROWTH;
        let wanted = libm::ceil(step_s * by_mode.max(by_damping).max(by_growth));
        wanted.clamp(1.0, f64::from(MAX_MICRO_STEPS)) as u32
    }
}

/// How many micro-steps a step of `step_s` seconds needs: [`Pace::micro_steps`].
pub fn micro_steps(motor: &Motor, stages: &[Stage], load: &Load, step_s: f64) -> u32 {
    Pace::of(motor, stages, load).micro_steps(step_s)
}

/// Tangent stiffness of a stage's spring under a torque, Nm/rad.
fn tangent(stage: &Stage, torque: f64) -> f64 {
    let x = deflection(stage, torque);
    stage.stiffness_nm_per_rad + 3.0 * stage.cubic_stiffness_nm_per_rad3 * x * x
}

/// Deflection of a stage's spring under a torque, rad at its output.
pub(crate) fn deflection(stage: &Stage, torque: f64) -> f64 {
    let (k1, k3) = (stage.stiffness_nm_per_rad, stage.cubic_stiffness_nm_per_rad3);
    let mut x = torque / k1;
    for _ in 0..20 {
        x -= (k1 * x + k3 * x * x * x - torque) / (k1 + 3.0 * k3 * x * x);
    }
    x
}
