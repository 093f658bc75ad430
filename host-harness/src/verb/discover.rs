//! `joint discover`: what a model misses, found, named and added.

use std::fmt::Write as _;
use std::path::PathBuf;

use joint_core::effect::Kind;

use super::load::read_checked;
use super::{Common, Failure, Outcome, read_model};
use crate::discover::findings::{Answer, Findings};
use crate::discover::{DiscoverError, discover_beside};
use crate::interrupt;
use crate::log::Log;
use crate::output::OutDir;
use crate::report::{self, Source, quoted};

/// Find, name and add what a model misses in logs of the joint
///
/// Writes `verdict.json`, `model.toml`, `report.html`, `residuals.csv`, and `next_experiment.csv`
/// where another run would decide. An interrupt concludes from what is known by then.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint discover --model arm.toml --log arm.csv --out found
  joint discover --model arm.toml --log arm.csv --transfer other-day.csv --out found")]
pub struct Args {
    /// Model file
    #[arg(short = 'm', long, value_name = "TOML")]
    pub model: PathBuf,
    /// Logs of the joint; - is standard input
    #[arg(short = 'l', long, value_name = "CSV", required = true, num_args = 1..)]
    pub log: Vec<PathBuf>,
    /// Other records of the joint, that nothing is fitted to: what they speak against is only possible
    #[arg(short = 't', long, value_name = "CSV", num_args = 1..)]
    pub transfer: Vec<PathBuf>,
    /// Folder for the result
    #[arg(short = 'o', long, value_name = "DIR")]
    pub out: PathBuf,
    /// Kinds of effects that are not to be considered
    #[arg(long, value_name = "KIND", value_delimiter = ',', value_parser = kind)]
    pub without: Vec<Kind>,
    /// Go on where log and model cannot both be right (see `joint check`)
    #[arg(long)]
    pub anyway: bool,
}

impl Args {
    /// Where the report comes from.
    pub(super) fn source(&self, out: &OutDir) -> Source {
        let logs: Vec<String> = self.log.iter().map(|log| quoted(log)).collect();
        let mut command = format!(
            "joint discover --model {} --log {} --out {}",
            quoted(&self.model),
            logs.join(" "),
            quoted(&self.out)
        );
        if !self.without.is_empty() {
            let kinds: Vec<&str> = self.without.iter().map(|kind| kind.spec().kind).collect();
            command += &format!(" --without {}", kinds.join(","));
        }
        if !self.transfer.is_empty() {
            let others: Vec<String> = self.transfer.iter().map(|log| quoted(log)).collect();
            command += &format!(" --transfer {}", others.join(" "));
        }
        if self.anyway {
            command += " --anyway";
        }
        Source::new(command, &self.model, &self.log, out)
    }
}

/// A kind by its name in model files.
fn kind(name: &str) -> Result<Kind, String> {
    Kind::from_name(name).ok_or_else(|| {
        let known: Vec<&str> = Kind::ALL.iter().map(|kind| kind.spec().kind).collect();
        format!("no such kind; the kinds are {}", known.join(", "))
    })
}

/// Files of a discovery.
const FILES: [&str; 5] =
    ["model.toml", "residuals.csv", "report.html", "next_experiment.csv", "verdict.json"];

/// Runs the verb.
///
/// # Errors
/// Bad input, or a result that may not be overwritten.
pub fn run(args: &Args, common: &Common) -> Result<Outcome, Failure> {
    let out = OutDir::new(&args.out, common.force)?
        .apart_from(args.log.iter().chain(&args.transfer).chain([&args.model]), &FILES)?;
    let model = read_model(&args.model)?;
    let checked = |path: &PathBuf| read_checked(path, (&args.model, &model), args.anyway);
    let logs: Vec<_> = args.log.iter().map(checked).collect::<Result<_, _>>()?;
    let bar = common.progress(0, "reading the logs");
    interrupt::watch();
    let others: Vec<_> = args.transfer.iter().map(checked).collect::<Result<_, _>>()?;
    let findings =
        discover_beside(&model, (&logs, &others), &args.without, &bar).map_err(failure)?;
    bar.finish_and_clear();
    write(&out, &findings, &logs, &args.source(&out))?;
    let report = out.path().join("report.html");
    out.finish()?;
    let json = serde_json::to_value(&findings.verdict)
        .map_err(|error| Failure::check(error.to_string()))?;
    let text = format!("{}\nreport: {}", summary(&findings), report.display());
    Ok(Outcome::done(json, text))
}

