//! `joint machines`: what is found on measured machines, and whether it holds on their other records.

use std::fmt::Write as _;
use std::path::PathBuf;

use serde_json::json;

use super::discover::{failure, write};
use super::transfer::prefixed;
use super::{Common, Failure, Outcome, read_log, read_model};
use crate::discover::discover_beside;
use crate::discover::findings::Named;
use crate::interrupt;
use crate::log::Need;
use crate::machines::{Told, machines, told};
use crate::output::OutDir;

/// Discover on every measured machine in a folder, with free runs on its other records
///
/// A machine is a folder with `nominal.toml`, `log.csv` (or several logs of one joint) and other records in
/// `transfer`. Writes `machines.json`, the table as `machines.md`, and each machine's verdict, model and
/// report in a folder of its own. An interrupt tells the machines that are done.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint machines measured --out machines")]
pub struct Args {
    /// Folder with a folder a machine
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Only these machines
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Folder for the result
    #[arg(short = 'o', long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Runs the verb.
///
/// # Errors
/// Bad input, or a result that may not be overwritten.
pub fn run(args: &Args, common: &Common) -> Result<Outcome, Failure> {
    let mut all = machines(&args.folder).map_err(Failure::input)?;
    if let Some(unknown) = args.only.iter().find(|name| all.iter().all(|own| own.name != **name)) {
        let names: Vec<&str> = all.iter().map(|own| own.name.as_str()).collect();
        let told = format!("no machine {unknown:?}; there are {}", names.join(", "));
        return Err(Failure::input(format!("{}: {told}", args.folder.display())));
    }
    all.retain(|own| args.only.is_empty() || args.only.contains(&own.name));
    let out = OutDir::new(&args.out, common.force)?;
    interrupt::watch();
    let bar = common.progress(all.len() as u64, "machines");
    let mut rows = Vec::new();
    for machine in &all {
        bar.set_message(machine.name.clone());
        let model = read_model(&machine.nominal)?;
        let read = |path: &PathBuf| read_log(path, Need::Drive);
        let logs: Vec<_> = machine.logs.iter().map(read).collect::<Result<_, _>>()?;
        let other = |path: &PathBuf| Ok::<_, Failure>((path.clone(), read(path)?));
        let others: Vec<_> = machine.transfer.iter().map(other).collect::<Result<_, _>>()?;
        let hidden = indicatif::ProgressBar::hidden();
        let asked: Vec<_> = others.iter().map(|(_, log)| log.clone()).collect();
        let findings = discover_beside(&model, (&logs, &asked), &[], &hidden).map_err(failure)?;
        if interrupt::asked() {
            break;
        }
        let kept = out.folder(&machine.name, common.force)?;
        let command = super::discover::Args {
            model: machine.nominal.clone(),
            log: machine.logs.clone(),
            out: kept.path().to_owned(),
            transfer: machine.transfer.clone(),
            without: Vec::new(),
            anyway: true,
        };
        write(&kept, &findings, &logs, &command.source(&kept))?;
        kept.finish()?;
        let row = told(machine, &logs, &findings, &others)
            .map_err(|error| Failure::check(format!("{}: {error}", machine.name)))?;
        rows.push(row);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let json = json!({"machines": rows});
    let pretty =
        serde_json::to_string_pretty(&json).map_err(|error| Failure::check(error.to_string()))?;
    out.write("machines.json", pretty)?;
    let text = table(&rows);
    out.write("machines.md", &text)?;
    out.finish()?;
    Ok(Outcome::done(json, text.trim_end()))
}

/// The tables: what is found, and the other records.
fn table(rows: &[Told]) -> String {
    let mut text = String::from(
        "| machine | samples | answer | named: confidence, share | left over | free run on unseen samples | seconds |\n\
         | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for row in rows {
        let verdict = &row.verdict;
        let runs = verdict.free_run.signals.iter().map(|(signal, [before, after])| {
            let unit = if signal == "i_a" { "A" } else { "rad" };
            format!("{signal} {} to {}", prefixed(*before, unit), prefixed(*after, unit))
        });
        let _ = writeln!(
            text,
            "| {} | {}, {:.1} s | {} | {} | {} | {} | {:.0} |",
            row.machine,
            row.samples,
            row.duration_s,
            verdict.verdict.name(),
            list(verdict.effects.iter().chain(&verdict.unnamed).map(effect)),
            left(row),
            list(runs),
            verdict.seconds
        );
    }
    if rows.iter().all(|row| row.transfer.is_empty()) {
        return text;
    }
    text += "\n| machine | other record | signal | refitted | with the effects | windows of 1 s |\n\
             | --- | --- | --- | --- | --- | --- |\n";
    for row in rows {
        for other in &row.transfer {
            for (before, after) in other.refitted.signals.iter().zip(&other.improved.signals) {
                let unit = before.unit;
                let windows = before.windows.zip(after.windows);
                let _ = writeln!(
                    text,
                    "| {} | {} | {} | {} | {} | {} |",
                    row.machine,
                    other.log,
                    before.signal,
                    prefixed(before.free_run.rms, unit),
                    prefixed(after.free_run.rms, unit),
                    windows.map_or("–".to_owned(), |(before, after)| {
                        let [before, after] = [before, after].map(|own| prefixed(own.rms, unit));
                        format!("{before} to {after}")
                    })
                );
            }
        }
    }
    text
}

fn effect(own: &Named) -> String {
    let order = own
        .parameters
        .get("order")
        .map_or(String::new(), |order| format!(" of order {}", (1e4 * order).round() / 1e4));
    let elsewhere =
        own.transfer_t.map_or(String::new(), |t| format!(", t {t:.1} on the other records"));
    format!(
        "{}{order} ({}) {:.2}, {:.0} ± {:.0} %{elsewhere}",
        own.kind,
        own.location,
        own.confidence,
        100.0 * own.share,
        100.0 * own.share_error
    )
}

/// What the effects leave of what the refitted nominal misses.
fn left(row: &Told) -> String {
    row.verdict.budget.as_ref().map_or("–".to_owned(), |budget| {
        let [unnamed, coloured, white] =
            [budget.unnamed, budget.coloured, budget.white].map(|share| 100.0 * share);
        format!(
            "of {} in the {}: {unnamed:.0} % unnamed, {coloured:.0} % coloured, {white:.0} % white",
            prefixed(budget.rms_before, &budget.unit),
            budget.equation
        )
    })
}

fn list(items: impl Iterator<Item = String>) -> String {
    let all: Vec<String> = items.collect();
    if all.is_empty() { "–".to_owned() } else { all.join("; ") }
}
