//! `joint identify`: the parameters of a model, refitted to a log.

use std::path::PathBuf;

use super::{Common, Failure, Outcome};

/// Refit a model to a log, with standard errors and what the log cannot determine
///
/// Writes `model.toml` and `identify.json`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint identify --model arm.toml --log arm.csv --out refit")]
pub struct Args {
    /// Model file
    #[arg(long, value_name = "TOML")]
    pub model: PathBuf,
    /// Log to refit on
    #[arg(long, value_name = "CSV")]
    pub log: PathBuf,
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
