//! The page, top down: the answer, how far, where, and then what one needs to believe it.

use std::fmt::Write;

use super::plot::{Mark, Plot, Series};
use super::series::bands;
use super::text::{escape, number};
use super::{answer, csv, gap, tables};
use crate::discover::findings::Findings;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
const LEGEND: &str = "<p class=legend><span class=\"key before\"></span> before: the nominal \
    structure, refitted <span class=\"key after\"></span> after: with the effects found";
/// Strongest orders that are listed.
const STRONGEST: usize = 6;

/// Writes the page.
pub(super) fn page(findings: &Findings) -> String {
    let verdict = &findings.verdict;
    let name = escape(&findings.nominal.name);
    let class = verdict.verdict.name();
    let mut page = format!(
        "<!doctype html>\n<html lang=en><head><meta charset=utf-8>\
         <meta name=viewport content=\"width=device-width\"><title>{name}: {class}</title>\
         <style>{STYLE}</style></head><body>\n<h1>What the model of {name} misses</h1>\n\
         <div class=\"answer {class}\"><p class=first>{}</p><p>{}</p></div>\n",
        answer::sentence(findings),
        answer::gap(findings)
    );
    tables::effects(&mut page, &verdict.effects);
    let _ = writeln!(
        page,
        "<h2>How far</h2>{LEGEND} <span class=\"key floor\"></span> floor: what noise alone \
         leaves</p>"
    );
    gap::section(&mut page, &verdict.gap);
    if let Some(budget) = &verdict.budget {
        let _ = writeln!(page, "<p>{}</p>", escape(&answer::budget(budget)));
    }
    tables::free_run(&mut page, &verdict.free_run);
    whereabouts(&mut page, findings);
    residuals(&mut page, findings);
    page.push_str("<h2>Why</h2>\n<ul>");
    for reason in &verdict.reasons {
        let _ = write!(page, "<li>{}</li>", escape(reason));
    }
    let _ = writeln!(page, "</ul>\n<h2>What to measure next</h2>\n<p>{}</p>", {
        escape(&verdict.next_experiment)
    });
    page.push_str(
        "<h2>Hypotheses</h2>\n<p class=note>Score: what the linear step promises to take from \
         minus twice the log-likelihood. Refitted gain: what the full refit did take.</p>\n",
    );
    tables::hypotheses(&mut page, findings);
    page.push_str("<h2>Parameters</h2>\n");
    tables::parameters(&mut page, &findings.parameters);
    page.push_str("<p class=note>Pale: the log says little about it.</p>\n<h2>Noises</h2>\n");
    tables::noises(&mut page, &findings.noises);
    let _ = writeln!(
        page,
        "<h2>The improved model</h2>\n<pre>{}</pre>\n<p class=note>Found in {} s.</p>\n\
         <script>{SCRIPT}</script></body></html>",
        escape(&findings.improved.to_toml()),
        number(verdict.seconds)
    );
    page
}

fn whereabouts(page: &mut String, findings: &Findings) {
    let (push, shape) = (&findings.push, &findings.shape);
    let equation = if push.equation.is_empty() { "equation" } else { &push.equation };
    let up = format!("push, {}", push.unit);
    let _ = writeln!(
        page,
        "<h2>Where they disagree</h2>\n<p>Where the refitted model and the log disagree, {}. The \
         push is what the log asks to be added to that equation, wandering freely.</p>{LEGEND}</p>",
        answer::place(&findings.verdict.whereabouts)
    );
    Plot {
        title: &format!("Push on the {equation} against {}", shape.coordinate),
        across: &shape.coordinate,
        up: &up,
        height: 190.0,
        mark: Mark::Dots,
        bands: &[],
        series: &pair(&shape.centres, &shape.before, &shape.after),
    }
    .draw(page);
    Plot {
        title: &format!("Push on the {equation} along the log"),
        across: "t, s",
        up: &up,
        height: 150.0,
        mark: Mark::Line,
        bands: &bands(&findings.time_s, &findings.held_out),
        series: &pair(&findings.time_s, &push.before, &push.after),
    }
    .draw(page);
    orders(page, findings, &up);
}

fn orders(page: &mut String, findings: &Findings, up: &str) {
    let column = |k: usize| -> Vec<f64> { findings.orders.iter().map(|row| row[k]).collect() };
    Plot {
        title: "Amplitude of the push by order of the motor angle",
        across: "order, per turn",
        up,
        height: 120.0,
        mark: Mark::Stems,
        bands: &[],
        series: &pair(&column(0), &column(1), &column(2)),
    }
    .draw(page);
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
    let _ = writeln!(
        page,
        "<h2>Prediction errors</h2>\n{LEGEND} <span class=\"key band\"></span> held out: no \
         fit has seen it</p>"
    );
    let bands = bands(&findings.time_s, &findings.held_out);
    for channel in csv::measured(findings) {
        let c = channel as usize;
        let before: Vec<f64> = findings.before.iter().map(|row| row[c]).collect();
        let after: Vec<f64> = findings.after.iter().map(|row| row[c]).collect();
        Plot {
            title: channel.column(),
            across: "t, s",
            up: "error, noise sigmas",
            height: 140.0,
            mark: Mark::Line,
            bands: &bands,
            series: &pair(&findings.time_s, &before, &after),
        }
        .draw(page);
    }
    page.push_str(
        "<p class=note>Drag across a plot to zoom, double-click to see all of it again, point at \
         it for numbers. All numbers are in residuals.csv.</p>\n",
    );
}

fn pair<'a>(x: &'a [f64], before: &'a [f64], after: &'a [f64]) -> [Series<'a>; 2] {
    [Series { name: "before", x, y: before }, Series { name: "after", x, y: after }]
}
