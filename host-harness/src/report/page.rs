//! The page, top down: the answer, how far, where, and then what one needs to believe it.

use std::fmt::Write;

use super::{answer, csv, gap, tables};
use crate::discover::findings::{Answer, Findings, Shape};
use crate::plot;
use crate::plot::text::{escape, number};
use crate::plot::{Axis, Ink, Legend, Mark, Plot, Series, bands, legend};

const BEFORE: (Legend, &str) = (Legend::Of(Ink::Before), "before: the nominal structure, refitted");
const AFTER: (Legend, &str) = (Legend::Of(Ink::After), "after: with the effects found");
const FLOOR: (Legend, &str) = (Legend::Upright(Ink::Text), "floor: what noise alone leaves");
const HELD_OUT: (Legend, &str) = (Legend::Shade, "held out: no fit has seen it");
/// Width of a plot's field, pixels.
const WIDTH: f64 = 952.0;
/// Strongest orders that are listed.
const STRONGEST: usize = 6;

/// Writes the page.
pub(super) fn page(findings: &Findings) -> String {
    let verdict = &findings.verdict;
    let name = &findings.nominal.name;
    let class = verdict.verdict.name();
    let mut page = format!(
        "<h1>What the model of {} misses</h1>\n\
         <div class=\"answer {class}\"><p class=\"first\">{}</p><p>{}</p></div>\n",
        escape(name),
        answer::sentence(findings),
        answer::gap(findings)
    );
    let fitted = verdict.verdict != Answer::Undecided;
    if fitted {
        disagreement(&mut page, findings);
    }
    page.push_str("<h2>Why</h2>\n<ul>");
    for reason in &verdict.reasons {
        let _ = write!(page, "<li>{}</li>", escape(reason));
    }
    let _ = writeln!(page, "</ul>\n<h2>What to measure next</h2>\n<p>{}</p>", {
        escape(&verdict.next_experiment)
    });
    if fitted {
        grounds(&mut page, findings);
    }
    plot::page(&format!("{name}: {class}"), &page)
}

/// How far model and log are apart, and where.
fn disagreement(page: &mut String, findings: &Findings) {
    let verdict = &findings.verdict;
    tables::effects(page, &verdict.effects);
    tables::possible(page, &verdict.possible);
    let _ = writeln!(page, "<h2>How far</h2>\n{}", legend(&[BEFORE, AFTER, FLOOR]));
    gap::section(page, &verdict.gap);
    if let Some(budget) = &verdict.budget {
        let _ = writeln!(page, "<p>{}</p>", escape(&answer::budget(budget)));
    }
    tables::free_run(page, &verdict.free_run);
    whereabouts(page, findings);
    residuals(page, findings);
}

/// What one needs to believe it: hypotheses, parameters, noises, the model.
fn grounds(page: &mut String, findings: &Findings) {
    page.push_str(
        "<h2>Hypotheses</h2>\n<p class=note>Score: by how much the linear step promises to \
         improve the fit (2 Δ log-likelihood). Refitted gain: by how much the full refit did.</p>\n",
    );
    tables::hypotheses(page, findings);
    page.push_str("<h2>Parameters</h2>\n");
    tables::parameters(page, &findings.parameters);
    page.push_str("<p class=note>Pale: the log says little about it.</p>\n<h2>Noises</h2>\n");
    tables::noises(page, &findings.noises);
    let _ = writeln!(
        page,
        "<h2>The improved model</h2>\n<pre>{}</pre>\n<p class=note>Found in {} s.</p>",
        escape(&findings.improved.to_toml()),
        number(findings.verdict.seconds)
    );
}

