//! What a law is built from: an effect's values, its place in the chain, and the joint's units there.

use super::{EffectParameters, Knots};
use crate::params::Location;
use crate::per_unit::Bases;

/// An effect at its place. Units are those of the mass's own side; torque and angle are negative there
/// where the gear reverses.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place<'a> {
    /// Its values, in the order of its spec.
    pub values: &'a [f64],
    /// The knots of its table.
    pub knots: &'a Knots,
    /// Where that is.
    pub location: Location,
    /// Its mass, 0 at the rotor.
    pub mass: u8,
    /// Where its memory is, if it has one.
    pub slot: u8,
    /// Which table is its own, if it has one.
    pub table: u8,
    /// Whether it sits at the encoder behind the last stage.
    pub behind: bool,
    /// Product of the ratios from the motor to its mass.
    pub shaft: f64,
    /// Unit of torque, Nm.
    pub torque: f64,
    /// Unit of deflection, rad.
    pub angle: f64,
    /// The same on the mass before, the input of the stage; `None` at the rotor.
    pub input_angle: Option<f64>,
    /// Unit of speed, rad/s.
    pub speed: f64,
    /// Half a micro-step, s.
    pub half_step: f64,
    /// Coulomb level of its mass, Nm.
    pub coulomb: f64,
    /// The winding's 2R, ohm.
    pub resistance: f64,
    /// Unit of current, A.
    pub current: f64,
}

impl<'a> Place<'a> {
    /// Of an effect in a joint of these units, with its memory in the first slot and its table in the
    /// second; `None` where the joint has no such place.
    pub(super) fn of(
        effect: &'a EffectParameters,
        bases: &Bases<'_>,
        [slot, table]: [u8; 2],
    ) -> Option<Self> {
        let mass = bases.mass(effect.location)?;
        let shaft = bases.shaft(mass);
        Some(Self {
            values: &effect.values,
            knots: &effect.table,
            location: effect.location,
            mass: u8::try_from(mass).ok()?,
            slot,
            table,
            behind: matches!(effect.location, Location::OutputEncoder),
            shaft,
            torque: bases.torque_at(mass),
            angle: bases.angle_at(mass),
            input_angle: mass.checked_sub(1).map(|before| bases.angle_at(before)),
            speed: bases.speed * shaft,
            half_step: bases.half_step,
            coulomb: bases.coulomb_at(mass),
            resistance: bases.resistance,
            current: bases.current,
        })
    }

    /// Its stage, from 0 at the motor; `None` at the rotor.
    pub(super) fn stage(&self) -> Option<u8> {
        self.mass.checked_sub(1)
    }

    /// Units of torque and deflection, and how far a unit of speed moves in half a micro-step, rad.
    pub(super) fn own(&self) -> [f64; 3] {
        [self.torque, self.angle, self.speed * self.half_step]
    }
}
