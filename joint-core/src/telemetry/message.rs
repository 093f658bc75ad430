//! The messages: what they hold, and their bytes.
//!
//! Payloads are little-endian and of fixed layout, so that a reader in any language is a page of
//! code; docs/firmware.md has the table.

use core::f32::consts::TAU;

use heapless::Vec;

use super::frame::{Get, Put};
use crate::observer::Estimate;

/// Most gear stages that a report tells of.
pub const MAX_STAGES: usize = 3;
/// Most samples in one message.
pub const MAX_SAMPLES: usize = 12;

/// What the drive measured in one control period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sample {
    /// DC-equivalent voltage on the two conducting phases, V, held until the next sample.
    pub voltage_v: f32,
    /// Motor current, A.
    pub current_a: f32,
    /// Counts of the motor encoder since the start, over all turns.
    pub motor_counts: i32,
    /// Counts of the output encoder since the start; zero where there is none.
    pub output_counts: i32,
}

/// Bytes of a sample.
pub(crate) const SAMPLE_BYTES: usize = 16;

impl Sample {
    /// As it stands in a message: voltage, current, motor counts, output counts.
    pub fn to_bytes(self) -> [u8; SAMPLE_BYTES] {
        let mut bytes = [0; SAMPLE_BYTES];
        let mut put = Put::new(&mut bytes);
        self.put(&mut put);
        bytes
    }

    /// From a message.
    pub fn from_bytes(bytes: &[u8; SAMPLE_BYTES]) -> Self {
        Self::get(&mut Get::new(bytes)).unwrap_or_default()
    }

    fn put(&self, put: &mut Put<'_>) {
        put.f32(self.voltage_v);
        put.f32(self.current_a);
        put.i32(self.motor_counts);
        put.i32(self.output_counts);
    }

    fn get(get: &mut Get<'_>) -> Option<Self> {
        Some(Self {
            voltage_v: get.f32()?,
            current_a: get.f32()?,
            motor_counts: get.i32()?,
            output_counts: get.i32()?,
        })
    }
}

/// What is wrong or special in a control period: a set of the constants below.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Status(pub u16);

impl Status {
    /// No parameters were accepted: estimates are those of the documented default joint.
    pub const DEFAULTS: Self = Self(1 << 0);
    /// A measurement was no number, or beyond what its sensor can show, and was left out.
    pub const MEASUREMENT: Self = Self(1 << 1);
    /// The motor encoder moved further than the joint can in one period.
    pub const ENCODER_JUMP: Self = Self(1 << 2);
    /// Control periods were missed before this one.
    pub const LATE: Self = Self(1 << 3);
    /// The output stage is enabled.
    pub const OUTPUT_ON: Self = Self(1 << 4);

    /// Every flag with its name, in the order of the bits.
    pub const NAMES: [(Self, &'static str); 5] = [
        (Self::DEFAULTS, "defaults"),
        (Self::MEASUREMENT, "measurement"),
        (Self::ENCODER_JUMP, "encoder-jump"),
        (Self::LATE, "late"),
        (Self::OUTPUT_ON, "output-on"),
    ];

    /// Both together.
    #[must_use]
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether it shares a flag with the other.
    pub const fn meets(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }
}

/// Estimated quantities, or their standard deviations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quantities {
    /// Rotor speed, rad/s.
    pub motor_velocity_rad_per_s: f32,
    /// Friction of all masses, felt at the motor, Nm, positive against positive motion.
    pub total_friction_at_motor_nm: f32,
    /// Angle behind the last stage, rad.
    pub output_angle_rad: f32,
    /// Speed behind the last stage, rad/s.
    pub output_velocity_rad_per_s: f32,
    /// Load torque at the output, Nm, positive against positive motion.
    pub load_torque_nm: f32,
    /// Deflection of each stage's spring at its output, rad; zero where there is no such stage.
    pub windup_rad: [f32; MAX_STAGES],
}

impl Quantities {
    /// Those of an observer's estimate; stages past [`MAX_STAGES`] are left out.
    pub fn of<const N: usize>(estimate: &Estimate<f32, N>) -> Self {
        Self {
            motor_velocity_rad_per_s: estimate.motor_velocity,
            total_friction_at_motor_nm: estimate.total_friction,
            output_angle_rad: TAU * (estimate.output_turns as f32 + estimate.output_part),
            output_velocity_rad_per_s: estimate.output_velocity,
            load_torque_nm: estimate.load,
            windup_rad: by_stage(&estimate.windup),
        }
    }

    /// One standard deviation of each.
    pub fn deviations_of<const N: usize>(estimate: &Estimate<f32, N>) -> Self {
        let spread = &estimate.spread;
        Self {
            motor_velocity_rad_per_s: spread.motor_velocity,
            total_friction_at_motor_nm: spread.total_friction,
            output_angle_rad: spread.output_angle,
            output_velocity_rad_per_s: spread.output_velocity,
            load_torque_nm: spread.load,
            windup_rad: by_stage(&spread.windup),
        }
    }

