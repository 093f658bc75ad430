//! `joint score`: how often discovery is right, over logs whose truth is known.

use std::path::PathBuf;

use serde_json::json;

use super::discover::{failure, write};
use super::{Common, Failure, Outcome, read_log, read_model};
use crate::discover::discover;
use crate::log::Need;
use crate::output::OutDir;
use crate::score::{Summary, cases, files, row, table};

/// Run discover over a folder of logs whose truth is known, and score it
///
/// Writes `score.json`, and each case's verdict, model, report and residuals in a folder of its
/// own.
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
    /// Only cases of these kinds, and those in which nothing has a name
    #[arg(long, value_name = "KIND", value_delimiter = ',')]
    pub kinds: Vec<String>,
}

/// Runs the verb.
///
/// # Errors
/// Bad input, or a result that may not be overwritten.
pub fn run(args: &Args, common: &Common) -> Result<Outcome, Failure> {
    let cases = cases(&args.set, &args.kinds).map_err(Failure::input)?;
    let out = OutDir::new(&args.out, common.force)?;
    let bar = common.progress(cases.len() as u64, "score");
    let mut rows = Vec::new();
    for case in &cases {
        bar.set_message(case.case.clone());
        let (model, logs) = files(&args.set, case);
        let model = read_model(&model)?;
        let logs: Vec<_> =
            logs.iter().map(|path| read_log(path, Need::Drive)).collect::<Result<_, _>>()?;
        let findings =
            discover(&model, &logs, &indicatif::ProgressBar::hidden()).map_err(failure)?;
        write(&out.folder(&case.case, common.force)?, &findings)?;
        rows.push(row(case, &findings.verdict));
        bar.inc(1);
    }
    bar.finish_and_clear();
    let summary = Summary::of(&rows);
    let json = json!({"cases": rows, "summary": summary});
    let pretty =
        serde_json::to_string_pretty(&json).map_err(|error| Failure::check(error.to_string()))?;
    out.write("score.json", pretty)?;
    Ok(Outcome::done(json, table(&rows, &summary)))
}
