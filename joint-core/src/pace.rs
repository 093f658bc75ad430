//! How fast a joint can change, and how many micro-steps that asks for.
//!
//! A step costs the same whatever the data, so it is divided once, when the joint is built, for the
//! worst that its parameters allow: the fastest vibration, the strongest damping, and the fastest
//! growth of a slip that the falling Stribeck curve feeds. What would have to be divided too often
//! to be stable is stepped by the implicit method. Effects count where they stiffen a joint or
//! raise a friction level; play does neither.

use crate::effect::{EffectParameters, Kind, torque_map};
use crate::friction::LEAST_BETA;
use crate::gear::tangent;
use crate::params::{Friction, Load, Location, Motor, Stage};
use crate::per_unit::{Bases, mass_at, reflected_inertia};
use crate::settings::{Method, Settings};
use crate::step::MIDDLE;

/// Most micro-steps one step is divided into.
pub const MAX_MICRO_STEPS: u32 = 64;

/// Turn of the fastest mode in a micro-step, rad, and growth of slip, as the logarithm of a speed,
/// that each alone may fill a micro-step: together they may by the root of their squares. Found on
/// random plants, where the error of those with as much of both is the largest.
const PHASE: f64 = 0.35;
const GROWTH: f64 = 1.0;
/// The same limits where a fit runs the model many times over and its own noise is larger.
const COARSE_PHASE: f64 = 1.2;
const COARSE_GROWTH: f64 = 0.75;
/// Turn of the fastest mode, rad, up to which the splitting is stable, with a margin to √12, and the
/// micro-steps beyond which that is too much to ask.
const MOST_STABLE: f64 = 32.0;
const STABLE_PHASE: f64 = 2.5;
/// Fewest micro-steps of the implicit method, for a drive and for a fit, and the largest growth of
/// slip in one.
const LEAST_OF_IMPLICIT: f64 = 8.0;
const COARSE_OF_IMPLICIT: f64 = 4.0;
const IMPLICIT_GROWTH: f64 = 1.0;
/// Steepest slope of exp(−x²).
const STEEPEST: f64 = 0.857_763_884_960_706_8;

/// A method, and the micro-steps that it takes in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// The method.
    pub method: Method,
    /// Its micro-steps.
    pub micro_steps: u32,
}

