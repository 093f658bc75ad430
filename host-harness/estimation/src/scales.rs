//! How large the numbers of a joint's state are: what is known of it where a log begins, and steps over
//! which it is differenced.
//!
//! They are taken from the whole record, which a run with given gains has no need of.

use super::record::{CHANNELS, Channel, Record};
use joint_simulation::model::Model;
use joint_simulation::plant::Layout;

/// What a model tells of its scales.
#[derive(Clone, Debug)]
pub(super) struct Known {
    /// By stage: how far friction can wind its spring, rad at the motor.
    reach: Vec<f64>,
    /// One sigma of what the motor's encoder rounds, where the model tells its counts, rad.
    motor_count: f64,
}

/// One sigma of every number of a state at the start of a log, and the steps of each, the drive last.
pub(super) struct Scales {
    pub(super) start_sigma: Vec<f64>,
    pub(super) steps: Vec<f64>,
}

impl Known {
    /// What this model tells.
    pub(super) fn of(model: &Model) -> Self {
        let bases = joint_core::per_unit::Bases::si(&model.motor, &model.stages);
        let reach = model.stages.iter().zip(1..).map(|(stage, number)| {
            let shaft = bases.shaft(number);
            stage.friction.breakaway_nm() / stage.stiffness_nm_per_rad / shaft.abs()
        });
        Self { reach: reach.collect(), motor_count: Record::count_sigma(model, Channel::Motor) }
    }

    /// The scales of a state of that layout along a record.
    pub(super) fn scales(&self, record: &Record, layout: Layout) -> Scales {
        let mut start_sigma = vec![0.0; layout.len()];
        let mut steps = vec![0.0; layout.len() + 1];
        let first = record.grid.interval(0);
        let span = |channel: Channel| {
            let values = record.measured.iter().map(|row: &[f64; CHANNELS]| row[channel as usize]);
            values.filter(|v| v.is_finite()).fold(0.0_f64, |most, v| most.max(v.abs()))
        };
        let turn = self.motor_count.max(record.digit_sigma(Channel::Motor));
        let fastest = speed_scale(record).max(turn / first * 1e-3);
        let current = span(Channel::Current).max(1e-3);
        start_sigma[Layout::CURRENT] = 0.1 * current;
        start_sigma[Layout::ANGLE] = turn;
        steps[Layout::CURRENT] = 1e-6 * current;
        steps[Layout::ANGLE] = 1e-7;
        for (k, reach) in self.reach.iter().enumerate() {
            start_sigma[layout.deflection(k)] = reach.max(1e-9);
            steps[layout.deflection(k)] = (1e-5 * reach).max(1e-11);
        }
        for mass in 0..=layout.stages {
            start_sigma[layout.speed(mass)] = 1e-3 * fastest;
            steps[layout.speed(mass)] = 1e-7 * fastest;
            start_sigma[layout.bristle(mass)] = 0.3;
            steps[layout.bristle(mass)] = 1e-6;
        }
        for slot in 0..layout.memories {
            steps[layout.memory(slot)] = 1e-6;
        }
        let largest = record.drive_values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        steps[layout.len()] = (1e-6 * largest).max(1e-9);
        Scales { start_sigma, steps }
    }
}

/// A speed that the record reaches, rad/s.
pub(super) fn speed_scale(record: &Record) -> f64 {
    let angle = |k: usize| record.measured[k][Channel::Motor as usize];
    let gap = 20.min(record.len() / 2).max(1);
    (gap..record.len())
        .map(|k| (angle(k) - angle(k - gap)).abs() / (record.time_s[k] - record.time_s[k - gap]))
        .filter(|speed| speed.is_finite())
        .fold(0.0, f64::max)
}
