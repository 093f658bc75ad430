//! One control period: a measurement in, a report out.
//!
//! This is all that the control interrupt runs, on every board, in the emulator and on the host;
//! it asks no register and keeps no time. What is wrong with a measurement is found here, flagged,
//! and kept out of the joint's state: a drive that estimates from a broken sensor must say so and
//! go on.

use joint_core::joint::State;
use joint_core::telemetry::{Quantities, Report, Sample, Status};

use crate::parameters::{DriveJoint, Parameters, Sensing};

/// Share of a turn that the model may move while the encoder shows nothing.
const STUCK_TURNS: f32 = 0.125;

/// The joint of `N` stages as it runs in the drive.
#[derive(Debug)]
pub struct Control<const N: usize> {
    joint: DriveJoint<N>,
    sensing: Sensing,
    current_imposed: bool,
    standing: Status,
    state: State<f32, N>,
    tick: u32,
    last: Option<Sample>,
    moved_turns: f32,
}

impl<const N: usize> Control<N> {
    /// The joint at rest; `standing` is set in every report.
    pub fn new(parameters: Parameters<N>, standing: Status) -> Self {
        let Parameters { joint, sensing } = parameters;
        let state = joint.rest();
        let current_imposed = joint.is_current_imposed();
        let (tick, last, moved_turns) = (0, None, 0.0);
        Self { joint, sensing, current_imposed, standing, state, tick, last, moved_turns }
    }

    /// The sensors.
    pub fn sensing(&self) -> &Sensing {
        &self.sensing
    }

    /// Advances by one control period; `missed` were lost before it.
    #[inline]
    pub fn tick(&mut self, sample: Sample, missed: u32) -> Report {
        let mut status = self.standing;
        let sample = self.plausible(sample, &mut status);
        if missed > 0 {
            status = status.with(Status::LATE);
        }
        let drive = if self.current_imposed { sample.current_a } else { sample.voltage_v };
        self.joint.step(&mut self.state, self.joint.input(drive, 0.0));
        if !self.is_finite() {
            self.state = self.joint.rest();
            status = status.with(Status::RESTARTED);
        }
        if self.is_stuck(sample) {
            status = status.with(Status::ENCODER_STUCK);
        }
        self.last = Some(sample);
        self.tick = self.tick.wrapping_add(missed);
        let report = Report {
            tick: self.tick,
            status,
            stages: N as u8,
            sample,
            estimates: self.estimates(),
            deviations: Quantities::default(),
        };
        self.tick = self.tick.wrapping_add(1);
        report
    }

    /// The sample with what no sensor can show replaced by the last good value.
    fn plausible(&self, mut sample: Sample, status: &mut Status) -> Sample {
        let last = self.last.unwrap_or_default();
        // What is no number is within no limit.
        let within = |value: f32, limit: f32| value.abs() <= limit;
        if !within(sample.voltage_v, self.sensing.largest_voltage_v) {
            sample.voltage_v = last.voltage_v;
            *status = status.with(Status::MEASUREMENT);
        }
        if !within(sample.current_a, self.sensing.largest_current_a) {
            sample.current_a = last.current_a;
            *status = status.with(Status::MEASUREMENT);
        }
        if let Some(last) = self.last {
            let moved = sample.motor_counts.wrapping_sub(last.motor_counts).unsigned_abs();
            if moved > self.sensing.largest_move_counts {
                *status = status.with(Status::ENCODER_JUMP);
            }
        }
        sample
    }

    fn is_finite(&self) -> bool {
        let State { current, angle, rotor, stages, .. } = &self.state;
        let mut sum =
            current.abs() + angle.part.abs() + rotor.speed.abs() + rotor.bristle.zeta.abs();
        for stage in stages {
            sum += stage.deflection.abs() + stage.mass.speed.abs() + stage.mass.bristle.zeta.abs();
        }
        sum.is_finite()
    }

    /// Whether the model has moved on while the encoder stood still.
    fn is_stuck(&mut self, sample: Sample) -> bool {
        let stands = self.last.is_some_and(|last| last.motor_counts == sample.motor_counts);
        if stands {
            let turns_per_s = self.joint.speed(&self.state, 0) * core::f32::consts::FRAC_1_PI * 0.5;
            self.moved_turns += turns_per_s * self.sensing.sample_time_s;
        } else {
            self.moved_turns = 0.0;
        }
        self.moved_turns.abs() > STUCK_TURNS
    }

    /// As measured, or from the motor's where there is no output encoder.
    fn output_angle(&self) -> f32 {
        let sample = self.last.unwrap_or_default();
        let turn = |counts: i32, per_turn: u32| {
            core::f32::consts::TAU * (counts as f32 / per_turn.max(1) as f32)
        };
        match self.sensing.output_counts_per_turn {
            0 => {
                let motor = turn(sample.motor_counts, self.sensing.motor_counts_per_turn);
                self.joint.output_angle(&self.state, motor)
            }
            per_turn => turn(sample.output_counts, per_turn),
        }
    }

    fn estimates(&self) -> Quantities {
        let (joint, state) = (&self.joint, &self.state);
        let mut windup_rad = [0.0; 3];
        for (k, windup) in windup_rad.iter_mut().enumerate() {
            *windup = joint.windup(state, k);
        }
        Quantities {
            motor_velocity_rad_per_s: joint.speed(state, 0),
            total_friction_at_motor_nm: joint.total_friction_at_motor(state),
            output_angle_rad: self.output_angle(),
            output_velocity_rad_per_s: joint.output_velocity(state),
            load_torque_nm: 0.0,
            windup_rad,
        }
    }
}
