//! From SI to the step's own units.
//!
//! The chain is reflected to the motor shaft once: with N the product of the ratios η up to a mass,
//! its angle is divided by N, torques on it are multiplied by N, inertias, stiffnesses and damping
//! by N². What is left spans a few decades instead of ten, and is then divided by bases taken from
//! the parameters, so that states are of the order of one in every number format.

use crate::gear::deflection;
use crate::params::{Load, Location, Motor, Stage};

/// The joint's units, and what effects need to know of the joint.
#[derive(Clone, Copy, Debug)]
pub struct Bases<'a> {
    motor: &'a Motor,
    stages: &'a [Stage],
    /// Unit of torque at the motor, Nm.
    pub torque: f64,
    /// Unit of speed at the motor, rad/s.
    pub speed: f64,
    /// Unit of deflection at the motor, rad.
    pub angle: f64,
    /// Unit of current, A.
    pub current: f64,
    /// The winding's 2R, ohm.
    pub resistance: f64,
    /// Half a micro-step, s; one second for rates in SI.
    pub half_step: f64,
}

impl<'a> Bases<'a> {
    /// Units of one: reflected SI, for the host's reference.
    pub fn si(motor: &'a Motor, stages: &'a [Stage]) -> Self {
        let resistance = 2.0 * motor.phase_resistance_ohm;
        Self {
            motor,
            stages,
            torque: 1.0,
            speed: 1.0,
            angle: 1.0,
            current: 1.0,
            resistance,
            half_step: 1.0,
        }
    }

    /// Units from the parameters: torque of four times the breakaway level of the whole joint, current from
    /// the torque, speed from what that current's voltage would run at, deflection from the speed
    /// over `step` seconds, doubled until no spring bends by more than sixteen under eight such torques.
    pub fn of(motor: &'a Motor, stages: &'a [Stage], step: f64) -> Self {
        let si = Self::si(motor, stages);
        let breakaway: f64 = (0..=stages.len()).map(|mass| si.breakaway(mass)).sum();
        let constant = motor.torque_constant_nm_per_a;
        let torque = if breakaway > 0.0 { 4.0 * breakaway } else { constant };
        let current = torque / constant;
        let speed = if si.resistance > 0.0 {
            si.resistance * current / constant
        } else {
            100.0 * motor.friction.stribeck_velocity_rad_per_s
        };
        // Deflections under a torque of eight units stay below sixteen, by powers of two.
        let deepest = (1..=stages.len()).zip(stages).fold(0.0, |deepest: f64, (mass, stage)| {
            let shaft = libm::fabs(si.shaft(mass));
            deepest.max(deflection(stage, 8.0 * torque / shaft) / shaft)
        });
        let mut angle = speed * step;
        // Parameters whose product leaves double precision have no unit.
        while angle > 0.0 && angle < deepest / 16.0 {
            angle *= 2.0;
        }
        Self { torque, speed, angle, current, ..si }
    }

    /// The stages, from the motor on.
    pub(crate) fn stages(&self) -> &'a [Stage] {
        self.stages
    }

    /// Product N of the ratios η from the motor to a mass; 1 for the rotor.
    pub fn shaft(&self, mass: usize) -> f64 {
        self.stages.iter().take(mass).map(|stage| 1.0 / stage.reduction).product()
    }

    /// The mass at a place, 0 at the rotor; `None` where there is no such stage.
    pub fn mass(&self, location: Location) -> Option<usize> {
        mass_at(location, self.stages.len())
    }

    /// Unit of torque on a mass, at its own side, Nm; negative where the gear reverses.
    pub fn torque_at(&self, mass: usize) -> f64 {
        self.torque / self.shaft(mass)
    }

    /// Unit of angle of a mass, at its own side, rad; negative where the gear reverses.
    pub fn angle_at(&self, mass: usize) -> f64 {
        self.angle * self.shaft(mass)
    }

    /// Coulomb level of a mass at its own side, Nm.
    pub fn coulomb_at(&self, mass: usize) -> f64 {
        self.friction(mass).coulomb_nm
    }

    pub(crate) fn friction(&self, mass: usize) -> &'a crate::params::Friction {
        match mass.checked_sub(1).and_then(|k| self.stages.get(k)) {
            Some(stage) => &stage.friction,
            None => &self.motor.friction,
        }
    }

    /// Breakaway level of a mass, reflected to the motor, Nm.
    pub(crate) fn breakaway(&self, mass: usize) -> f64 {
        self.friction(mass).breakaway_nm() * libm::fabs(self.shaft(mass))
    }
}

/// Inertia of every mass reflected to the motor, kg m²: `inertia(0)` is the rotor. The load's
/// inertia is added to the last mass, and a stage without inertia gets a hundredth of what lies
/// before it.
pub fn reflected_inertia(motor: &Motor, stages: &[Stage], load: &Load, mass: usize) -> f64 {
    let mut shaft = 1.0;
    let mut inertia = motor.rotor_inertia_kg_m2;
    if stages.is_empty() {
        return inertia + load.inertia_kg_m2;
    }
    for (k, stage) in stages.iter().enumerate().take(mass) {
        shaft /= stage.reduction;
        let own =
            stage.inertia_kg_m2 + if k + 1 == stages.len() { load.inertia_kg_m2 } else { 0.0 };
        inertia = if own > 0.0 { own * shaft * shaft } else { 0.01 * inertia };
    }
    inertia
}

/// The place of an effect among the masses: its own number for the rotor and the stages, the last
/// one for the output.
pub(crate) fn mass_at(location: Location, stages: usize) -> Option<usize> {
    match location {
        Location::Stage(k) => {
            let k = usize::from(k);
            (k >= 1 && k <= stages).then_some(k)
        }
        Location::Output | Location::OutputEncoder => Some(stages),
        Location::Motor | Location::Inverter | Location::CurrentSensor | Location::Encoder => {
            Some(0)
        }
    }
}
