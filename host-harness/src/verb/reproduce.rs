//! `joint reproduce`: the paper's figures and stated numbers beside ours.

use std::path::PathBuf;

use serde_json::json;

use super::{Common, Failure, Outcome};
use crate::output::OutDir;
use crate::reproduce::{self, numbers::Number};
use crate::scenario;

/// The paper's figures 6 to 11 and its stated numbers beside ours
///
/// Writes `reproduce.json`, `claim.json`, one SVG for each figure, with the motor prescribed and
/// with its six-step model, and `reproduce.html` where --out is given.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint reproduce --out paper")]
pub struct Args {
    /// Folder for the result
    #[arg(short = 'o', long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Runs the verb.
///
/// # Errors
/// A result that may not be overwritten, or a run that fails.
pub fn run(args: &Args, common: &Common) -> Result<Outcome, Failure> {
    let out = args.out.as_deref().map(|path| OutDir::new(path, common.force)).transpose()?;
    let bar = common.progress(reproduce::STEPS, "runs");
    let runs = reproduce::run(&scenario::paper(), || bar.inc(1)).map_err(Failure::check)?;
    bar.finish_and_clear();
    let numbers = runs.numbers();
    if let Some(out) = out {
        let text = |value: serde_json::Result<String>| {
            value.map_err(|error| Failure::check(error.to_string()))
        };
        let figures = reproduce::figures(&runs);
        for figure in &figures {
            out.write(&figure.file, figure.picture())?;
        }
        out.write("reproduce.html", reproduce::page(&numbers, &figures))?;
        out.write("claim.json", text(serde_json::to_string_pretty(&runs.claim))?)?;
        out.write("reproduce.json", text(serde_json::to_string_pretty(&numbers))?)?;
        out.finish()?;
    }
    Ok(Outcome::done(json!({ "numbers": numbers, "claim": runs.claim }), table(&numbers)))
}

fn table(numbers: &[Number]) -> String {
    let agree = numbers.iter().filter(|row| row.agrees).count();
    let tuned = numbers.iter().filter(|row| row.tuned).count();
    let mut text =
        format!("{:<9}{:<70}{:>12}{:>11}  agrees\n", "figure", "quantity", "paper", "ours");
    for row in numbers {
        let quantity = match row.unit {
            "1" => row.quantity.clone(),
            unit => format!("{}, {unit}", row.quantity),
        };
        let ours = crate::plot::text::digits(row.ours, 3);
        let agrees = if row.agrees { "yes" } else { "no" };
        let tuned = if row.tuned { " (tuned)" } else { "" };
        text.push_str(&format!(
            "{:<9}{quantity:<70}{:>12}{ours:>11}  {agrees}{tuned}\n",
            row.figure, row.paper
        ));
    }
    text.push_str(&format!("{agree} of {} agree; {tuned} were used to tune\n", numbers.len()));
    for row in numbers.iter().filter(|row| !row.agrees && !row.id.ends_with("six-step")) {
        text.push_str(&format!("{}: {}\n", row.id, row.note));
    }
    text
}
