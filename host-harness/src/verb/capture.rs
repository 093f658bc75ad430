//! `joint capture`: raw samples at the full control rate, around a trigger.

use std::path::PathBuf;

use clap::ValueEnum;
use joint_core::telemetry::{Status, Trigger};
use serde_json::json;

use super::{Common, Failure, Outcome};
use crate::log::write_columns;

/// Arm a drive's capture ring and fetch it, or read a recorded stream
///
/// The log that is written is one for `identify` and `discover`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint capture --stream frames.bin --out capture.csv
  joint capture --connect localhost:9090 --trigger reversal --after 256 --out capture.csv")]
pub struct Args {
    /// The drive, or what it has sent
    #[command(flatten)]
    pub source: super::drive::Source,
    /// What starts it
    #[arg(long, value_enum, default_value_t = Start::Now)]
    pub trigger: Start,
    /// Current that starts it, A, for the trigger `current`
    #[arg(long, value_name = "A", default_value_t = 1.0, value_parser = super::positive)]
    pub above_a: f64,
    /// Samples from the trigger on
    #[arg(long, value_name = "N", default_value_t = 512)]
    pub after: u32,
    /// How long to wait for the trigger
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = super::positive)]
    pub seconds: f64,
    /// Log to write, compressed where it ends in .gz; - is standard output
    #[arg(short = 'o', long, value_name = "CSV")]
    pub out: PathBuf,
}

/// What starts a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Start {
    /// At once
    Now,
    /// The current passes a magnitude
    Current,
    /// The rotor changes its direction
    Reversal,
    /// The drive raises a flag
    Fault,
}

impl Args {
    fn trigger(&self) -> Trigger {
        match self.trigger {
            Start::Now => Trigger::Now,
            Start::Current => Trigger::CurrentAbove(self.above_a as f32),
            Start::Reversal => Trigger::Reversal,
            Start::Fault => Trigger::Status(Status(!(Status::DEFAULTS.0 | Status::OUTPUT_ON.0))),
        }
    }
}

/// Runs the verb.
///
/// # Errors
/// A stream that cannot be read or holds no whole capture, or a log that cannot be written.
pub fn run(args: &Args, common: &Common) -> Result<Outcome, Failure> {
    let out = common.file(&args.out)?;
    let recording = args.source.capture(args.trigger(), args.after, args.seconds)?;
    let columns = recording.capture().ok_or_else(|| args.source.silent())?;
    if recording.capture_is_whole() != Some(true) {
        return Err(Failure::check(
            "the capture has gaps: frames were lost\n  help: fetch it again",
        ));
    }
    let samples = columns.first().map_or(0, |(_, values)| values.len());
    let trigger_at = recording.capture_head().map_or(0, |head| head.trigger_at);
    let text = write_columns(&columns);
    let path = out.write_table(text)?;
    let json = json!({"out": path, "samples": samples, "trigger_at": trigger_at});
    let text = format!("{}: {samples} samples, the trigger is number {trigger_at}", path.display());
    Ok(Outcome::done(json, text))
}