    fn put(&self, stages: usize, put: &mut Put<'_>) {
        put.f32(self.motor_velocity_rad_per_s);
        put.f32(self.total_friction_at_motor_nm);
        put.f32(self.output_angle_rad);
        put.f32(self.output_velocity_rad_per_s);
        put.f32(self.load_torque_nm);
        for windup in self.windup_rad.iter().take(stages) {
            put.f32(*windup);
        }
    }

    fn get(stages: usize, get: &mut Get<'_>) -> Option<Self> {
        let mut own = Self {
            motor_velocity_rad_per_s: get.f32()?,
            total_friction_at_motor_nm: get.f32()?,
            output_angle_rad: get.f32()?,
            output_velocity_rad_per_s: get.f32()?,
            load_torque_nm: get.f32()?,
            windup_rad: [0.0; MAX_STAGES],
        };
        for windup in own.windup_rad.iter_mut().take(stages) {
            *windup = get.f32()?;
        }
        Some(own)
    }
}

fn by_stage<const N: usize>(own: &[f32; N]) -> [f32; MAX_STAGES] {
    let mut all = [0.0; MAX_STAGES];
    all.iter_mut().zip(own).for_each(|(to, from)| *to = *from);
    all
}

/// One control period: what was measured and what is estimated from it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Control periods since the start; wraps.
    pub tick: u32,
    /// What is wrong or special.
    pub status: Status,
    /// What the observer says of itself: the bits of [`crate::observer::Status`].
    pub health: u16,
    /// Gear stages of the joint.
    pub stages: u8,
    /// The measurement.
    pub sample: Sample,
    /// The estimates.
    pub estimates: Quantities,
    /// One standard deviation of each.
    pub deviations: Quantities,
}

/// Whether the drive trusts its parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// It only listens, with the documented defaults.
    #[default]
    Defaults,
    /// It runs the joint of its parameter block.
    Parameters,
}

/// Who is speaking: sent at the start and when asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hello {
    /// Whether the parameters were accepted.
    pub mode: Mode,
    /// Why they were not: a code of the firmware's, zero where they were.
    pub refusal: u8,
    /// Gear stages of the joint.
    pub stages: u8,
    /// Version of the parameter block as it stands in flash, before a migration.
    pub block_version: u16,
    /// Checksum of the accepted parameter block.
    pub parameters_crc: u32,
    /// Control period, s.
    pub sample_time_s: f32,
    /// Counts per turn of the motor encoder.
    pub motor_counts_per_turn: u32,
    /// Counts per turn of the output encoder, zero where there is none.
    pub output_counts_per_turn: u32,
    /// Samples that the capture ring holds.
    pub capture_samples: u32,
}

/// What comes before the samples of a capture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CaptureHead {
    /// Number of samples that follow.
    pub samples: u32,
    /// Which of them triggered, from 0.
    pub trigger_at: u32,
    /// Tick of the first of them.
    pub first_tick: u32,
}

/// What starts a capture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Trigger {
    /// The next sample.
    #[default]
    Now,
    /// The current's magnitude passes this, A.
    CurrentAbove(f32),
    /// One of these flags is set.
    Status(Status),
    /// The estimated rotor speed changes its sign.
    Reversal,
}

/// What the host asks of the drive.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Command {
    /// Say hello.
    Hello,
    /// Report every so many control periods; zero reports nothing.
    Rate(u16),
    /// Capture around a trigger, with that many samples from the trigger on.
    Arm {
        /// What starts it.
        trigger: Trigger,
        /// Samples from the trigger on.
        after: u32,
    },
    /// Send the capture once it is complete.
    Fetch,
    /// Forget the capture.
    Disarm,
    /// Put this share of the bus voltage on the motor, −1 to 1; understood only by firmware built
    /// with an output stage, and to be repeated before its watchdog lets go.
    Duty(f32),
}

/// Everything that a frame can hold.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Message {
    /// Who is speaking.
    Hello(Hello),
    /// One control period.
    Report(Report),
    /// The start of a captured record.
    CaptureHead(CaptureHead),
    /// Part of a captured record: the place of the first sample in it, and the samples.
    Samples(u32, Vec<Sample, MAX_SAMPLES>),
    /// Messages that the sender had to drop since the start.
    Dropped(u32),
    /// From the host to the drive.
    Command(Command),
}

impl Message {
    /// The kind that stands in the frame.
    pub(super) fn kind(&self) -> u8 {
        match self {
            Message::Hello(_) => 1,
            Message::Report(_) => 2,
            Message::CaptureHead(_) => 3,
            Message::Samples(..) => 4,
            Message::Dropped(_) => 5,
            Message::Command(_) => 16,
        }
    }