fn whereabouts(page: &mut String, findings: &Findings) {
    let (push, shape) = (&findings.push, &findings.shape);
    let equation = if push.equation.is_empty() { "equation" } else { &push.equation };
    let push_axis = || Axis::linear("disturbance", push.unit);
    let _ = writeln!(
        page,
        "<h2>Where they disagree</h2>\n<p>Where the refitted model and the log disagree, {}. The \
         disturbance is what the log asks to be added to that equation, as a random walk.</p>{}",
        answer::place(&findings.verdict.whereabouts),
        legend(&[BEFORE, AFTER])
    );
    let against = |title: String, shape: &Shape| {
        let plot = Plot::new(title, Axis::linear(&*shape.coordinate, ""), push_axis());
        let series = pair(Mark::Dots, &shape.centres, &shape.before, &shape.after);
        Plot { series, ..plot }.svg()
    };
    let title = format!("Disturbance of the {equation} against {}", shape.coordinate);
    page.push_str(&against(title, shape));
    for (kind, shape) in &findings.along_effects {
        let (axis, kind) = (&shape.coordinate, kind.spec().kind);
        let title =
            format!("Disturbance of the {equation} against {axis}, with which {kind} varies");
        page.push_str(&against(title, shape));
    }
    let title = format!("Disturbance of the {equation} along the log");
    let plot = Plot::new(title, Axis::linear("t", "s"), push_axis()).sized(WIDTH, 150.0);
    let series = pair(Mark::Line, &findings.time_s, &push.before, &push.after);
    let bands = bands(&findings.time_s, &findings.held_out);
    page.push_str(&Plot { series, bands, ..plot }.svg());
    orders(page, findings);
}

fn orders(page: &mut String, findings: &Findings) {
    let column = |k: usize| -> Vec<f64> { findings.orders.iter().map(|row| row[k]).collect() };
    let plot = Plot::new(
        "Amplitude of the disturbance by order of the motor angle",
        Axis::linear("order, per turn", ""),
        Axis::linear("disturbance", findings.push.unit),
    );
    let [order, before, after] = [0, 1, 2].map(column);
    let series = pair(Mark::Bars, &order, &before, &after);
    page.push_str(&Plot { series, ..plot.sized(WIDTH, 120.0) }.svg());
    let mut strongest: Vec<&[f64; 3]> =
        findings.orders.iter().filter(|row| row.iter().all(|value| value.is_finite())).collect();
    strongest.sort_by(|a, b| b[1].total_cmp(&a[1]));
    if strongest.is_empty() {
        return;
    }
    page.push_str("<table><tr><th>strongest orders, per turn");
    let rows = || strongest.iter().take(STRONGEST);
    for row in rows() {
        let _ = write!(page, "<th class=n>{}", answer::number_of(row[0]));
    }
    for (k, name) in [(1, "before"), (2, "after")] {
        let _ = write!(page, "</tr>\n<tr><td>{name}, {}", escape(findings.push.unit));
        for row in rows() {
            let _ = write!(page, "<td class=n>{}", number(row[k]));
        }
    }
    page.push_str("</tr></table>\n");
}

fn residuals(page: &mut String, findings: &Findings) {
    let entries = legend(&[BEFORE, AFTER, HELD_OUT]);
    let _ = writeln!(page, "<h2>Prediction errors</h2>\n{entries}");
    let bands = bands(&findings.time_s, &findings.held_out);
    for channel in csv::measured(findings) {
        let c = channel as usize;
        let before: Vec<f64> = findings.before.iter().map(|row| row[c]).collect();
        let after: Vec<f64> = findings.after.iter().map(|row| row[c]).collect();
        let errors = Axis::linear("error, noise sigmas", "");
        let plot = Plot::new(channel.column(), Axis::linear("t", "s"), errors);
        let series = pair(Mark::Line, &findings.time_s, &before, &after);
        let plot = Plot { series, bands: bands.clone(), ..plot.sized(WIDTH, 140.0) };
        page.push_str(&plot.svg());
    }
    page.push_str(
        "<p class=note>Drag across a plot to zoom, double-click to see all of it again, point at \
         it for numbers. All numbers are in residuals.csv.</p>\n",
    );
}

fn pair<'a>(mark: Mark, x: &'a [f64], before: &'a [f64], after: &'a [f64]) -> Vec<Series<'a>> {
    vec![
        Series::new("before", Ink::Before, mark, x, before),
        Series::new("after", Ink::After, mark, x, after),
    ]
}
