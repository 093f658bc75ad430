//! `joint completions`: what a shell completes after `joint`.

use clap::ValueEnum;
use clap_complete::{Shell, generate};
use serde_json::json;

use super::{Common, Failure, Outcome};
use crate::cli;

/// Print what a shell needs to complete verbs, flags and their values
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint completions bash > ~/.local/share/bash-completion/completions/joint
  joint completions zsh > ~/.zfunc/_joint
  joint completions fish > ~/.config/fish/completions/joint.fish")]
pub struct Args {
    /// The shell
    #[arg(value_enum)]
    pub shell: Shell,
}

/// Runs the verb.
///
/// # Errors
/// None.
pub fn run(args: &Args, _: &Common) -> Result<Outcome, Failure> {
    let mut script = Vec::new();
    generate(args.shell, &mut cli::command(), "joint", &mut script);
    let script = String::from_utf8_lossy(&script).trim_end().to_owned();
    let shell = args.shell.to_possible_value().map(|value| value.get_name().to_owned());
    Ok(Outcome::done(json!({"shell": shell, "script": script}), script))
}
