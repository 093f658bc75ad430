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
    /// Largest rotor speed, rad/s: a drive in torque mode has no back-EMF to end a run.
    pub speed: f64,
}

impl Rating {
    /// From the model alone: the voltage that shows all of it, or the current that it drives through a
    /// winding at rest, and the load that a quarter of that holds at a standstill.
    pub fn of(model: &Model, kind: Drive) -> Self {
        let bases = Bases::si(&model.motor, &model.stages);
        let volts = amplitude_v(model);
        let drive = match kind {
            Drive::Voltage => volts,
            Drive::Current if bases.resistance > 0.0 => volts / bases.resistance,
            // No winding to tell of a current: what moves the joint six times over, or, without
            // friction, takes the rotor to 100 rad/s in a tenth of a second.
            Drive::Current => {
                let rotor = 1e3 * model.motor.rotor_inertia_kg_m2;
                let torque = (6.0 * breakaway_nm(model)).max(rotor);
                torque / model.motor.torque_constant_nm_per_a
            }
        };
        let load_nm = Self::holds(model, kind, drive);
        let speed = volts / model.motor.torque_constant_nm_per_a;
        Self { drive, load_nm, current_a: f64::INFINITY, speed }
    }

    /// What the friction of the whole joint holds at the output, Nm.
    pub fn held(model: &Model) -> f64 {
        let bases = Bases::si(&model.motor, &model.stages);
        let shaft = bases.shaft(model.stages.len()).abs();
        let held = breakaway_nm(model) / shaft;
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

/// Torque at the motor that breaks the whole joint away, Nm.
pub fn breakaway_nm(model: &Model) -> f64 {
    let bases = Bases::si(&model.motor, &model.stages);
    let stages = model.stages.iter().enumerate();
    let behind: f64 =
        stages.map(|(k, stage)| stage.friction.breakaway_nm() * bases.shaft(k + 1).abs()).sum();
    model.motor.friction.breakaway_nm() + behind
}
