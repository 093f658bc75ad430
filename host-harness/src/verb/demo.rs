//! `joint demo`: the main job with no input.

use std::path::PathBuf;

use serde_json::json;

use super::discover::{failure, summary, write};
use super::{Common, Failure, Outcome};
use crate::demo::riddle;
use crate::discover::discover;
use crate::output::OutDir;
use crate::report::{Source, quoted};

/// Hide an effect in built-in data, find, name and add it, and write the report
///
/// Needs no input.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint demo --seed 7")]
pub struct Args {
    /// Which effect is hidden and which noise is drawn; a random one where left out
    #[arg(short = 's', long, value_name = "N")]
    pub seed: Option<u64>,
    /// Folder for the result
    #[arg(short = 'o', long, value_name = "DIR", default_value = "joint-demo")]
    pub out: PathBuf,
}

/// Runs the verb.
///
/// # Errors
/// A result that may not be overwritten.
pub fn run(args: &Args, common: &Common) -> Result<Outcome, Failure> {
    let out = OutDir::new(&args.out, common.force)?;
    let seed = args.seed.unwrap_or_else(|| rand::random_range(0..10_000));
    let bar = common.progress(0, "the joint runs, with something hidden in it");
    let riddle = riddle(seed).map_err(|error| Failure::check(error.to_string()))?;
    bar.finish_and_clear();
    let bar = common.progress(0, "reading the log");
    let findings =
        discover(&riddle.nominal, std::slice::from_ref(&riddle.log), &bar).map_err(failure)?;
    bar.finish_and_clear();
    let log = out.write("log.csv", riddle.log.to_csv())?;
    let nominal = out.write("nominal.toml", riddle.nominal.to_toml())?;
    let command = format!("joint demo --seed {seed} --out {}", quoted(&args.out));
    let source = Source::new(command, &nominal, &[log], &out);
    write(&out, &findings, std::slice::from_ref(&riddle.log), &source)?;
    let report = out.path().join("report.html");
    out.finish()?;

    let hidden = format!("{} ({})", riddle.hidden.kind.spec().kind, riddle.hidden.location);
    let found = findings.verdict.effects.first();
    let right = found.is_some_and(|named| {
        named.kind == riddle.hidden.kind.spec().kind
            && named.location == riddle.hidden.location.to_string()
    });
    let gap = &findings.verdict.gap;
    let text = format!(
        "seed {seed}: a joint was simulated by the reference with something hidden in it, and discovery was given the log and a nominal model that is wrong in every parameter.\n\n{}\n\nhidden was: {hidden}; {}\ngap: {:.2} before, {:.2} after, {:.2} is noise\nreport: {}",
        summary(&findings),
        if right { "named rightly" } else { "NOT named rightly" },
        gap.before,
        gap.after,
        gap.floor,
        report.display(),
    );
    let json = json!({
        "seed": seed,
        "hidden": {"kind": riddle.hidden.kind.spec().kind, "location": riddle.hidden.location.to_string()},
        "named_rightly": right,
        "verdict": findings.verdict,
        "report": report,
    });
    Ok(Outcome { json, text, passed: right })
}
