//! `joint identify`: the parameters of a model, refitted to a log.

use std::fmt::Write as _;
use std::path::PathBuf;

use super::load::read_checked;
use super::{Common, Failure, Outcome, read_model};
use crate::discover::DiscoverError;
use crate::identify::{Criterion, Identified, identified};
use crate::output::OutDir;
use crate::preflight::LEAST_SAMPLES;
use crate::report::{Source, quoted};

/// Refit a model to logs, with standard errors and what the logs cannot determine
///
/// Several logs are of one joint and share its parameters. Writes `model.toml`, `identify.json` and `report.html`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint identify --model arm.toml --log arm.csv --out refit")]
pub struct Args {
    /// Model file
    #[arg(short = 'm', long, value_name = "TOML")]
    pub model: PathBuf,
    /// Logs to refit on; - is standard input
    #[arg(short = 'l', long, value_name = "CSV", required = true, num_args = 1..)]
    pub log: Vec<PathBuf>,
    /// Folder for the result
    #[arg(short = 'o', long, value_name = "DIR")]
    pub out: PathBuf,
    /// What is made smallest
    #[arg(long, value_enum, default_value_t = Criterion::Prediction)]
    pub criterion: Criterion,
    /// Length of the windows of a refit by simulation, s
    #[arg(long, value_name = "S", default_value_t = 1.0, value_parser = window)]
    pub window_s: f64,
    /// Go on where log and model cannot both be right (see `joint check`)
    #[arg(long)]
    pub anyway: bool,
}

/// Runs the verb.
///
/// # Errors
/// Bad input, or a result that may not be overwritten.
pub fn run(args: &Args, common: &Common) -> Result<Outcome, Failure> {
    let files = ["model.toml", "identify.json", "report.html"];
    let out = OutDir::new(&args.out, common.force)?
        .apart_from(args.log.iter().chain([&args.model]), &files)?;
    let model = read_model(&args.model)?;
    let checked = |path: &PathBuf| read_checked(path, (&args.model, &model), args.anyway);
    let logs: Vec<_> = args.log.iter().map(checked).collect::<Result<_, _>>()?;
    let bar = common.progress(0, "refitting");
    let window_s = (args.criterion == Criterion::Simulation).then_some(args.window_s);
    let found = identified(&model, &logs, window_s).map_err(|error| match error {
        DiscoverError::Short(samples) => {
            let mut paths = args.log.iter().zip(&logs);
            let short = paths.find(|(_, log)| log.len() == samples);
            let path = short.map_or(&args.log[0], |(path, _)| path).display();
            Failure::input(format!("{path}: has {samples} samples; give at least {LEAST_SAMPLES}"))
        }
        error => Failure::input(format!("{}: {error}", args.model.display())),
    })?;
    bar.finish_and_clear();
    let json = found.json();
    let pretty =
        serde_json::to_string_pretty(&json).map_err(|error| Failure::check(error.to_string()))?;
    out.write("model.toml", found.model().to_toml())?;
    out.write("identify.json", pretty)?;
    out.write("report.html", found.report(&model, &logs[0], &source(args, &out)))?;
    let said: String = found.notes().iter().map(|note| format!("{note}\n")).collect();
    let path = out.path().join("model.toml");
    out.finish()?;
    let text = format!("{}{said}model: {}", table(&found), path.display());
    Ok(Outcome::done(json, text))
}

/// A window's length from its text.
fn window(text: &str) -> Result<f64, String> {
    let long = |seconds: &f64| seconds.is_finite() && *seconds > 0.0;
    let seconds = text.parse::<f64>().ok().filter(long);
    seconds.ok_or_else(|| "a length in seconds above zero".to_owned())
}

/// Where the report comes from.
fn source(args: &Args, out: &OutDir) -> Source {
    let logs: Vec<String> = args.log.iter().map(|log| quoted(log)).collect();
    let mut command = format!(
        "joint identify --model {} --log {} --out {}",
        quoted(&args.model),
        logs.join(" "),
        quoted(&args.out),
    );
    if args.criterion == Criterion::Simulation {
        let _ = write!(command, " --criterion simulation --window-s {}", args.window_s);
    }
    if args.anyway {
        command += " --anyway";
    }
    Source::new(command, &args.model, &args.log, out)
}

fn table(found: &Identified) -> String {
    let mut text = String::new();
    let _ = writeln!(text, "{:44} {:>12} {:>12} {:>10}", "parameter", "nominal", "refitted", "±");
    for (key, [nominal, refitted, sigma], determined) in found.parameters() {
        let note = if determined { "" } else { "  not determined by this log" };
        let _ = writeln!(text, "{key:44} {nominal:>12.5e} {refitted:>12.5e} {sigma:>10.1e}{note}");
    }
    text
}
