//! The page, top down: the answer, where the error goes, measured and simulated, and then what one needs to
//! believe it. What is not explained leads where something is not; what is missing leads where a log cannot tell.

use std::fmt::Write;

use super::free::{self, Entry};
use super::source::Source;
use super::{answer, disagree, gap, next, parameters, rivals};
use crate::discover::findings::{Answer, Findings};
use crate::log::Log;
use crate::plot;
use crate::plot::Ink;
use crate::plot::text::escape;

/// Writes the page.
pub(super) fn page(findings: &Findings, logs: &[Log], source: &Source) -> String {
    let verdict = &findings.verdict;
    let class = verdict.verdict.name();
    let name = &findings.nominal.name;
    let mut page = format!(
        "<p class=over>What the model of {} lacks</p>\n<div class=\"answer {class}\"><h1>{}</h1>\n",
        escape(if name.is_empty() { "this joint" } else { name }),
        escape(&answer::headline(verdict))
    );
    for paragraph in answer::paragraphs(findings) {
        let _ = writeln!(page, "<p class=first>{}</p>", escape(&paragraph));
    }
    page.push_str("</div>\n");
    match verdict.verdict {
        Answer::Undecided => undecided(&mut page, findings, logs, source),
        _ => answered(&mut page, findings, logs, source),
    }
    source.section(&mut page);
    plot::page(&format!("{name}: {class}"), &page)
}

/// A log that cannot tell: what it lacks stands above, then what to measure and what it shows.
fn undecided(page: &mut String, findings: &Findings, logs: &[Log], source: &Source) {
    next::section(page, findings, source);
    if let Some(log) = logs.first() {
        free::measured(page, log);
    }
}

fn answered(page: &mut String, findings: &Findings, logs: &[Log], source: &Source) {
    let verdict = &findings.verdict;
    page.push_str("<div class=tiles>\n");
    gap::tiles(page, verdict);
    page.push_str("</div>\n");
    gap::budget(page, verdict);
    let unknown = verdict.verdict == Answer::Unknown;
    if unknown {
        disagree::section(page, findings);
        parameters::possible(page, &verdict.possible);
    }
    simulated(page, findings, logs);
    parameters::effects(page, &verdict.effects);
    parameters::unnamed(page, &verdict.unnamed);
    if !unknown {
        disagree::section(page, findings);
        parameters::possible(page, &verdict.possible);
    }
    rivals::section(page, &verdict.effects);
    let improved = !verdict.effects.is_empty();
    parameters::table(page, &findings.parameters, &source.assumed, improved);
    next::section(page, findings, source);
    grounds(page, findings, improved);
}

/// Measured against every model.
fn simulated(page: &mut String, findings: &Findings, logs: &[Log]) {
    let Some(log) = logs.first() else { return };
    let entry = |name, model, ink| Entry { name, model, ink };
    let mut entries = vec![entry("nominal", &findings.nominal, Ink::Faint)];
    match findings.verdict.effects.is_empty() {
        true => entries.push(entry("refitted", &findings.refitted, Ink::After)),
        false => entries.extend([
            entry("refitted", &findings.refitted, Ink::Before),
            entry("improved", &findings.improved, Ink::After),
        ]),
    }
    // Of several logs the first is drawn, whose times those of the record are.
    let end = log.time_s.last().copied().unwrap_or(f64::INFINITY);
    let first: Vec<f64> = findings.time_s.iter().copied().take_while(|t| *t <= end).collect();
    let flags = findings.held_out.get(..first.len()).unwrap_or_default();
    free::section(page, &entries, log, &free::unseen(&first, flags));
    free::stretches(page, &findings.verdict.free_run);
    if logs.len() > 1 {
        let _ = writeln!(page, "<p class=note>Drawn is the first of {} logs.</p>", logs.len());
    }
}

/// What one needs to believe it, for those who ask.
fn grounds(page: &mut String, findings: &Findings, improved: bool) {
    page.push_str("<h2>Evidence</h2>\n");
    gap::signals(page, &findings.verdict.gap);
    disagree::predictions(page, findings);
    rivals::reasons(page, findings);
    rivals::tried(page, findings);
    parameters::noises(page, &findings.noises, improved);
    let _ = writeln!(
        page,
        "<details><summary>The model file, refitted{}</summary><pre>{}</pre></details>",
        if improved { " and with the effects" } else { "" },
        escape(&findings.improved.to_toml())
    );
}
