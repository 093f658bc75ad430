//! `joint monitor`: a drive's telemetry, as it comes and as a log.

use std::path::PathBuf;

use serde_json::json;

use super::{Common, Failure, Outcome};
use crate::log::write_columns;
use crate::probe::Recording;
use crate::probe::recording::greeting;

/// Read a drive's telemetry: live from a debug server, or from a recorded stream
///
/// The log has what was measured and what was estimated; `identify` and `discover` read it.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint monitor --stream frames.bin --out run.csv
  joint monitor --connect localhost:9090 --every 20 --seconds 10 --out run.csv")]
pub struct Args {
    /// The drive, or what it has sent
    #[command(flatten)]
    pub source: super::drive::Source,
    /// Control periods between two reports
    #[arg(long, value_name = "N", default_value_t = 20)]
    pub every: u16,
    /// How long to listen
    #[arg(long, value_name = "S", default_value_t = 10.0, value_parser = super::positive)]
    pub seconds: f64,
    /// Log to write, compressed where it ends in .gz; - is standard output
    #[arg(short = 'o', long, value_name = "CSV")]
    pub out: Option<PathBuf>,
}

/// Runs the verb.
///
/// # Errors
/// A stream that cannot be read or holds no drive's telemetry, or a log that cannot be written.
pub fn run(args: &Args, common: &Common) -> Result<Outcome, Failure> {
    let out = args.out.as_ref().map(|path| common.file(path)).transpose()?;
    let recording = args.source.monitor(args.every, args.seconds)?;
    let columns = recording.log().ok_or_else(|| args.source.silent())?;
    let hello = recording.hello.map(|hello| greeting(&hello)).unwrap_or_default();
    let path = out.map(|out| out.write_table(write_columns(&columns))).transpose()?;
    let json = json!({
        "out": path,
        "reports": recording.reports.len(),
        "lost_frames": recording.lost,
        "dropped_by_drive": recording.dropped,
        "skipped_bytes": recording.skipped(),
    });
    Ok(Outcome::done(json, text(&recording, &hello)))
}

fn text(recording: &Recording, hello: &str) -> String {
    format!(
        "{hello}\n{}\n{} reports, {} frames lost, {} messages dropped by the drive, {} bytes skipped",
        recording.line(),
        recording.reports.len(),
        recording.lost,
        recording.dropped,
        recording.skipped()
    )
}
