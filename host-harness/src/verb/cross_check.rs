//! `joint cross-check`: the embedded method against the reference.

use std::path::PathBuf;

use super::{Common, Failure, Outcome};

/// Check f32 in the embedded method against the f64 reference on every scenario
///
/// Writes `cross-check.json` and plots where --out is given; exit 1 where a stated bound is broken.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint cross-check --out check")]
pub struct Args {
    /// Folder for the result
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Runs the verb.
///
/// # Errors
/// Bad input, or a result that may not be overwritten.
pub fn run(_args: &Args, _common: &Common) -> Result<Outcome, Failure> {
    Err(Failure::check("not in this build"))
}
