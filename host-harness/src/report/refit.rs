//! The page of a refit: how far the refitted model runs beside the log, and what the log tells of its parameters.

use std::fmt::Write;

use super::free::{self, Entry};
use super::source::Source;
use super::{parameters, words};
use crate::discover::findings::ParameterRow;
use crate::log::Log;
use crate::model::Model;
use crate::plot;
use crate::plot::Ink;
use crate::plot::text::{digits, escape, si};
use crate::transfer::{Course, WINDOW_S, courses};

/// What a refit found.
pub struct Refit<'a> {
    /// As it was given.
    pub nominal: &'a Model,
    /// Refitted.
    pub refitted: &'a Model,
    /// Its parameters.
    pub parameters: &'a [ParameterRow],
    /// What was found out about the log's timing.
    pub timing: Option<&'a str>,
}

/// The page `report.html` of a refit to a log.
pub fn refit(found: &Refit<'_>, log: &Log, source: &Source) -> String {
    let name = &found.nominal.name;
    let open = found.parameters.iter().filter(|row| !row.determined).count();
    let all = found.parameters.len();
    let mut page = format!(
        "<p class=over>The model of {}, refitted</p>\n<div class=answer><h1>The log tells {} of {all} \
         parameters{}</h1>\n",
        escape(if name.is_empty() { "this joint" } else { name }),
        all - open,
        if open == 0 { String::new() } else { format!("; {open} stay assumed") }
    );
    let runs = [found.nominal, found.refitted].map(|model| courses(model, log, WINDOW_S));
    if runs.iter().all(Result::is_ok) {
        page.push_str(
            "<p class=first>Run free over the whole log, by its input alone from its first state, the refitted \
             model misses by:</p>\n",
        );
    }
    if let Some(timing) = found.timing {
        let _ = writeln!(page, "<p class=first>{}.</p>", escape(&words::capital(timing)));
    }
    page.push_str("</div>\n<div class=tiles>\n");
    if let [Ok(nominal), Ok(refitted)] = &runs {
        for (before, after) in nominal.iter().zip(refitted) {
            tile(&mut page, before, after);
        }
    }
    page.push_str("</div>\n");
    let entry = |name, model, ink| Entry { name, model, ink };
    let entries = [
        entry("nominal", found.nominal, Ink::Faint),
        entry("refitted", found.refitted, Ink::After),
    ];
    free::section(&mut page, &entries, log, &[]);
    parameters::table(&mut page, found.parameters, &source.assumed, false);
    let _ = writeln!(
        page,
        "<details><summary>The model file, refitted</summary><pre>{}</pre></details>",
        escape(&found.refitted.to_toml())
    );
    source.section(&mut page);
    plot::page(&format!("{name}: refitted"), &page)
}

/// How far a signal is missed, in its unit and in per cent of what it does.
fn tile(page: &mut String, before: &Course, after: &Course) {
    let name = words::words(after.signal.column);
    let share = |course: &Course| match course.size > 0.0 {
        true => format!(" ({} %)", digits(100.0 * course.free_errors.rms / course.size, 2)),
        false => String::new(),
    };
    let of = |course: &Course| match course.free_errors.rms < 1e15 {
        true => format!("{}{}", si(course.free_errors.rms, course.signal.unit, 3), share(course)),
        false => "not finite".to_owned(),
    };
    let diverges = if after.diverged() { "; the run diverges" } else { "" };
    let _ = writeln!(
        page,
        "<div><b>{}</b><small>RMS of the {name}{diverges}; as given {}</small></div>",
        escape(&of(after)),
        escape(&of(before))
    );
}
