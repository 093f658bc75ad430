//! Which parameters a refit moves, and how far it expects to.
//!
//! A nominal model is wrong by per cents, not by factors: a few per cent where a datasheet or a
//! scale gives the number, tens of per cent for friction. That expectation is a prior on the
//! logarithm of each parameter; what a log cannot determine stays where the prior puts it.

use joint_core::joint::Drive;
use joint_core::params::Friction;

use joint_simulation::model::Model;

/// A parameter whose uncertainty shrank to no less than this share of its prior is not determined by a log.
const DETERMINED: f64 = 0.7;
/// Standard deviations on either side of the mean that hold 95 % of a normal distribution.
const NORMAL_95: f64 = 1.96;

/// One number of a model that a refit moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Quantity {
    /// R of one phase.
    Resistance,
    /// L of one phase.
    Inductance,
    /// k_t, with k_e = k_t / 2.
    TorqueConstant,
    /// J of a mass, 0 at the rotor.
    Inertia(usize),
    /// k1 of a stage, from 0.
    Stiffness(usize),
    /// k3 of a stage.
    CubicStiffness(usize),
    /// c of a stage's spring.
    Damping(usize),
    /// Inertia of the load.
    LoadInertia,
    /// Amplitude of gravity.
    Gravity,
    /// Phase of gravity, rad.
    GravityPhase,
    /// σ0 of a mass.
    BristleStiffness(usize),
    /// σ1 of a mass.
    BristleDamping(usize),
    /// σ2 of a mass.
    Viscous(usize),
    /// α0 of a mass.
    Coulomb(usize),
    /// α1 of a mass.
    Stribeck(usize),
    /// v0 of a mass.
    StribeckVelocity(usize),
    /// Level of all friction on the day of a log, from 1, over that of the first.
    FrictionLevel(usize),
    /// How late a log shows the current beside a voltage.
    CurrentDelay,
}

/// One sigma of what a datasheet gives, relative.
const DATASHEET: f64 = 0.06;
/// One sigma of what nobody measures, relative.
const GUESSED: f64 = 0.16;
/// One sigma of what is known by its order of magnitude alone, relative.
const UNKNOWN: f64 = 1.0;

impl Quantity {
    /// The levels of friction of so many logs of a model.
    pub fn levels(model: &Model, logs: usize) -> impl Iterator<Item = Quantity> {
        (1..logs).filter(|_| model.rubs()).map(Quantity::FrictionLevel)
    }

    /// The quantities of a model that are not zero, in the order of the model file.
    pub fn of(model: &Model, drive: Drive) -> Vec<Quantity> {
        let mut all = Vec::new();
        if drive == Drive::Voltage {
            all.extend([Quantity::Resistance, Quantity::Inductance, Quantity::TorqueConstant]);
        }
        for mass in 0..=model.stages.len() {
            if let Some(stage) = mass.checked_sub(1) {
                all.extend([
                    Quantity::Stiffness(stage),
                    Quantity::CubicStiffness(stage),
                    Quantity::Damping(stage),
                ]);
            }
            all.extend([
                Quantity::Inertia(mass),
                Quantity::BristleStiffness(mass),
                Quantity::BristleDamping(mass),
                Quantity::Viscous(mass),
                Quantity::Coulomb(mass),
                Quantity::Stribeck(mass),
            ]);
            if friction(model, mass).is_some_and(|friction| friction.stribeck_nm != 0.0) {
                all.push(Quantity::StribeckVelocity(mass));
            }
        }
        all.extend([Quantity::LoadInertia, Quantity::Gravity]);
        all.retain(|quantity| quantity.get(model) != 0.0);
        if model.load.gravity_nm != 0.0 {
            all.push(Quantity::GravityPhase);
        }
        all
    }

    /// Its value in a model.
    pub fn get(self, model: &Model) -> f64 {
        let mut copy = model.clone();
        self.slot(&mut copy).map_or(0.0, |slot| *slot)
    }

    /// Moves a model's value by a step in the coordinate of the prior: relative for a positive
    /// quantity (the logarithm), absolute for an angle.
    pub fn shift(self, model: &mut Model, step: f64) {
        let relative = self.is_relative();
        if let Some(slot) = self.slot(model) {
            *slot = if relative { *slot * step.exp() } else { *slot + step };
        }
        if self == Quantity::TorqueConstant {
            model.motor.phase_back_emf_constant_v_s_per_rad =
                Some(model.motor.torque_constant_nm_per_a / 2.0);
        }
    }

    /// How far `to` lies from `from` in the coordinate of the prior.
    pub fn distance(self, from: &Model, to: &Model) -> f64 {
        let (from, to) = (self.get(from), self.get(to));
        if self.is_relative() { (to / from).ln() } else { to - from }
    }

    /// Whether its coordinate is a logarithm.
    pub fn is_relative(self) -> bool {
        self != Quantity::GravityPhase
    }

    /// One sigma of the prior.
    pub fn prior_sigma(self) -> f64 {
        match self {
            Quantity::Resistance
            | Quantity::Inductance
            | Quantity::TorqueConstant
            | Quantity::Inertia(_)
            | Quantity::LoadInertia => DATASHEET,
            Quantity::CurrentDelay => UNKNOWN,
            _ => GUESSED,
        }
    }

