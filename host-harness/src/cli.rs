//! The command line.

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::verb::{self, Common, Failure, Outcome};

/// A motor joint's model: run it, check it, and find what it misses in a log
#[derive(Debug, Parser)]
#[command(name = "joint", version, arg_required_else_help = true)]
#[command(after_help = "Exit code: 0 done, 1 a bound or check failed, 2 bad input or usage")]
struct Cli {
    #[command(flatten)]
    common: Common,
    #[command(subcommand)]
    verb: Verb,
}

/// The verbs of the command line; each is a module of [`verb`] with `Args` and `run`.
macro_rules! verbs {
    ($($name:ident => $module:ident,)*) => {
        #[derive(Debug, Subcommand)]
        enum Verb {
            $($name(Box<verb::$module::Args>),)*
        }

        impl Verb {
            fn run(&self, common: &Common) -> Result<Outcome, Failure> {
                match self {
                    $(Verb::$name(args) => verb::$module::run(args, common),)*
                }
            }
        }
    };
}

verbs! {
    Import => import,
    New => new,
    Check => check,
    Simulate => simulate,
    CrossCheck => cross_check,
    Budget => budget,
    Reproduce => reproduce,
    Identify => identify,
    Transfer => transfer,
    Discover => discover,
    Observe => observe,
    ObserveBench => observe_bench,
    Score => score,
    Demo => demo,
    Export => export,
    Flash => flash,
    Monitor => monitor,
    Capture => capture,
    Doctor => doctor,
}

/// Runs the command line of this process.
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    match cli.verb.run(&cli.common) {
        Ok(outcome) => {
            let text =
                if cli.common.json { outcome.json.to_string() } else { outcome.text.clone() };
            print(&text);
            if outcome.passed { ExitCode::SUCCESS } else { ExitCode::from(1) }
        }
        Err(failure) => {
            if cli.common.json {
                print(&serde_json::json!({"error": failure.message}).to_string());
            }
            eprintln!("error: {failure}");
            ExitCode::from(failure.code)
        }
    }
}

/// Prints a result; a reader that has gone away is no error of ours.
fn print(text: &str) {
    use std::io::Write;
    let _ = writeln!(std::io::stdout().lock(), "{text}");
}
