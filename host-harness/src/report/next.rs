//! What to do next, as commands to paste.

use std::fmt::Write;

use super::source::{Source, quoted};
use super::words::{capital, words};
use crate::discover::findings::{Answer, Findings};
use crate::plot::text::escape;

/// The section.
pub(super) fn section(page: &mut String, findings: &Findings, source: &Source) {
    let verdict = &findings.verdict;
    let _ = writeln!(
        page,
        "<h2>What to measure next</h2>\n<p>{}.</p>",
        escape(&capital(&words(verdict.next_experiment.trim_end_matches('.'))))
    );
    for (what, command) in commands(findings, source) {
        let _ = writeln!(
            page,
            "<p class=note>{}</p>\n<div class=paste><pre>{}</pre><button type=\"button\" class=copy>copy</button></div>",
            escape(&what),
            escape(&command)
        );
    }
}

/// What each is for, and the command.
fn commands(findings: &Findings, source: &Source) -> Vec<(String, String)> {
    let model = quoted(&source.model.path);
    let found = |name: &str| quoted(&source.out.join(name));
    let logs: Vec<String> = source.logs.iter().map(|log| quoted(&log.path)).collect();
    let (logs, next) = (logs.join(" "), "next.csv");
    let again = quoted(&source.out.with_extension("next"));
    let check = (
        format!("The new recording is called {next} here. Whether it can tell, in two seconds:"),
        format!("joint check --model {model} --log {next}"),
    );
    let both = (
        "Both recordings together:".to_owned(),
        format!("joint discover --model {model} --log {logs} {next} --out {again}"),
    );
    let transfer = (
        format!(
            "Whether the improved model holds on a recording that no fit has seen, called {next} here:"
        ),
        format!("joint transfer --model {model} {} --log {next}", found("model.toml")),
    );
    let mut all = match &findings.experiment {
        Some(experiment) => {
            let input = found("next_experiment.csv");
            let out = quoted(&source.out.join("expected.csv"));
            vec![(
                format!(
                    "What the drive is to be given ({}), and what the improved model expects:",
                    experiment.name
                ),
                format!(
                    "joint simulate --model {} --input {input} --out {out}",
                    found("model.toml")
                ),
            )]
        }
        None => Vec::new(),
    };
    match findings.verdict.verdict {
        Answer::Undecided => all.extend([
            (
                "What this recording lacks, and what its model:".to_owned(),
                format!("joint check --model {model} --log {logs}"),
            ),
            check,
            (
                "The question again:".to_owned(),
                format!("joint discover --model {model} --log {next} --out {again}"),
            ),
        ]),
        Answer::Adequate => all.extend([transfer, check, both]),
        Answer::Effect if all.is_empty() => all.extend([check, transfer, both]),
        Answer::Effect => all.extend([transfer, both]),
        Answer::Unknown if all.is_empty() => {
            all.extend([check, both, transfer]);
        }
        Answer::Unknown => all.extend([check, both]),
    }
    all.truncate(3);
    all
}
