//! A drive in operation: control, commands, telemetry and capture, as the control interrupt runs
//! them.
//!
//! The interrupt owns all of it; the task that talks to the outside sees two queues only, commands
//! in and messages out. So nothing is locked, the control period never waits, and what does not fit
//! into the queue is dropped and counted.

use joint_core::telemetry::capture::Capture;
use joint_core::telemetry::{Command, Hello, Message, Mode, Report, Sample, Status};

use crate::any_control::AnyControl;
use crate::block::{Block, BlockError};
use crate::link::Messages;
use crate::parameters::Sensing;

/// Samples in the capture ring: 26 ms at 20 kHz, and a quarter of the RAM.
pub const CAPTURE_SAMPLES: usize = 512;
/// Control periods between two reports until a command changes it: 1 kHz at 20 kHz.
pub const DEFAULT_RATE: u16 = 20;

/// The joint that a drive without parameters listens with: a small motor without gear, of a
/// resistance, inertia and friction that are those of no one in particular. `tests/tests/block.rs`
/// says what it is and that these bytes are it.
const DEFAULT_BLOCK: &[u8] = include_bytes!("default.block");

/// A drive in operation. It is large, and lives in a static: before it is started it is all zeros.
#[derive(Debug)]
pub struct Session {
    joint: AnyControl,
    hello: Hello,
    capture: Capture<CAPTURE_SAMPLES>,
    every: u16,
    since: u16,
    hello_due: bool,
    dropped: u32,
    dropped_told: u32,
}

impl Default for Session {
    fn default() -> Self {
        Self::new()
    }
}

impl Session {
    /// A drive that is still to be started.
    pub const fn new() -> Self {
        Self {
            joint: AnyControl::NotStarted,
            hello: Hello {
                mode: Mode::Defaults,
                refusal: 0,
                stages: 0,
                block_version: 0,
                parameters_crc: 0,
                sample_time_s: 0.0,
                motor_counts_per_turn: 0,
                output_counts_per_turn: 0,
                capture_samples: 0,
            },
            capture: Capture::new(),
            every: 0,
            since: 0,
            hello_due: false,
            dropped: 0,
            dropped_told: 0,
        }
    }

    /// Starts with the parameters in this flash page, or, where they are refused, with the
    /// documented defaults, in listen-only; the refusal is given back, to be told.
    ///
    /// # Errors
    /// The default block itself is refused: a program that was built wrongly.
    pub fn start(&mut self, page: &[u8]) -> Result<Option<BlockError>, BlockError> {
        let own = Block::in_page(page).and_then(|block| {
            self.joint.read(&block, Status::default())?;
            Ok(block)
        });
        let (block, mode, refusal) = match own {
            Ok(block) => (block, Mode::Parameters, None),
            Err(refusal) => {
                let block = Block::check(DEFAULT_BLOCK)?;
                self.joint.read(&block, Status::DEFAULTS)?;
                (block, Mode::Defaults, Some(refusal))
            }
        };
        let sensing = self.joint.sensing();
        self.hello = Hello {
            mode,
            refusal: refusal.map_or(0, |refusal| refusal.code()),
            stages: block.stages,
            block_version: block.version,
            parameters_crc: block.crc,
            sample_time_s: sensing.sample_time_s,
            motor_counts_per_turn: sensing.motor_counts_per_turn,
            output_counts_per_turn: sensing.output_counts_per_turn,
            capture_samples: CAPTURE_SAMPLES as u32,
        };
        (self.every, self.since) = (DEFAULT_RATE, 0);
        self.hello_due = true;
        Ok(refusal)
    }

    /// What this drive says of itself.
    pub fn hello(&self) -> &Hello {
        &self.hello
    }

    /// The drive's sensors.
    pub fn sensing(&self) -> Sensing {
        self.joint.sensing()
    }

    /// Carries out a command; [`Command::Duty`] is the output stage's and not taken here.
    pub fn command(&mut self, command: Command) {
        match command {
            Command::Hello => self.hello_due = true,
            Command::Rate(every) => {
                self.every = every;
                self.since = 0;
            }
            Command::Arm { trigger, after } => self.capture.arm(trigger, after),
            Command::Disarm => self.capture.disarm(),
            Command::Fetch => self.capture.fetch(),
            // The output stage's own.
            _ => {}
        }
    }

    /// One control period: `missed` were lost before it, `flags` are the board's own. At most one
    /// message goes out.
    #[inline]
    pub fn tick(&mut self, sample: Sample, missed: u32, flags: Status, out: &Messages) -> Report {
        let mut report = self.joint.tick(sample, missed);
        report.status = report.status.with(flags);
        self.capture.take(&report);
        self.since = self.since.saturating_add(1);
        if self.every != 0 && self.since >= self.every {
            self.since = 0;
            if out.enqueue(Message::Report(report)).is_err() {
                self.dropped = self.dropped.wrapping_add(1);
            }
        } else {
            self.send_other(out);
        }
        report
    }

    /// What is less urgent than a report, as far as there is room.
    fn send_other(&mut self, out: &Messages) {
        if self.hello_due {
            self.hello_due = out.enqueue(Message::Hello(self.hello)).is_err();
        } else if self.dropped != self.dropped_told {
            if out.enqueue(Message::Dropped(self.dropped)).is_ok() {
                self.dropped_told = self.dropped;
            }
        } else if let Some(part) = self.capture.pending()
            && out.enqueue(part).is_ok()
        {
            self.capture.sent();
        }
    }
}
