//! `joint demo`: the main job with no input.

use std::path::PathBuf;

use super::{Common, Failure, Outcome};

/// Hide an effect in built-in data, find, name and add it, and write the report
///
/// Needs no input.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint demo --seed 7")]
pub struct Args {
    /// Which effect is hidden and which noise is drawn; a random one where left out
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Folder for the result
    #[arg(long, value_name = "DIR", default_value = "joint-demo")]
    pub out: PathBuf,
}

/// Runs the verb.
///
/// # Errors
/// Bad input, or a result that may not be overwritten.
pub fn run(_args: &Args, _common: &Common) -> Result<Outcome, Failure> {
    Err(Failure::check("not in this build"))
}
