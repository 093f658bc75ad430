//! What a motion's friction really was.

use joint_core::per_unit::Bases;

use super::twin::Twin;
use crate::model::Model;
use crate::plant::Layout;

/// Friction of the whole joint at the motor by sample, Nm: LuGre at every mass, equations (2) and
/// (3), without what effects add.
pub fn frictions(model: &Model, motion: &Twin) -> Vec<f64> {
    motion.states.iter().map(|state| friction(model, state)).collect()
}

/// The same of one state.
pub fn friction(model: &Model, state: &[f64]) -> f64 {
    let layout = Layout::of(model);
    let bases = Bases::si(&model.motor, &model.stages);
    let of_mass = |mass: usize| {
        let shaft = bases.shaft(mass);
        let own = match mass.checked_sub(1) {
            None => &model.motor.friction,
            Some(k) => &model.stages[k].friction,
        };
        let speed = state[layout.speed(mass)] * shaft.abs();
        let zeta = state[layout.bristle(mass)];
        let bell = (-(speed / own.stribeck_velocity_rad_per_s).powi(2)).exp();
        let level = own.coulomb_nm + own.stribeck_nm * bell;
        let bending =
            if level > 0.0 { 1.0 - speed.signum() * zeta * own.coulomb_nm / level } else { 1.0 };
        let torque = own.coulomb_nm * zeta
            + (own.sigma1_nm_s_per_rad * bending + own.sigma2_nm_s_per_rad) * speed;
        torque * shaft.abs()
    };
    (0..=model.stages.len()).map(of_mass).sum()
}
