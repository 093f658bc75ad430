//! What a candidate may look at: the refitted model, the record, what the prediction errors pull at,
//! and the sizes of things.

use joint_core::effect::Kind;
use joint_core::joint::Drive;
use joint_core::params::{Friction, Location};
use joint_core::per_unit::Bases;

use super::orders::{Family, span};
use crate::estimate::adjoint::Pull;
use crate::estimate::record::{Channel, Record};
use crate::model::Model;
use crate::plant::Layout;

/// What a candidate may look at.
pub struct Scene<'a> {
    /// The refitted model.
    pub model: &'a Model,
    /// The record.
    pub record: &'a Record,
    pulls: &'a [Pull],
    states: &'a [Vec<f64>],
}

impl<'a> Scene<'a> {
    /// Of a refitted model on a record: what the record's innovations pull at, then those of each replicate, and the
    /// model's states along it.
    pub fn new(
        model: &'a Model,
        record: &'a Record,
        pulls: &'a [Pull],
        states: &'a [Vec<f64>],
    ) -> Self {
        Self { model, record, pulls, states }
    }

    /// A series over the samples from the state there.
    fn series(&self, of: impl Fn(usize, &[f64]) -> f64) -> Vec<f64> {
        self.states.iter().enumerate().map(|(k, x)| of(k, x)).collect()
    }

    /// Angle of a mass at its own side, rad, by sample.
    pub fn angle(&self, mass: usize) -> Vec<f64> {
        let (layout, shaft) = (Layout::of(self.model), self.shaft(mass));
        self.series(|_, x| {
            let wound: f64 = (0..mass).map(|k| x[layout.deflection(k)]).sum();
            (x[Layout::ANGLE] - wound) * shaft
        })
    }

    /// Speed of a mass, reflected to the motor, rad/s, by sample.
    pub fn speed(&self, mass: usize) -> Vec<f64> {
        let at = Layout::of(self.model).speed(mass);
        self.series(|_, x| x[at])
    }

    /// Current by sample, A.
    pub fn current(&self) -> Vec<f64> {
        self.series(|k, x| match self.record.drive {
            Drive::Voltage => x[Layout::CURRENT],
            Drive::Current => self.record.drive_values[k],
        })
    }

    /// Root mean square of a mass's own speed, rad/s.
    pub fn typical_speed(&self, mass: usize) -> f64 {
        rms(&self.speed(mass)) * self.shaft(mass).abs()
    }

    /// Highest motor speed, rad/s.
    pub fn largest_speed(&self) -> f64 {
        self.speed(0).iter().fold(0.0, |most, v| v.abs().max(most))
    }

    /// Root mean square of the current, A.
    pub fn typical_current(&self) -> f64 {
        rms(&self.current())
    }

    /// Root mean square of a stage's wind-up at its output, rad; stages from 0.
    pub fn typical_windup(&self, stage: usize) -> f64 {
        let (at, shaft) = (Layout::of(self.model).deflection(stage), self.shaft(stage + 1));
        rms(&self.series(|_, x| x[at] * shaft))
    }

    /// Distance between a mass's extreme angles, rad.
    pub fn travel(&self, mass: usize) -> f64 {
        span(self.angle(mass).into_iter())
    }

    /// Length of the record, s.
    pub fn duration(&self) -> f64 {
        match (self.record.time_s.first(), self.record.time_s.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }

    /// Lines along an angle: `shape` makes, of a pull at a sample, what a unit of the effect with
    /// sine one pulls at there.
    pub fn family(
        &self,
        angle: Vec<f64>,
        shape: impl Fn(&Pull, usize) -> f64,
        highest: f64,
        periods: f64,
    ) -> Family {
        let samples = angle.len();
        let weights =
            self.pulls.iter().map(|pull| (0..samples).map(|k| shape(pull, k)).collect()).collect();
        Family { angle, weights, highest, periods }
    }

    /// Highest order of the rotor that its samples can show and that is looked for: a line that
    /// passes half a period from sample to sample is not seen as what it is. An axis that turns
    /// little may be a linear one, whose lines lie far higher than a rotor's.
    pub fn highest_order(&self, turns: f64) -> f64 {
        let looked_for = if turns < 0.8 { (200.0 / turns.max(1e-6)).max(144.0) } else { 144.0 };
        let sampled = std::f64::consts::PI / typical_step(&self.angle(0));
        looked_for.min(sampled)
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
        let imposed = self.record.drive == Drive::Current;
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
    pub fn has(&self, kind: Kind, location: Location) -> bool {
        self.model.effects.iter().any(|e| e.kind == kind && e.location == location)
    }
}

/// Median of how far an angle moves from one sample to the next, rad, where it moves.
fn typical_step(angles: &[f64]) -> f64 {
    let mut steps: Vec<f64> = angles
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .filter(|step| *step > 0.0)
        .collect();
    let middle = steps.len() / 2;
    if steps.is_empty() {
        return f64::MIN_POSITIVE;
    }
    *steps.select_nth_unstable_by(middle, f64::total_cmp).1
}

fn rms(values: &[f64]) -> f64 {
    let sum: f64 = values.iter().map(|v| v * v).sum();
    (sum / values.len().max(1) as f64).sqrt()
}