    /// Whether a log has told it: the uncertainty in the coordinate of the prior has shrunk by at least
    /// three tenths.
    pub fn is_determined(self, sigma: f64) -> bool {
        sigma < DETERMINED * self.prior_sigma()
    }

    /// One sigma in its unit, from one in the coordinate of the prior.
    pub fn sigma_of(self, model: &Model, sigma: f64) -> f64 {
        if self.is_relative() { sigma * self.get(model).abs() } else { sigma }
    }

    /// Its interval of 95 % in its unit, from one sigma in the coordinate of the prior.
    pub fn interval(self, model: &Model, sigma: f64) -> [f64; 2] {
        let value = self.get(model);
        [-NORMAL_95 * sigma, NORMAL_95 * sigma].map(|step| match self.is_relative() {
            true => value * step.exp(),
            false => value + step,
        })
    }

    /// Its place in the model file.
    pub fn key(self) -> String {
        let own = |mass: usize, key: &str| match mass {
            0 => format!("motor.friction.{key}"),
            k => format!("stage{k}.friction.{key}"),
        };
        match self {
            Quantity::Resistance => "motor.phase_resistance_ohm".into(),
            Quantity::Inductance => "motor.phase_inductance_h".into(),
            Quantity::TorqueConstant => "motor.torque_constant_nm_per_a".into(),
            Quantity::Inertia(0) => "motor.rotor_inertia_kg_m2".into(),
            Quantity::Inertia(k) => format!("stage{k}.inertia_kg_m2"),
            Quantity::Stiffness(k) => format!("stage{}.stiffness_nm_per_rad", k + 1),
            Quantity::CubicStiffness(k) => format!("stage{}.cubic_stiffness_nm_per_rad3", k + 1),
            Quantity::Damping(k) => format!("stage{}.damping_nm_s_per_rad", k + 1),
            Quantity::LoadInertia => "load.inertia_kg_m2".into(),
            Quantity::Gravity => "load.gravity_nm".into(),
            Quantity::GravityPhase => "load.gravity_phase_rad".into(),
            Quantity::BristleStiffness(m) => own(m, "sigma0_nm_per_rad"),
            Quantity::BristleDamping(m) => own(m, "sigma1_nm_s_per_rad"),
            Quantity::Viscous(m) => own(m, "sigma2_nm_s_per_rad"),
            Quantity::Coulomb(m) => own(m, "coulomb_nm"),
            Quantity::Stribeck(m) => own(m, "stribeck_nm"),
            Quantity::StribeckVelocity(m) => own(m, "stribeck_velocity_rad_per_s"),
            Quantity::FrictionLevel(log) => format!("log{}.friction_level", log + 1),
            Quantity::CurrentDelay => "sensor.current_delay_s".into(),
        }
    }

    fn slot(self, model: &mut Model) -> Option<&mut f64> {
        Some(match self {
            Quantity::Resistance => &mut model.motor.phase_resistance_ohm,
            Quantity::Inductance => &mut model.motor.phase_inductance_h,
            Quantity::TorqueConstant => &mut model.motor.torque_constant_nm_per_a,
            Quantity::Inertia(0) => &mut model.motor.rotor_inertia_kg_m2,
            Quantity::Inertia(mass) => &mut model.stages.get_mut(mass - 1)?.inertia_kg_m2,
            Quantity::Stiffness(k) => &mut model.stages.get_mut(k)?.stiffness_nm_per_rad,
            Quantity::CubicStiffness(k) => {
                &mut model.stages.get_mut(k)?.cubic_stiffness_nm_per_rad3
            }
            Quantity::Damping(k) => &mut model.stages.get_mut(k)?.damping_nm_s_per_rad,
            Quantity::LoadInertia => &mut model.load.inertia_kg_m2,
            Quantity::Gravity => &mut model.load.gravity_nm,
            Quantity::GravityPhase => &mut model.load.gravity_phase_rad,
            Quantity::BristleStiffness(m) => &mut friction_mut(model, m)?.sigma0_nm_per_rad,
            Quantity::BristleDamping(m) => &mut friction_mut(model, m)?.sigma1_nm_s_per_rad,
            Quantity::Viscous(m) => &mut friction_mut(model, m)?.sigma2_nm_s_per_rad,
            Quantity::Coulomb(m) => &mut friction_mut(model, m)?.coulomb_nm,
            Quantity::Stribeck(m) => &mut friction_mut(model, m)?.stribeck_nm,
            Quantity::StribeckVelocity(m) => {
                &mut friction_mut(model, m)?.stribeck_velocity_rad_per_s
            }
            Quantity::CurrentDelay => &mut model.sensor.current_delay_s,
            Quantity::FrictionLevel(log) => {
                let levels = &mut model.friction_levels;
                levels.resize(levels.len().max(log + 1), 1.0);
                &mut levels[log]
            }
        })
    }
}

fn friction(model: &Model, mass: usize) -> Option<&Friction> {
    match mass.checked_sub(1) {
        None => Some(&model.motor.friction),
        Some(k) => model.stages.get(k).map(|stage| &stage.friction),
    }
}

fn friction_mut(model: &mut Model, mass: usize) -> Option<&mut Friction> {
    match mass.checked_sub(1) {
        None => Some(&mut model.motor.friction),
        Some(k) => model.stages.get_mut(k).map(|stage| &mut stage.friction),
    }
}
