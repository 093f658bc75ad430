//! `joint transfer`: free runs of any models on any logs.

use std::fmt::Write as _;
use std::path::PathBuf;

use serde_json::json;

use super::{Common, Failure, Outcome, read_log, read_model};
use crate::log::Need;
use crate::output::OutDir;
use crate::transfer::{Errors, Transfer, transfer};

/// Run any models freely on any logs, with errors in SI units
///
/// A model is run by a log's input alone from its first state: as it is, with one scale on all friction
/// that the first seconds give, and over windows of a second from the measured state. Beside it stand
/// what a joint that stays where it is would miss, and by how much a per cent of friction moves the run.
/// Where the input is missing the joint swings freely. Writes `transfer.json`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint transfer --model nominal.toml --model found/model.toml --log other-day.csv --out transfer")]
pub struct Args {
    /// Model files
    #[arg(short = 'm', long, value_name = "TOML", required = true, num_args = 1..)]
    pub model: Vec<PathBuf>,
    /// Logs to run them on; - is standard input
    #[arg(short = 'l', long, value_name = "CSV", required = true, num_args = 1..)]
    pub log: Vec<PathBuf>,
    /// Folder for `transfer.json`
    #[arg(short = 'o', long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Runs the verb.
///
/// # Errors
/// Bad input, or a result that may not be overwritten.
pub fn run(args: &Args, common: &Common) -> Result<Outcome, Failure> {
    let apart =
        |out: OutDir| out.apart_from(args.model.iter().chain(&args.log), &["transfer.json"]);
    let out = args.out.as_ref().map(|out| OutDir::new(out, common.force).and_then(apart));
    let out = out.transpose()?;
    let models: Vec<_> =
        args.model.iter().map(|path| read_model(path)).collect::<Result<_, _>>()?;
    let bar = common.progress((args.model.len() * args.log.len()) as u64, "free runs");
    let (mut rows, mut text) = (Vec::new(), String::new());
    for path in &args.log {
        let log = read_log(path, Need::Drive)?;
        let _ = writeln!(
            text,
            "{}: {} samples, {:.2} s",
            path.display(),
            log.len(),
            log.time_s[log.len() - 1] - log.time_s[0]
        );
        for (name, model) in args.model.iter().zip(&models) {
            let told = transfer(model, &log)
                .map_err(|error| Failure::input(format!("{}: {error}", name.display())))?;
            table(&mut text, &name.display().to_string(), &told);
            rows.push(json!({"model": name, "log": path, "transfer": told}));
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    let json = json!({"rows": rows});
    if let Some(out) = out {
        let pretty = serde_json::to_string_pretty(&json)
            .map_err(|error| Failure::check(error.to_string()))?;
        let path = out.write("transfer.json", pretty)?;
        out.finish()?;
        let _ = write!(text, "{}", path.display());
    }
    Ok(Outcome::done(json, text.trim_end()))
}

/// A model's rows on a log.
fn table(text: &mut String, model: &str, told: &Transfer) {
    let _ = writeln!(text, "  {model}");
    for note in &told.notes {
        let _ = writeln!(text, "    note: {note}");
    }
    let _ = writeln!(text, "    {:40} {:>12} {:>12} {:>12}", "error", "RMS", "mean abs.", "max");
    for signal in &told.signals {
        let mut row = |what: &str, errors: Option<Errors>| {
            if let Some(errors) = errors {
                let unit = signal.unit;
                let [rms, mean, max] =
                    [errors.rms, errors.mean_absolute, errors.max].map(|v| prefixed(v, unit));
                let what = format!("{} {what}", signal.signal);
                let _ = writeln!(text, "    {what:40} {rms:>12} {mean:>12} {max:>12}");
            }
        };
        row("free run", Some(signal.free_run));
        if let Some(scale) = told.friction_scale {
            row(&format!("friction x {scale:.3}"), signal.relevelled);
        }
        row("in windows of 1 s", signal.windows);
        row("had it stayed at its start", Some(signal.resting));
        row("windows at their first speed", signal.coasting);
        let moved = prefixed(signal.per_percent_friction, signal.unit);
        let _ = writeln!(
            text,
            "    {:40} {moved:>12}",
            format!("{} by 1 % of friction", signal.signal)
        );
    }
}

/// A value with an SI prefix and three digits.
pub(super) fn prefixed(value: f64, unit: &str) -> String {
    let scale = [(1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n")];
    let own = scale.iter().find(|(factor, _)| value.abs() >= *factor).unwrap_or(&scale[3]);
    let shown = value / own.0;
    let places = if shown >= 100.0 {
        0
    } else if shown >= 10.0 {
        1
    } else {
        2
    };
    match value < 1e6 {
        true => format!("{shown:.places$} {}{unit}", own.1),
        false => "diverged".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::prefixed;

    #[test]
    fn figures_carry_a_prefix_and_three_digits() {
        assert_eq!(prefixed(0.006012, "rad"), "6.01 mrad");
        assert_eq!(prefixed(12.345, "A"), "12.3 A");
        assert_eq!(prefixed(f64::MAX, "A"), "diverged");
    }
}
