//! Free runs: what a simulator's user sees. Measured against the models as given, refitted and improved, run by
//! the log's input alone from its first state.
//!
//! Open loop a joint without a spring is an integrator: a free run may leave the log though the model is good.
//! Then that is said, and the runs over windows from the measured state are drawn instead.

use std::fmt::Write;

use rayon::prelude::*;

use super::words::{capital, joined, quantity, words};
use crate::discover::evidence::FreeRun;
use crate::log::Log;
use crate::model::Model;
use crate::plot::text::{digits, escape, si};
use crate::plot::{Axis, Ink, Mark, Plot, Series, bands};
use crate::transfer::{Course, WINDOW_S, courses};

/// Width of a plot's field, and heights of a signal's and of its errors'.
pub(super) const WIDTH: f64 = 952.0;
const HEIGHTS: [f64; 2] = [190.0, 120.0];
/// Windows that a record has at least, where it is shorter than so many seconds.
const LEAST_WINDOWS: f64 = 10.0;
/// The name under which plots over time are zoomed together.
pub(super) const TIME: &str = "time";

/// A model with its name on the page and its colour.
pub(super) struct Entry<'a> {
    pub(super) name: &'static str,
    pub(super) model: &'a Model,
    pub(super) ink: Ink,
}

/// The section; `held_out` are the times that no fit has seen. Nothing where a model cannot be run.
pub(super) fn section(page: &mut String, entries: &[Entry<'_>], log: &Log, held_out: &[[f64; 2]]) {
    let whole = log.time_s.last().zip(log.time_s.first()).map_or(0.0, |(last, first)| last - first);
    let window_s = WINDOW_S.min(whole / LEAST_WINDOWS);
    let runs: Result<Vec<_>, _> =
        entries.par_iter().map(|entry| courses(entry.model, log, window_s)).collect();
    let Ok(runs) = runs else { return };
    let Some(signals) = runs.first().map(Vec::len).filter(|signals| *signals > 0) else { return };
    let best = &runs[runs.len() - 1];
    let diverged = best.iter().any(Course::diverged);
    page.push_str("<h2>Measured and simulated</h2>\n");
    let free = "Each model runs free: by the log's input alone, from the log's first state, and nothing corrects \
                it on the way.";
    let _ = match diverged {
        false => writeln!(page, "<p>{free}</p>"),
        true => writeln!(
            page,
            "<p><b>The free run diverges</b>: over the whole log the {} model misses by more than one that \
             never moves. That need not speak against it: without a spring to hold it, a joint integrates every \
             error of friction. Drawn are runs over windows of {}, each from the measured state.</p>",
            entries[entries.len() - 1].name,
            si(window_s, "s", 2)
        ),
    };
    table(page, entries, &runs, (diverged, window_s));
    if let ([.., before, after], false) = (&runs[..], diverged) {
        worse(page, entries, [before, after]);
    }
    for signal in 0..signals {
        let of: Vec<&Course> = runs.iter().map(|run| &run[signal]).collect();
        plots(page, entries, &of, log, (diverged, held_out));
    }
    let shaded = if held_out.is_empty() { "" } else { " Shaded: no fit has seen it." };
    let _ = writeln!(
        page,
        "<p class=note>Drag or pinch across a plot to zoom, double-click or double-tap for all of it; plots over \
         time move together.{shaded}</p>"
    );
}

/// Says so where the last model runs worse over the whole log than the one before it.
fn worse(page: &mut String, entries: &[Entry<'_>], [before, after]: [&[Course]; 2]) {
    let names = before.iter().zip(after).filter(|(a, b)| b.free_errors.rms > a.free_errors.rms);
    let names: Vec<String> = names.map(|(_, own)| words(own.signal.column)).collect();
    if let ([.., old, new], false) = (entries, names.is_empty()) {
        let _ = writeln!(
            page,
            "<p>Over the whole log the {} model misses the {} by more than the {} one. Open loop that \
             can be: small errors of friction add up there.</p>",
            new.name,
            joined(&names),
            old.name
        );
    }
}

/// RMS errors by signal, in SI units and as a share of the signal.
fn table(
    page: &mut String,
    entries: &[Entry<'_>],
    runs: &[Vec<Course>],
    (diverged, window_s): (bool, f64),
) {
    page.push_str("<div class=wide><table><tr><th>RMS error");
    for entry in entries {
        let _ = write!(page, "<th class=n>{}", entry.name);
    }
    page.push_str("</tr>\n");
    let cell = |rms: f64, course: &Course| {
        let share = match course.size > 0.0 {
            true => format!(" <small>({} %)</small>", digits(100.0 * rms / course.size, 2)),
            false => String::new(),
        };
        format!("<td class=n>{}{share}", escape(&rms_in(rms, course.signal.unit)))
    };
    for (s, first) in runs.first().into_iter().flatten().enumerate() {
        let name = words(first.signal.column);
        let whole = if diverged { ", whole log" } else { "" };
        let _ = write!(page, "<tr><td>{name}{whole}");
        for run in runs {
            page.push_str(&cell(run[s].free_errors.rms, &run[s]));
        }
        if diverged && first.window_errors.is_some() {
            let _ = write!(page, "</tr>\n<tr><td>{name}, windows of {}", si(window_s, "s", 2));
            for run in runs {
                let errors = run[s].window_errors;
                page.push_str(&errors.map_or("<td>".to_owned(), |e| cell(e.rms, &run[s])));
            }
        }
        page.push_str("</tr>\n");
    }
    page.push_str(
        "</table></div><p class=note>In brackets: of the RMS of what was measured, about its mean.</p>\n",
    );
}

/// An RMS error, as it is told where it is not finite too.
fn rms_in(rms: f64, unit: &str) -> String {
    if rms < 1e15 { si(rms, unit, 3) } else { "not finite".to_owned() }
}

/// A signal and its errors.
fn plots(
    page: &mut String,
    entries: &[Entry<'_>],
    courses: &[&Course],
    log: &Log,
    (diverged, held_out): (bool, &[[f64; 2]]),
) {
    let Some(first) = courses.first() else { return };
    let name = words(first.signal.column);
    let time = &log.time_s;
    let axis = |what: String| Axis::linear(what, first.signal.unit);
    let plot = |title: String, y: Axis<'static>, height: f64| {
        let across =
            Axis::linear("time", "s").within(time.first().zip(time.last()).map(|(a, b)| [*a, *b]));
        Plot::new(title, across, y).sized(WIDTH, height).linked(TIME).explained()
    };
    let mut series = vec![Series::new("measured", Ink::Text, Mark::Broad, time, &first.measured)];
    let mut errors = Vec::new();
    for (entry, course) in entries.iter().zip(courses) {
        let own = if diverged { &course.windows } else { &course.free };
        let (x, own) = broken(time, own, if diverged { &course.starts } else { &[] });
        let measured =
            broken(time, &course.measured, if diverged { &course.starts } else { &[] }).1;
        let missed: Vec<f64> =
            own.iter().zip(&measured).map(|(own, measured)| own - measured).collect();
        series.push(Series::new(entry.name, entry.ink, Mark::Line, x.clone(), own));
        // Beside the error of the model as given that of a better one would not be seen.
        if entry.ink != Ink::Faint {
            errors.push(Series::new(entry.name, entry.ink, Mark::Line, x, missed));
        }
    }
    // What a diverging model does must not flatten what was measured.
    let [low, high] = ends(&first.measured);
    let margin = 0.25 * (high - low).max(f64::MIN_POSITIVE);
    let own = axis(name.clone()).within([low - margin, high + margin]);
    let bands = held_out.to_vec();
    page.push_str(
        &Plot { series, bands: bands.clone(), ..plot(capital(&name), own, HEIGHTS[0]) }.svg(),
    );
    let title = format!("Error of the {name}, simulated less measured");
    let own = axis("error".to_owned());
    page.push_str(&Plot { series: errors, bands, ..plot(title, own, HEIGHTS[1]) }.svg());
}

/// Times and values with a break before each of these samples.
fn broken(time: &[f64], values: &[f64], starts: &[usize]) -> (Vec<f64>, Vec<f64>) {
    let (mut x, mut y) = (Vec::with_capacity(time.len()), Vec::with_capacity(time.len()));
    for (k, (time, value)) in time.iter().zip(values).enumerate() {
        if starts.binary_search(&k).is_ok() {
            x.push(f64::NAN);
            y.push(f64::NAN);
        }
        x.push(*time);
        y.push(*value);
    }
    (x, y)
}

fn ends(values: &[f64]) -> [f64; 2] {
    let known = values.iter().filter(|value| value.is_finite());
    let [low, high] = known.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
        [low.min(*value), high.max(*value)]
    });
    if low < high { [low, high] } else { [-1.0, 1.0] }
}

/// What a log shows, without a model.
pub(super) fn measured(page: &mut String, log: &Log) {
    page.push_str("<h2>What the log shows</h2>\n");
    let optional = [
        ("u_v", &log.voltage_v),
        ("i_a", &log.current_a),
        ("output_angle_rad", &log.output_angle_rad),
    ];
    let optional = optional.into_iter().filter_map(|(name, values)| Some((name, values.as_ref()?)));
    for (column, values) in [("motor_angle_rad", &log.motor_angle_rad)].into_iter().chain(optional)
    {
        let (name, unit) = quantity(column);
        let plot =
            Plot::new(capital(&name), Axis::linear("time", "s"), Axis::linear(name.clone(), unit));
        let series = vec![Series::new(name.clone(), Ink::Text, Mark::Line, &log.time_s, values)];
        page.push_str(&Plot { series, ..plot.sized(WIDTH, HEIGHTS[1]).linked(TIME) }.svg());
    }
}

/// The times of a log that no fit has seen.
pub(super) fn unseen(time_s: &[f64], held_out: &[bool]) -> Vec<[f64; 2]> {
    bands(time_s, held_out)
}

/// The verdict's free runs: over stretches that no fit has seen, from the state at the start of each.
pub(super) fn stretches(page: &mut String, run: &FreeRun) {
    if run.signals.is_empty() {
        return;
    }
    let _ = writeln!(
        page,
        "<h3>Free runs over {} stretches of up to {} that no fit has seen</h3>\n<div class=wide><table><tr>\
         <th>RMS error, {}<th class=n>refitted<th class=n>improved</tr>",
        run.stretches,
        si(run.longest_s, "s", 2),
        escape(run.mode)
    );
    for (column, values) in &run.signals {
        let (name, unit) = quantity(column);
        let [before, after] = values.map(|rms| escape(&rms_in(rms, unit)));
        let _ = writeln!(page, "<tr><td>{name}<td class=n>{before}<td class=n>{after}</tr>");
    }
    page.push_str("</table></div>\n");
}
