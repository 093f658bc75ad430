//! `joint man`: the manual, a page of roff for the program and one for every verb.

use std::path::PathBuf;

use clap::Command;
use clap_mangen::Man;
use serde_json::json;

use super::{Common, Failure, Outcome};
use crate::cli;
use crate::output::OutDir;

/// Write manual pages, one for the program and one for every verb
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint man --out ~/.local/share/man/man1
  joint man --out man && man man/joint-discover.1")]
pub struct Args {
    /// Folder for the pages
    #[arg(short = 'o', long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Runs the verb.
///
/// # Errors
/// A folder that may not or cannot be written.
pub fn run(args: &Args, common: &Common) -> Result<Outcome, Failure> {
    let out = OutDir::new(&args.out, common.force)?;
    let mut program = cli::command().disable_help_subcommand(true);
    program.build();
    let mut pages = vec![page(&out, "joint", &program)?];
    for verb in program.get_subcommands() {
        pages.push(page(&out, &format!("joint-{}", verb.get_name()), verb)?);
    }
    out.finish()?;
    let text = format!("{}: {} pages", args.out.display(), pages.len());
    Ok(Outcome::done(json!({"out": args.out, "pages": pages}), text))
}

fn page(out: &OutDir, name: &str, command: &Command) -> Result<String, Failure> {
    let mut roff = Vec::new();
    Man::new(command.clone().display_name(name.to_owned()))
        .title(name)
        .render(&mut roff)
        .map_err(|error| Failure::check(error.to_string()))?;
    let file = format!("{name}.1");
    out.write(&file, roff)?;
    Ok(file)
}
