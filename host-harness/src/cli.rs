//! The command line.

use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use serde_json::json;

use crate::verb::{self, Common, Failure, Outcome};
use crate::{standard, terminal};

/// A motor joint's model: run it, check it, and find what it misses in a log
#[derive(Debug, Parser)]
#[command(name = "joint", version, arg_required_else_help = true)]
struct Cli {
    #[command(flatten)]
    common: Common,
    #[command(subcommand)]
    verb: Verb,
}

/// The same of every verb, at the end of its help.
const EXIT_CODES: &str = "Exit code: 0 done, 1 a bound or check failed, 2 bad input or usage";

/// The verbs of the command line by what a person does with them; each is a module of [`verb`] with
/// `Args` and `run`.
macro_rules! verbs {
    ($($heading:literal: $($name:ident => $module:ident),*;)*) => {
        #[derive(Debug, Subcommand)]
        enum Verb {
            $($($name(Box<verb::$module::Args>),)*)*
        }

        impl Verb {
            fn run(&self, common: &Common) -> Result<Outcome, Failure> {
                match self {
                    $($(Verb::$name(args) => verb::$module::run(args, common),)*)*
                }
            }
        }

        /// Headings, and how many verbs stand under each.
        const GROUPS: &[(&str, usize)] = &[$(($heading, [$(stringify!($name)),*].len()),)*];
    };
}

verbs! {
    "Make a log and a model": Import => import, New => new, Check => check;
    "Find what the model misses": Discover => discover, Identify => identify, Transfer => transfer,
        Simulate => simulate, Demo => demo;
    "Bring it to a drive or another tool": Observe => observe, Export => export, Budget => budget,
        Flash => flash, Monitor => monitor, Capture => capture;
    "See how far to trust it": CrossCheck => cross_check, Reproduce => reproduce, Score => score, Machines => machines,
        ObserveBench => observe_bench;
    "Set up": Doctor => doctor, Completions => completions, Man => man;
}

/// The command line as clap knows it, its help for the width of the terminal.
pub fn command() -> clap::Command {
    let width = terminal::help_width();
    let command = Cli::command().mut_subcommands(|own| {
        let examples = own.get_after_help().map(ToString::to_string).unwrap_or_default();
        let examples = terminal::commands(&examples, width);
        own.after_help(format!("{examples}\n\n{EXIT_CODES}"))
    });
    let listed = listed(&command, width);
    command.max_term_width(width).after_help(EXIT_CODES).help_template(format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{listed}Options:\n{{options}}{{after-help}}"
    ))
}

/// The verbs under their headings.
fn listed(command: &clap::Command, width: usize) -> String {
    let mut verbs = command.get_subcommands();
    let column = command.get_subcommands().map(|verb| verb.get_name().len()).max().unwrap_or(0);
    let mut text = String::new();
    for (heading, number) in GROUPS {
        text += &format!("{heading}:\n");
        for verb in verbs.by_ref().take(*number) {
            let about = verb.get_about().map(ToString::to_string).unwrap_or_default();
            text += &terminal::row(verb.get_name(), column, &about, width);
            text.push('\n');
        }
        text.push('\n');
    }
    text + &terminal::wrapped("`joint VERB --help` says more and has examples.\n\n", width)
}

/// Runs the command line of this process.
pub fn main() -> ExitCode {
    let matches = command().try_get_matches();
    let cli = match matches.and_then(|matches| Cli::from_arg_matches(&matches)) {
        Ok(cli) => cli,
        Err(error) => return refused(&error),
    };
    match cli.verb.run(&cli.common) {
        Ok(outcome) => {
            match (cli.common.json, standard::is_output_taken()) {
                (true, _) => print(&outcome.json.to_string()),
                (false, true) => eprintln!("{}", outcome.text),
                (false, false) => print(&match terminal::width() {
                    Some(width) => terminal::wrapped(&outcome.text, width),
                    None => outcome.text,
                }),
            }
            if outcome.passed { ExitCode::SUCCESS } else { ExitCode::from(1) }
        }
        Err(failure) => {
            if cli.common.json {
                print(&json!({"error": failure.message}).to_string());
            }
            eprintln!("error: {failure}");
            ExitCode::from(failure.code)
        }
    }
}

/// What is no verb to run: a help or a version that was asked for, or an error of usage.
fn refused(error: &clap::Error) -> ExitCode {
    let asked = matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion);
    if !asked && std::env::args_os().take_while(|own| own != "--").any(|own| own == "--json") {
        let text = match error.kind() {
            ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand | ErrorKind::MissingSubcommand => {
                "no verb is given\n  help: `joint --help` lists them".to_owned()
            }
            _ => error.render().to_string(),
        };
        let text = text.trim_end();
        print(&json!({"error": text.strip_prefix("error: ").unwrap_or(text)}).to_string());
    }
    // A reader that has gone away is no error of ours.
    let _ = error.print();
    ExitCode::from(if asked { 0 } else { 2 })
}

/// Prints a result; a reader that has gone away is no error of ours.
fn print(text: &str) {
    use std::io::Write;
    let _ = writeln!(std::io::stdout().lock(), "{text}");
}
