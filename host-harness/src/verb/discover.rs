//! `joint discover`: what a model misses, found, named and added.

use std::path::PathBuf;

use super::{Common, Failure, Outcome};

/// Find, name and add what a model misses in logs of the joint
///
/// Writes `verdict.json`, `model.toml`, `report.html` and `residuals.csv`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint discover --model arm.toml --log arm.csv --out found")]
pub struct Args {
    /// Model file
    #[arg(long, value_name = "TOML")]
    pub model: PathBuf,
    /// Logs of the joint
    #[arg(long, value_name = "CSV", required = true, num_args = 1..)]
    pub log: Vec<PathBuf>,
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