/// The rates that bound a micro-step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pace {
    /// Bound for the fastest mode of the chain, rad/s, with every spring at its tangent under twice
    /// the breakaway torque and every bristle stuck.
    pub mode_rad_per_s: f64,
    /// Strongest damping of a mass, 1/s: (σ1 (1 + s) + σ2)/J, where s is what a bristle that is bent at the
    /// highest level slips back by where the speed turns round, [`most_slipping`].
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
            let [_, maps] = added.maps(mass);
            let loss = (1.0 + most_slipping(friction) * added.level(mass))
                * friction.sigma1_nm_s_per_rad
                + friction.sigma2_nm_s_per_rad
                + maps;
            pace.damping_per_s = pace.damping_per_s.max(loss * square / own);
            let falling = STEEPEST * friction.stribeck_nm * added.level(mass)
                / friction.stribeck_velocity_rad_per_s;
            let gained = (falling + maps - friction.sigma2_nm_s_per_rad) * square / own;
            pace.growth_per_s = pace.growth_per_s.max(gained);
        }
        pace.mode_rad_per_s = libm::sqrt(fastest);
        pace
    }

    /// The method for a step of `step_s` seconds, and its micro-steps.
    ///
    /// The splitting, in micro-steps in which the fastest mode turns by at most 0.35 rad, less where
    /// slip grows as well; slip grows by at most e; and no mass loses more than half its speed to
    /// damping in the middle kick. Beyond 64 micro-steps the mode may turn by more, up to 2.5 rad.
    /// Where that or damping asks for more than 32, the implicit method.
    pub fn plan(&self, step_s: f64) -> Plan {
        let stable = step_s * (self.mode_rad_per_s / STABLE_PHASE).max(self.damping_per_s * MIDDLE);
        if stable > MOST_STABLE {
            let micro_steps = self.implicit_micro_steps(step_s);
            return Plan { method: Method::Implicit, micro_steps };
        }
        Plan { method: Method::Splitting, micro_steps: self.split_micro_steps(step_s) }
    }

    /// Micro-steps of the plan.
    pub fn micro_steps(&self, step_s: f64) -> u32 {
        self.plan(step_s).micro_steps
    }

    /// The fewest that keep the vibrations' phase to 0.2 %, for a fit that runs a model many times
    /// over: at most 1.2 rad, and e^¾ of growth.
    pub fn coarse_micro_steps(&self, step_s: f64) -> u32 {
        let plan = self.plan(step_s);
        let growth = step_s * self.growth_per_s;
        let wanted = match plan.method {
            Method::Splitting => (step_s * self.mode_rad_per_s / COARSE_PHASE)
                .max(growth / COARSE_GROWTH)
                .max(step_s * self.damping_per_s * MIDDLE),
            Method::Implicit => COARSE_OF_IMPLICIT.max(growth / IMPLICIT_GROWTH),
        };
        whole(wanted).min(plan.micro_steps)
    }

    /// Those of the splitting.
    fn split_micro_steps(&self, step_s: f64) -> u32 {
        let growth = self.growth_per_s / GROWTH;
        let resolved = step_s * libm::hypot(self.mode_rad_per_s / PHASE, growth);
        let stable = (self.mode_rad_per_s / STABLE_PHASE).max(self.damping_per_s * MIDDLE);
        whole(resolved.max(step_s * growth.max(stable)))
    }

    /// Those of the implicit method: it has no use of a vibration too fast to be seen, but slip must
    /// not grow faster than it can follow.
    fn implicit_micro_steps(&self, step_s: f64) -> u32 {
        whole((step_s * self.growth_per_s / IMPLICIT_GROWTH).max(LEAST_OF_IMPLICIT))
    }

    /// The plan with what settings ask for instead; `implicit` says whether the number format can be
    /// stepped so.
    pub(crate) fn plan_for(&self, settings: &Settings<'_>, implicit: bool) -> Plan {
        let step = settings.step_s;
        let method = if implicit {
            settings.method.unwrap_or(self.plan(step).method)
        } else {
            Method::Splitting
        };
        let found = match method {
            Method::Splitting => self.split_micro_steps(step),
            Method::Implicit => self.implicit_micro_steps(step),
        };
        let micro_steps = settings.micro_steps.unwrap_or(found).clamp(1, MAX_MICRO_STEPS);
        Plan { method, micro_steps }
    }
}

/// Largest ∂(|v| ρ ζ)/∂v, of which the damping σ1 ∂ż/∂v is one less: ζ up to the highest level, against the
/// speed, times the steepest of |v| ρ, equation (3). One without a Stribeck curve.
fn most_slipping(friction: &Friction) -> f64 {
    if friction.coulomb_nm <= 0.0 {
        return 1.0;
    }
    let beta = (friction.stribeck_nm / friction.coulomb_nm).max(LEAST_BETA);
    let slope = |square: f64| {
        let excess = beta * libm::exp(-square);
        let rho = 1.0 / (1.0 + excess);
        rho * (1.0 + 2.0 * square * excess * rho)
    };
    // The slope turns round within a square of one; at its ends it is 1/(1 + β) and one.
    let steepest = (0..64).map(|k| slope(0.125 * f64::from(k))).fold(1.0, f64::max);
    steepest * (1.0 + beta.max(0.0))
}

