//! What a number format of finite range can hold of a joint.
//!
//! A fixed-point word ends at ±32 and a constant at ±32768. Constants follow from the parameters, so a
//! joint is refused where one of them would stop there, by the name of its parameter. States follow
//! from the inputs too: [`largest_drive`] is the drive up to which, beside a given load, no word of the
//! step comes to its end, for inputs that turn round at once but not before the swing from the last
//! time has died out. Inputs that pump a resonance may go beyond; words then stop instead of wrapping,
//! and [`crate::joint::Joint::saturated`] counts them.

use crate::gear::deflection;
use crate::number::Limits;
use crate::params::{Check, Load, Motor, ParameterError, Reason, Stage, Table};
use crate::per_unit::{Bases, reflected_inertia};
use crate::settings::{Drive, Settings};

/// A constant as it stands in a word, and the parameter that it grows with.
struct Constant {
    table: Table,
    key: &'static str,
    given: f64,
    word: f64,
    limit: f64,
}

impl Constant {
    fn check(&self) -> Result<(), ParameterError> {
        if libm::fabs(self.word) < self.limit {
            return Ok(());
        }
        let high = self.given * self.limit / libm::fabs(self.word);
        let reason = Reason::OutOfRange { low: 0.0, high };
        Err(Check(self.table).fail(self.key, self.given, reason))
    }
}

/// Whether every constant of a joint in units of `bases` fits the format; `step` is the micro-step, s.
///
/// # Errors
/// The first that does not, by the key of the parameter that it grows with, and how large that may be.
pub(crate) fn check<S: Limits>(
    bases: &Bases<'_>,
    stages: &[Stage],
    step: f64,
) -> Result<(), ParameterError> {
    for mass in 0..=stages.len() {
        let (friction, shaft) = (bases.friction(mass), libm::fabs(bases.shaft(mass)));
        let table = if mass == 0 { Table::MotorFriction } else { Table::StageFriction(mass) };
        let damping = shaft * shaft * bases.speed / bases.torque;
        let constant = |key, given, word, limit| Constant { table, key, given, word, limit };
        let sigma1 = friction.sigma1_nm_s_per_rad;
        constant("sigma1_nm_s_per_rad", sigma1, 2.0 * sigma1 * damping, S::LARGEST).check()?;
        let sigma2 = friction.sigma2_nm_s_per_rad;
        constant("sigma2_nm_s_per_rad", sigma2, 2.0 * sigma2 * damping, S::LARGEST).check()?;
        if friction.coulomb_nm > 0.0 {
            let (sigma0, stribeck) = (friction.sigma0_nm_per_rad, friction.stribeck_nm);
            let reach = sigma0 * shaft * 0.5 * step / friction.coulomb_nm * bases.speed;
            constant("sigma0_nm_per_rad", sigma0, reach, S::LARGEST_GAIN).check()?;
            // The level and its double in the bristle's way.
            let beta = 2.0 * (1.0 + stribeck / friction.coulomb_nm);
            constant("stribeck_nm", stribeck, beta, S::LARGEST / 2.0).check()?;
        }
    }
    for (k, stage) in stages.iter().enumerate() {
        let shaft = bases.shaft(k + 1);
        let linear = stage.stiffness_nm_per_rad;
        let word = linear * shaft * shaft * bases.angle / bases.torque;
        let (table, key, limit) = (Table::Stage(k + 1), "stiffness_nm_per_rad", S::LARGEST);
        Constant { table, key, given: linear, word, limit }.check()?;
    }
    Ok(())
}

/// The largest drive, V or A, up to which no word of the step ends its range beside a load of up to
/// `load_nm`; zero where the load alone is too much. Infinite for floats.
pub fn largest_drive<S: Limits>(
    motor: &Motor,
    stages: &[Stage],
    load: &Load,
    settings: &Settings<'_>,
    load_nm: f64,
) -> f64 {
    if S::LARGEST.is_infinite() {
        return f64::INFINITY;
    }
    let bases = Bases::of(motor, stages, settings.step_s);
    let per_unit = match settings.drive {
        Drive::Voltage => bases.resistance * bases.current,
        Drive::Current => bases.current,
    };
    let last = bases.shaft(stages.len());
    let loaded = libm::fabs(load_nm * last) / bases.torque;
    let friction: f64 = (0..=stages.len()).map(|mass| bases.breakaway(mass)).sum();
    let inertia = |mass| reflected_inertia(motor, stages, load, mass);
    let whole: f64 = (0..=stages.len()).map(inertia).sum();
    let holds = |drive: f64| {
        // At rest the winding brakes as the unit of speed is made: a torque of one at a speed of one.
        let speed = drive + loaded;
        let torque = 2.0 * (drive + loaded + friction / bases.torque);
        let mut most = (drive + speed).max(torque).max(libm::fabs(load_nm));
        most = most.max(drive * per_unit);
        for mass in 0..=stages.len() {
            let shaft = libm::fabs(bases.shaft(mass));
            let mut swing = 0.0;
            if let Some(stage) = mass.checked_sub(1).and_then(|k| stages.get(k)) {
                let stiffness = stage.stiffness_nm_per_rad * shaft * shaft;
                // What can turn round at once: the load, its friction, its share of the drive's torque.
                let behind: f64 = (mass..=stages.len()).map(inertia).sum();
                let sudden = loaded + bases.breakaway(mass) / bases.torque + drive * behind / whole;
                let impedance = libm::sqrt(stiffness * inertia(mass)) * bases.speed;
                swing = 2.0 * sudden * bases.torque / impedance;
                let bent = deflection(stage, torque * bases.torque / shaft) / shaft;
                most = most.max(bent / bases.angle);
            }
            let fastest = speed + swing;
            let friction = bases.friction(mass);
            let loss = 2.0 * friction.sigma1_nm_s_per_rad + friction.sigma2_nm_s_per_rad;
            let damping = loss * shaft * shaft * bases.speed / bases.torque;
            most = most.max(fastest).max(damping * fastest);
        }
        most < S::LARGEST
    };
    if !holds(0.0) {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, S::LARGEST);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low * per_unit
}
