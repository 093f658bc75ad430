//! For what an observer is designed: how much drive, how much load, which sensors.

use joint_core::joint::Drive;
use joint_core::per_unit::Bases;

use crate::model::Model;
use crate::synthetic::amplitude_v;

/// What a joint is rated for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rating {
    /// Largest drive, V or A.
    pub drive: f64,
    /// Largest load at the output, Nm.
    pub load_nm: f64,
    /// Where the current sensor ends, A.
    pub current_a: f64,
}

impl Rating {
    /// From the model alone: the voltage that shows all of it, and the load that a quarter of that
    /// voltage holds at a standstill.
    pub fn of(model: &Model, kind: Drive) -> Self {
        let bases = Bases::si(&model.motor, &model.stages);
        let volts = amplitude_v(model);
        let current = volts / bases.resistance.max(1e-9);
        let drive = match kind {
            Drive::Voltage => volts,
            Drive::Current => current,
        };
        let load_nm = Self::holds(model, kind, drive);
        Self { drive, load_nm, current_a: f64::INFINITY }
    }

    /// What the friction of the whole joint holds at the output, Nm.
    pub fn held(model: &Model) -> f64 {
        let bases = Bases::si(&model.motor, &model.stages);
        let shaft = bases.shaft(model.stages.len()).abs();
        let held = super::design::breakaway_nm(model) / shaft;
        if held > 0.0 { held } else { 0.01 * model.motor.torque_constant_nm_per_a / shaft }
    }

    /// A quarter of the torque at the output that this drive holds at a standstill, Nm.
    pub fn holds(model: &Model, kind: Drive, drive: f64) -> f64 {
        let bases = Bases::si(&model.motor, &model.stages);
        let current = match kind {
            Drive::Voltage => drive / bases.resistance.max(1e-9),
            Drive::Current => drive,
        };
        let torque = current * model.motor.torque_constant_nm_per_a;
        0.25 * torque / bases.shaft(model.stages.len()).abs()
    }
}
