//! What the command `joint` does: one file per verb.
//!
//! A verb takes its arguments and what is common to all, and gives back what to print or what went
//! wrong; it prints nothing on standard output itself, so that `--json` yields one object whatever
//! the verb.

pub mod budget;
pub mod capture;
pub mod check;
pub mod completions;
pub mod cross_check;
pub mod demo;
pub mod discover;
pub mod doctor;
pub mod drive;
pub mod export;
pub mod flash;
pub mod identify;
pub mod import;
mod load;
pub mod machines;
pub mod man;
pub mod monitor;
pub mod new;
pub mod observe;
pub mod observe_bench;
pub mod reproduce;
pub mod score;
pub mod simulate;
pub mod transfer;

use std::fmt::Write;
use std::path::Path;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

pub use crate::failure::Failure;
use crate::output::OutFile;
use crate::standard;

pub use load::{Scalar, read_log, read_model};

/// Options that every verb has.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct Common {
    /// Print one JSON object on standard output instead of text
    #[arg(long, global = true, display_order = 900)]
    pub json: bool,
    /// Replace an earlier result
    #[arg(short = 'f', long, global = true, display_order = 900)]
    pub force: bool,
}

impl Common {
    /// A file to write; `-` is standard output, which then holds nothing else.
    ///
    /// # Errors
    /// As [`OutFile::new`], or standard output is taken already.
    pub fn file(&self, path: &Path) -> Result<OutFile, Failure> {
        if standard::is(path) && (self.json || !standard::take_output()) {
            return Err(Failure::input(
                "standard output takes one thing: a single file as `-`, or the object of --json\n  help: give one of them a file's name",
            ));
        }
        OutFile::new(path, self.force)
    }

    /// A progress bar on standard error, hidden where that is no terminal; `steps` zero shows a
    /// spinner.
    pub fn progress(&self, steps: u64, what: &str) -> ProgressBar {
        let bar = ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::stderr());
        let template = match steps {
            0 => "{spinner} {msg}, {seconds}",
            _ => "{msg} {wide_bar} {pos}/{len}, {seconds}",
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            let seconds = |state: &ProgressState, text: &mut dyn Write| {
                let _ = write!(text, "{} s", state.elapsed().as_secs());
            };
            bar.set_style(style.with_key("seconds", seconds));
        }
        bar.set_message(what.to_owned());
        bar.enable_steady_tick(Duration::from_millis(200));
        bar
    }
}

/// What a verb has done.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// For `--json`.
    pub json: serde_json::Value,
    /// For a person.
    pub text: String,
    /// Whether every bound and check held.
    pub passed: bool,
}

impl Outcome {
    /// A verb done.
    pub fn done(json: serde_json::Value, text: impl Into<String>) -> Self {
        Self { json, text: text.into(), passed: true }
    }
}

/// A number above zero, on the command line.
fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("must be a number above zero".to_owned()),
    }
}
