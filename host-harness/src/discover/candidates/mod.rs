//! How each effect is spotted: its start values, scales and bounds, one file per effect.
//!
//! A candidate proposes hypotheses; whether one holds is decided elsewhere and the same way for
//! all. To add one: a file beside these and a row in [`ALL`].

mod asymmetric_friction;
mod backlash;
mod cogging;
mod current_offset;
mod dead_time;
mod gravity;
mod load_dependent_friction;

use super::hypothesis::Hypothesis;
use super::score_test::{Gain, ScoreTest};
use crate::estimate::record::{Channel, Record};
use crate::model::Model;
use joint_core::params::{Friction, Location};
use joint_core::per_unit::Bases;

/// What a candidate may look at.
pub struct Scene<'a> {
    /// The refitted model.
    pub model: &'a Model,
    /// The record.
    pub record: &'a Record,
    /// What orders of the rotor angle would explain, strongest first.
    pub lines: Vec<(f64, Gain)>,
}

/// Proposes hypotheses for one kind of effect.
pub type Candidate = fn(&Scene<'_>) -> Vec<Hypothesis>;

/// Every candidate.
pub const ALL: &[Candidate] = &[
    asymmetric_friction::propose,
    backlash::propose,
    cogging::propose,
    current_offset::propose,
    dead_time::propose,
    gravity::propose,
    load_dependent_friction::propose,
];

impl<'a> Scene<'a> {
    /// Of a refitted model on a record.
    pub fn new(model: &'a Model, record: &'a Record, test: &ScoreTest<'_>) -> Self {
        let mut scene = Self { model, record, lines: Vec::new() };
        scene.lines = cogging::spectrum(&scene, test);
        scene
    }

    /// Breakaway level of the whole joint at the motor, Nm; a share of the largest motor torque
    /// where the model has no friction.
    pub fn torque_scale(&self) -> f64 {
        let bases = Bases::si(&self.model.motor, &self.model.stages);
        let breakaway: f64 = (0..=self.model.stages.len())
            .map(|mass| self.friction(mass).breakaway_nm() * bases.shaft(mass).abs())
            .sum();
        if breakaway > 0.0 { breakaway } else { 0.05 * self.largest_torque() }
    }

    /// Largest current that flows or is imposed, A.
    pub fn largest_current(&self) -> f64 {
        let imposed = self.record.drive == joint_core::joint::Drive::Current;
        let measured = self.record.measured.iter().map(|row| row[Channel::Current as usize]);
        let largest =
            |most: f64, value: f64| if value.is_finite() { most.max(value.abs()) } else { most };
        if imposed {
            return self.record.drive_values.iter().copied().fold(0.0, largest);
        }
        let seen = measured.fold(0.0, largest);
        if seen > 0.0 {
            seen
        } else {
            self.largest_drive() / (2.0 * self.model.motor.phase_resistance_ohm)
        }
    }

    /// Largest imposed voltage or current.
    pub fn largest_drive(&self) -> f64 {
        self.record.drive_values.iter().fold(0.0_f64, |most, v| most.max(v.abs()))
    }

    /// Largest motor torque, Nm.
    pub fn largest_torque(&self) -> f64 {
        self.largest_current() * self.model.motor.torque_constant_nm_per_a
    }

    /// Friction of a mass, 0 at the rotor.
    pub fn friction(&self, mass: usize) -> &Friction {
        match mass.checked_sub(1).and_then(|k| self.model.stages.get(k)) {
            Some(stage) => &stage.friction,
            None => &self.model.motor.friction,
        }
    }

    /// Ratio of a mass to the motor.
    pub fn shaft(&self, mass: usize) -> f64 {
        Bases::si(&self.model.motor, &self.model.stages).shaft(mass)
    }

    /// The places of the masses: the motor, then the stages.
    pub fn masses(&self) -> impl Iterator<Item = (usize, Location)> + use<> {
        (0..=self.model.stages.len()).map(|mass| match mass {
            0 => (0, Location::Motor),
            k => (k, Location::Stage(k as u8)),
        })
    }

    /// Whether the model already has this effect there.
    pub fn has(&self, kind: joint_core::effect::Kind, location: Location) -> bool {
        self.model.effects.iter().any(|e| e.kind == kind && e.location == location)
    }
}
