//! How fast a joint can change, and how many micro-steps that asks for.
//!
//! A step costs the same whatever the data, so it is divided once, when the joint is built, for the
//! worst that its parameters allow: the fastest vibration, the strongest damping, and the fastest
//! growth of a slip that the falling Stribeck curve feeds. Effects count where they stiffen a joint or
//! raise a friction level; play does neither.

use crate::effect::{EffectParameters, Kind, mass_at};
use crate::joint::MIDDLE;
use crate::params::{Load, Location, Motor, Stage};
use crate::per_unit::{Bases, reflected_inertia};

/// Most micro-steps one step is divided into.
pub const MAX_MICRO_STEPS: u32 = 64;

/// Turn of the fastest mode in a micro-step, rad, and growth of slip, as the logarithm of a speed,
/// that each alone may fill a micro-step: together they may by the root of their squares. Found on
/// random plants, where the error of those with as much of both is the largest.
const PHASE: f64 = 0.45;
const GROWTH: f64 = 4.0 / 3.0;
/// Largest growth of slip in a micro-step, whatever the mode.
const LARGEST_GROWTH: f64 = 1.0;
/// The same limits where a fit runs the model many times over and its own noise is larger.
const COARSE_PHASE: f64 = 1.2;
const COARSE_GROWTH: f64 = 0.75;
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
    /// Of a joint without effects.
    pub fn of(motor: &Motor, stages: &[Stage], load: &Load) -> Self {
        Self::with(motor, stages, load, &[])
    }

    /// Of a joint with effects.
    pub fn with(
        motor: &Motor,
        stages: &[Stage],
        load: &Load,
        effects: &[EffectParameters],
    ) -> Self {
        let added = Added { effects, stages: stages.len(), gravity_nm: load.gravity_nm };
        let bases = Bases::si(motor, stages);
        let breakaway: f64 =
            (0..=stages.len()).map(|mass| bases.breakaway(mass) * added.level(mass)).sum();
        let inertia = |mass| reflected_inertia(motor, stages, load, mass);
        let spring = |mass: usize| {
            mass.checked_sub(1).and_then(|k| stages.get(k)).map_or(0.0, |stage| {
                let shaft = bases.shaft(mass);
                let stiffer = Stage {
                    cubic_stiffness_nm_per_rad3: stage.cubic_stiffness_nm_per_rad3
                        + added.cubic(mass),
                    ..*stage
                };
                let own = tangent(&stiffer, 2.0 * breakaway / libm::fabs(shaft));
                let leverage = 1.0 + added.tooth_slope(mass) * libm::fabs(stage.reduction);
                (own + added.spring(mass)) * leverage * leverage * shaft * shaft
            })
        };
        // Gershgorin's rows of M^-1 (K + diag σ0) with the couplings symmetrised bound the mode.
        let mut fastest: f64 = 0.0;
        let mut pace = Self::default();
        for mass in 0..=stages.len() {
            let friction = bases.friction(mass);
            let square = bases.shaft(mass) * bases.shaft(mass);
            let (own, before, after) = (inertia(mass), spring(mass), spring(mass + 1));
            let held = friction.sigma0_nm_per_rad + added.ground(mass);
            let mut row = (held * square + before + after) / own;
            if mass > 0 {
                row += before / libm::sqrt(own * inertia(mass - 1));
            }
            if mass < stages.len() {
                row += after / libm::sqrt(own * inertia(mass + 1));
            }
            fastest = fastest.max(row);
            let loss = 2.0 * friction.sigma1_nm_s_per_rad + friction.sigma2_nm_s_per_rad;
            pace.damping_per_s = pace.damping_per_s.max(loss * square / own);
            let falling = STEEPEST * friction.stribeck_nm * added.level(mass)
                / friction.stribeck_velocity_rad_per_s;
            let gained = (falling - friction.sigma2_nm_s_per_rad) * square / own;
            pace.growth_per_s = pace.growth_per_s.max(gained);
        }
        pace.mode_rad_per_s = libm::sqrt(fastest);
        pace
    }

    /// Micro-steps that a step of `step_s` seconds is to be divided into: the fastest mode turns by
    /// at most 0.45 rad in one, less where slip grows as well; slip grows by at most e; and no mass
    /// loses more than half its speed to damping in the middle kick.
    pub fn micro_steps(&self, step_s: f64) -> u32 {
        let both = libm::hypot(self.mode_rad_per_s / PHASE, self.growth_per_s / GROWTH);
        self.whole(step_s * both.max(self.growth_per_s / LARGEST_GROWTH), step_s)
    }

    /// The fewest that keep the vibrations' phase to 0.2 %, for a fit that runs a model many times
    /// over: at most 1.2 rad, and e^¾ of growth.
    pub fn coarse_micro_steps(&self, step_s: f64) -> u32 {
        let by_mode = self.mode_rad_per_s / COARSE_PHASE;
        let by_growth = self.growth_per_s / COARSE_GROWTH;
        self.whole(step_s * by_mode.max(by_growth), step_s).min(self.micro_steps(step_s))
    }

    /// The next whole number, with what damping asks for.
    fn whole(&self, wanted: f64, step_s: f64) -> u32 {
        let wanted = libm::ceil(wanted.max(step_s * self.damping_per_s * MIDDLE));
        wanted.clamp(1.0, f64::from(MAX_MICRO_STEPS)) as u32
    }
}