/// What went wrong, as a verb's failure.
pub(super) fn failure(error: DiscoverError) -> Failure {
    Failure::input(error.to_string())
}

/// Writes the files of a discovery in these logs.
pub(super) fn write(
    out: &OutDir,
    findings: &Findings,
    logs: &[Log],
    source: &Source,
) -> Result<(), Failure> {
    let verdict = serde_json::to_string_pretty(&findings.verdict)
        .map_err(|error| Failure::check(error.to_string()))?;
    out.write("model.toml", findings.improved.to_toml())?;
    out.write("residuals.csv", report::residuals_csv(findings))?;
    out.write("report.html", report::html(findings, logs, source))?;
    if let Some(experiment) = &findings.experiment {
        out.write("next_experiment.csv", experiment.csv())?;
    }
    out.write("verdict.json", verdict)?;
    Ok(())
}

/// The answer for a terminal.
pub(super) fn summary(findings: &Findings) -> String {
    let verdict = &findings.verdict;
    let mut text = match verdict.verdict {
        Answer::Effect => "effect: the model misses\n".to_owned(),
        Answer::Adequate => {
            format!("adequate: nothing is missing that these logs show{}\n", report::to(verdict))
        }
        Answer::Undecided => "undecided: these logs cannot tell\n".to_owned(),
        Answer::Unknown if verdict.effects.is_empty() => {
            "unknown: something is missing that no listed effect explains\n".to_owned()
        }
        Answer::Unknown => {
            "unknown: what follows was found, but something else is missing as well\n".to_owned()
        }
    };
    let elsewhere =
        |t: Option<f64>| t.map_or(String::new(), |t| format!(", t {t:.1} on other records"));
    for effect in &verdict.effects {
        let values: Vec<String> = effect
            .parameters
            .iter()
            .map(|(key, value)| match effect.standard_errors.get(key) {
                Some(sigma) => format!("{key} {value:.4e} ± {sigma:.1e}"),
                None => format!("{key} {value}"),
            })
            .collect();
        let _ = writeln!(
            text,
            "  {} ({}), confidence {:.2}, {:.1} ± {:.1} % of the gap{}: {}",
            effect.kind,
            effect.location,
            effect.confidence,
            100.0 * effect.share,
            100.0 * effect.share_error,
            elsewhere(effect.transfer_t),
            values.join(", ")
        );
    }
    for effect in &verdict.possible {
        let _ = writeln!(
            text,
            "  possible, not added: {} ({}), confidence {:.2}{}",
            effect.kind,
            effect.location,
            effect.confidence,
            elsewhere(effect.transfer_t)
        );
    }
    for map in &verdict.unnamed {
        let _ = writeln!(
            text,
            "  added without a name: {} ({}), {:.1} ± {:.1} % of the gap",
            map.kind,
            map.location,
            100.0 * map.share,
            100.0 * map.share_error
        );
    }
    let place = &verdict.whereabouts;
    if !matches!(verdict.verdict, Answer::Adequate | Answer::Undecided) {
        let orders: Vec<String> = place.orders.iter().map(|order| format!("{order}")).collect();
        let orders = if orders.is_empty() {
            String::new()
        } else {
            format!(", orders {}", orders.join(" "))
        };
        let _ = writeln!(
            text,
            "where: {}, along {}{orders} ({:.0} % explained)",
            place.equation,
            place.varies_with,
            100.0 * place.explained
        );
    }
    for reason in &verdict.reasons {
        let _ = writeln!(text, "  - {reason}");
    }
    if verdict.verdict == Answer::Undecided {
        let _ = write!(text, "next: {}", verdict.next_experiment);
        return text;
    }
    let gap = &verdict.gap;
    let _ = writeln!(
        text,
        "gap: {:.3} before, {:.3} after, {:.3} floor ({}), {:.1} s",
        gap.before, gap.after, gap.floor, gap.unit, verdict.seconds
    );
    if let Some(budget) = &verdict.budget {
        let _ = writeln!(text, "{}", report::budget(budget));
    }
    let runs = verdict.free_run.signals.iter();
    let runs: Vec<String> = runs
        .map(|(column, [before, after])| format!("{column} {before:.3e} before, {after:.3e} after"))
        .collect();
    if !runs.is_empty() {
        let _ = writeln!(
            text,
            "free run ({}, {} stretches of up to {:.2} s): {}",
            verdict.free_run.mode,
            verdict.free_run.stretches,
            verdict.free_run.longest_s,
            runs.join("; ")
        );
    }
    let _ = write!(text, "next: {}", verdict.next_experiment);
    text
}
