//! `joint score`: how often discovery is right, over logs whose truth is known.

use std::path::PathBuf;

use super::{Common, Failure, Outcome};

/// Run discover over a folder of logs whose truth is known, and score it
///
/// Writes `score.json`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint score --set practice --out scores")]
pub struct Args {
    /// Folder with `truth.json` and a folder a case, each with a log and `nominal.toml`
    #[arg(long, value_name = "DIR")]
    pub set: PathBuf,
    /// Folder for the result
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Runs the verb.
///
/// # Errors
/// Bad input, or a result that may not be overwritten.
pub fn run(_args: &Args, _common: &Common) -> Result<Outcome, Failure> {
    Err(Failure::check("not in this build"))
}
