//! The observer of the control period: current and encoder in, a report out.

use joint_core::observer::{self, Encoder, Track};
use joint_core::params::ParameterError;
use joint_core::telemetry::{Hello, MAX_STAGES, Mode, Quantities, Report, Sample, Status};

use crate::joint::{self, MOTOR_COUNTS, OwnObserver, PERIOD_S, STAGES};

const N: usize = STAGES.len();

/// The observer, and what it remembers of the joint.
#[derive(Debug)]
pub struct Estimator {
    observer: OwnObserver,
    track: Track<f32, N>,
    encoder: Option<Encoder>,
    tick: u32,
}

impl Estimator {
    /// At the start of the program, before the interrupts: double precision is used here and
    /// nowhere else.
    ///
    /// # Errors
    /// Parameters that the equations cannot take.
    pub fn start() -> Result<Self, ParameterError> {
        let observer = joint::observer()?;
        let track = observer.start(0);
        Ok(Self { observer, track, encoder: Encoder::new(MOTOR_COUNTS), tick: 0 })
    }

    /// Every control period: the current now, A, and the encoder's counts since the start. The cost
    /// is the same whatever the data, and nothing in it panics.
    pub fn period(&mut self, current_a: f32, motor_counts: i32) -> Report {
        let seen = observer::Sample {
            drive: current_a,
            current: None,
            motor: self.encoder.map(|encoder| encoder.turn(motor_counts)),
            output: None,
        };
        let health = self.observer.update(&mut self.track, &seen);
        let estimate = self.observer.estimate(&self.track);
        let report = Report {
            tick: self.tick,
            status: Status::default(),
            health: health.bits(),
            stages: N as u8,
            sample: Sample { current_a, motor_counts, ..Sample::default() },
            estimates: Quantities::of(&estimate),
            deviations: Quantities::deviations_of(&estimate),
        };
        self.tick = self.tick.wrapping_add(1);
        report
    }
}

/// What `joint monitor` must know of this firmware before it can read a report: the first message.
pub const HELLO: Hello = {
    assert!(N <= MAX_STAGES, "a report tells of so many stages");
    Hello {
        mode: Mode::Parameters,
        refusal: 0,
        stages: N as u8,
        block_version: 0,
        parameters_crc: joint::BLOCK_CRC,
        sample_time_s: PERIOD_S as f32,
        motor_counts_per_turn: MOTOR_COUNTS as u32,
        output_counts_per_turn: 0,
        capture_samples: 0,
    }
};