/// How many micro-steps a step of `step_s` seconds needs without effects: [`Pace::micro_steps`].
pub fn micro_steps(motor: &Motor, stages: &[Stage], load: &Load, step_s: f64) -> u32 {
    Pace::of(motor, stages, load).micro_steps(step_s)
}

/// The most that effects add to a joint's stiffness and friction, each at its own side.
struct Added<'a> {
    effects: &'a [EffectParameters],
    stages: usize,
    gravity_nm: f64,
}

impl Added<'_> {
    /// Sum over the effects that sit at a mass; a spring's is the mass behind it.
    fn sum(&self, mass: usize, of: impl Fn(Kind, &dyn Fn(&str) -> f64) -> f64) -> f64 {
        let here = |effect: &&EffectParameters| mass_at(effect.location, self.stages) == Some(mass);
        let each = |effect: &EffectParameters| {
            of(effect.kind, &|key| libm::fabs(effect.get(key).unwrap_or(0.0)))
        };
        self.effects.iter().filter(here).map(each).sum()
    }

    /// Stiffness against the ground, Nm/rad: the slope of torques that follow the mass's angle.
    fn ground(&self, mass: usize) -> f64 {
        let link = if Some(mass) == mass_at(Location::Output, self.stages) {
            libm::fabs(self.gravity_nm)
        } else {
            0.0
        };
        let effects = self.sum(mass, |kind, value| match kind {
            Kind::Cogging => {
                value("order") * (value("amplitude_nm") + 2.0 * value("second_amplitude_nm"))
            }
            Kind::Gravity => value("amplitude_nm"),
            // The cubic at one radian.
            Kind::Coating => {
                value("stiffness_nm_per_rad")
                    + value("hysteresis_nm") / value("width_rad")
                    + 3.0 * value("cubic_stiffness_nm_per_rad3")
            }
            _ => 0.0,
        });
        link + effects
    }

    /// Stiffness beside the spring before a mass, Nm/rad.
    fn spring(&self, mass: usize) -> f64 {
        self.sum(mass, |kind, value| match kind {
            Kind::StructuralHysteresis => value("amplitude_nm") / value("width_rad"),
            _ => 0.0,
        })
    }

    /// Cubic stiffness beside that spring's, Nm/rad³.
    fn cubic(&self, mass: usize) -> f64 {
        self.sum(mass, |kind, value| match kind {
            Kind::HardeningStiffness => value("cubic_stiffness_nm_per_rad3"),
            _ => 0.0,
        })
    }

    /// Steepest change of that spring's deflection with its input's angle.
    fn tooth_slope(&self, mass: usize) -> f64 {
        self.sum(mass, |kind, value| match kind {
            Kind::TransmissionError => value("amplitude_rad") * value("order"),
            _ => 0.0,
        })
    }

    /// Largest factor on a mass's friction levels, apart from the load's.
    fn level(&self, mass: usize) -> f64 {
        1.0 + self.sum(mass, |kind, value| match kind {
            Kind::AsymmetricFriction => value("asymmetry"),
            Kind::PositionDependentFriction => value("relative_amplitude"),
            _ => 0.0,
        })
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::Friction;

    const MOTOR: Motor = Motor {
        phase_resistance_ohm: 4.0,
        phase_inductance_h: 1e-5,
        torque_constant_nm_per_a: 1e-3,
        phase_back_emf_constant_v_s_per_rad: None,
        pole_pairs: 1,
        rotor_inertia_kg_m2: 1e-9,
        friction: Friction {
            sigma0_nm_per_rad: 0.05,
            sigma1_nm_s_per_rad: 4e-7,
            sigma2_nm_s_per_rad: 1e-9,
            coulomb_nm: 9e-6,
            stribeck_nm: 4e-6,
            stribeck_velocity_rad_per_s: 20.0,
        },
    };

    fn pace(effects: &[EffectParameters]) -> Pace {
        let stage = Stage {
            reduction: 10.0,
            inertia_kg_m2: 1e-7,
            stiffness_nm_per_rad: 1.0,
            ..Stage::default()
        };
        Pace::with(&MOTOR, &[stage], &Load::default(), effects)
    }

    #[test]
    fn an_effect_counts_by_its_slope() {
        let plain = pace(&[]);
        let at = |kind, location| EffectParameters::new(kind, location);
        let cogging = |order| {
            at(Kind::Cogging, Location::Motor).with("order", order).with("amplitude_nm", 1e-5)
        };
        // 0.05 Nm/rad of bristle and 0.01 of spring on the rotor, and 5 of cogging.
        assert!(pace(&[cogging(5e5)]).mode_rad_per_s > 8.0 * plain.mode_rad_per_s);
        assert!(pace(&[cogging(5e5)]).micro_steps(50e-6) > plain.micro_steps(50e-6));
        assert_eq!(pace(&[cogging(6.0)]).micro_steps(50e-6), plain.micro_steps(50e-6));
        let play = at(Kind::Backlash, Location::Stage(1)).with("width_rad", 0.1);
        assert_eq!(pace(&[play]), plain);
        let uneven = at(Kind::AsymmetricFriction, Location::Motor).with("asymmetry", 0.5);
        assert!(pace(&[uneven]).growth_per_s > 1.4 * plain.growth_per_s);
        for stiffer in [
            at(Kind::HardeningStiffness, Location::Stage(1))
                .with("cubic_stiffness_nm_per_rad3", 1e10),
            at(Kind::StructuralHysteresis, Location::Stage(1))
                .with("amplitude_nm", 1.0)
                .with("width_rad", 1e-2),
            at(Kind::Coating, Location::Output).with("stiffness_nm_per_rad", 100.0),
            at(Kind::TransmissionError, Location::Stage(1))
                .with("amplitude_rad", 0.1)
                .with("order", 10.0),
        ] {
            assert!(pace(&[stiffer]).mode_rad_per_s > 1.2 * plain.mode_rad_per_s, "{stiffer:?}");
        }
    }

    #[test]
    fn a_fit_takes_no_more_than_a_drive() {
        for step in [1e-5, 5e-5, 1e-4, 1e-3] {
            let pace = pace(&[]);
            assert!(pace.coarse_micro_steps(step) <= pace.micro_steps(step));
        }
    }
}