/// The next whole number of micro-steps.
fn whole(wanted: f64) -> u32 {
    libm::ceil(wanted).clamp(1.0, f64::from(MAX_MICRO_STEPS)) as u32
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
    fn here(&self, mass: usize) -> impl Iterator<Item = &EffectParameters> {
        let here =
            move |effect: &&EffectParameters| mass_at(effect.location, self.stages) == Some(mass);
        self.effects.iter().filter(here)
    }

    fn sum(&self, mass: usize, of: impl Fn(Kind, &dyn Fn(&str) -> f64) -> f64) -> f64 {
        let each = |effect: &EffectParameters| {
            of(effect.kind, &|key| libm::fabs(effect.get(key).unwrap_or(0.0)))
        };
        self.here(mass).map(each).sum()
    }

    /// Steepest change of the torque of maps at a mass with its angle, Nm/rad, and speed, Nm s/rad.
    fn maps(&self, mass: usize) -> [f64; 2] {
        let maps = self.here(mass).filter(|effect| effect.kind == Kind::TorqueMap);
        maps.fold([0.0; 2], |[angle, speed], map| {
            let [by_angle, by_speed] = torque_map::slopes(&map.values, &map.table);
            [angle + by_angle, speed + by_speed]
        })
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
        let [maps, _] = self.maps(mass);
        link + effects + maps
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
        let courses = self.here(mass).filter(|effect| effect.kind == Kind::FrictionCourse);
        let course = |effect: &EffectParameters| {
            libm::fabs(effect.get("scale").unwrap_or(0.0)) * effect.table.largest()
        };
        1.0 + courses.map(course).sum::<f64>()
            + self.sum(mass, |kind, value| match kind {
                Kind::AsymmetricFriction => value("asymmetry"),
                Kind::PositionDependentFriction => value("relative_amplitude"),
                _ => 0.0,
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Drive;

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
    fn a_chain_too_stiff_to_be_divided_takes_the_implicit_method() {
        let plain = pace(&[]);
        assert_eq!(plain.plan(50e-6).method, Method::Splitting);
        let of = |mode_rad_per_s| Pace { mode_rad_per_s, ..plain };
        // Asks for more than there are, and is stable.
        let stiff = of(1.5e6).plan(50e-6);
        assert_eq!(stiff, Plan { method: Method::Splitting, micro_steps: MAX_MICRO_STEPS });
        let stiffer = of(1e8).plan(50e-6);
        assert_eq!(stiffer, Plan { method: Method::Implicit, micro_steps: 8 });
        assert_eq!(of(1e8).coarse_micro_steps(50e-6), 4);
        let viscous = Pace { damping_per_s: 1e7, ..plain };
        assert_eq!(viscous.plan(50e-6).method, Method::Implicit);
        let asked =
            Settings { method: Some(Method::Splitting), ..Settings::new(Drive::Voltage, 50e-6) };
        assert_eq!(of(1e8).plan_for(&asked, true).micro_steps, MAX_MICRO_STEPS);
        let plan = of(1e8).plan_for(&Settings::new(Drive::Voltage, 50e-6), false);
        assert_eq!(plan.method, Method::Splitting);
    }

    #[test]
    fn a_bristle_against_the_speed_counts_at_its_highest_level_and_steepest_curve() {
        let of = |stribeck_nm| {
            most_slipping(&Friction { coulomb_nm: 1.0, stribeck_nm, ..MOTOR.friction })
        };
        assert_eq!(of(0.0), 1.0);
        for beta in [-0.9, -0.4, 0.3, 2.0, 7.0] {
            // By differences, on a grid twenty times as fine.
            let slip = |speed: f64| speed / (1.0 + beta * (-speed * speed).exp());
            let steepest = (0..6000)
                .map(|k| 5e-4 * f64::from(k))
                .map(|speed| (slip(speed + 1e-6) - slip(speed - 1e-6)) / 2e-6)
                .fold(1.0, f64::max);
            let exact = steepest * (1.0 + beta.max(0.0));
            // Between two points an eighth of the square apart the slope's top is lower by no more.
            assert!((of(beta) / exact - 1.0).abs() < 0.01, "{beta}: {} {exact}", of(beta));
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