    pub(super) fn put(&self, put: &mut Put<'_>) {
        match self {
            Message::Hello(hello) => {
                put.u8(match hello.mode {
                    Mode::Defaults => 0,
                    Mode::Parameters => 1,
                });
                put.u8(hello.refusal);
                put.u8(hello.stages);
                put.u8(0);
                put.u16(hello.block_version);
                put.u16(0);
                put.u32(hello.parameters_crc);
                put.f32(hello.sample_time_s);
                put.u32(hello.motor_counts_per_turn);
                put.u32(hello.output_counts_per_turn);
                put.u32(hello.capture_samples);
            }
            Message::Report(report) => {
                let stages = usize::from(report.stages).min(MAX_STAGES);
                put.u32(report.tick);
                put.u16(report.status.0);
                put.u16(report.health);
                put.u32(stages as u32);
                report.sample.put(put);
                report.estimates.put(stages, put);
                report.deviations.put(stages, put);
            }
            Message::CaptureHead(head) => {
                put.u32(head.samples);
                put.u32(head.trigger_at);
                put.u32(head.first_tick);
            }
            Message::Samples(first, samples) => {
                put.u32(*first);
                for sample in samples {
                    sample.put(put);
                }
            }
            Message::Dropped(count) => put.u32(*count),
            Message::Command(command) => command.put(put),
        }
    }

    pub(super) fn get(kind: u8, get: &mut Get<'_>) -> Option<Self> {
        Some(match kind {
            1 => Message::Hello(hello(get)?),
            2 => Message::Report(report(get)?),
            3 => Message::CaptureHead(CaptureHead {
                samples: get.u32()?,
                trigger_at: get.u32()?,
                first_tick: get.u32()?,
            }),
            4 => {
                let first = get.u32()?;
                let mut samples = Vec::new();
                while !get.is_empty() {
                    samples.push(Sample::get(get)?).ok()?;
                }
                Message::Samples(first, samples)
            }
            5 => Message::Dropped(get.u32()?),
            16 => Message::Command(Command::get(get)?),
            _ => return None,
        })
    }
}

fn hello(get: &mut Get<'_>) -> Option<Hello> {
    let mode = match get.u8()? {
        0 => Mode::Defaults,
        1 => Mode::Parameters,
        _ => return None,
    };
    let (refusal, stages, _) = (get.u8()?, get.u8()?, get.u8()?);
    let (block_version, _) = (get.u16()?, get.u16()?);
    Some(Hello {
        mode,
        refusal,
        stages,
        block_version,
        parameters_crc: get.u32()?,
        sample_time_s: get.f32()?,
        motor_counts_per_turn: get.u32()?,
        output_counts_per_turn: get.u32()?,
        capture_samples: get.u32()?,
    })
}

fn report(get: &mut Get<'_>) -> Option<Report> {
    let (tick, status, health) = (get.u32()?, Status(get.u16()?), get.u16()?);
    let stages = get.u32()?;
    let count = stages as usize;
    if count > MAX_STAGES {
        return None;
    }
    Some(Report {
        tick,
        status,
        health,
        stages: stages as u8,
        sample: Sample::get(get)?,
        estimates: Quantities::get(count, get)?,
        deviations: Quantities::get(count, get)?,
    })
}

impl Command {
    fn put(&self, put: &mut Put<'_>) {
        match self {
            Command::Hello => put.u8(0),
            Command::Rate(every) => {
                put.u8(1);
                put.u16(*every);
            }
            Command::Arm { trigger, after } => {
                put.u8(2);
                put.u32(*after);
                match trigger {
                    Trigger::Now => put.u8(0),
                    Trigger::CurrentAbove(amperes) => {
                        put.u8(1);
                        put.f32(*amperes);
                    }
                    Trigger::Status(mask) => {
                        put.u8(2);
                        put.u16(mask.0);
                    }
                    Trigger::Reversal => put.u8(3),
                }
            }
            Command::Fetch => put.u8(3),
            Command::Disarm => put.u8(4),
            Command::Duty(duty) => {
                put.u8(5);
                put.f32(*duty);
            }
        }
    }

    fn get(get: &mut Get<'_>) -> Option<Self> {
        Some(match get.u8()? {
            0 => Command::Hello,
            1 => Command::Rate(get.u16()?),
            2 => {
                let after = get.u32()?;
                let trigger = match get.u8()? {
                    0 => Trigger::Now,
                    1 => Trigger::CurrentAbove(get.f32()?),
                    2 => Trigger::Status(Status(get.u16()?)),
                    3 => Trigger::Reversal,
                    _ => return None,
                };
                Command::Arm { trigger, after }
            }
            3 => Command::Fetch,
            4 => Command::Disarm,
            5 => Command::Duty(get.f32()?),
            _ => return None,
        })
    }
}
