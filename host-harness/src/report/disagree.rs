//! Where model and log disagree: the disturbance that the log asks for, against everything it might follow, by
//! order of the motor angle, over wind-up, and along the log.

use std::fmt::Write;

use super::answer::{order_of, place};
use super::csv;
use super::free::{TIME, WIDTH};
use super::spectrum::{loops, spectrum};
use super::words::{capital, quantity, words};
use crate::discover::findings::{Answer, Findings, Shape};
use crate::estimate::record::Channel;
use crate::plot::text::{escape, per_cent, si};
use crate::plot::{Axis, Ink, Legend, Mark, Plot, Series, bands, legend};

const BEFORE: (Legend, &str) = (Legend::Of(Ink::Before), "refitted");
const AFTER: (Legend, &str) = (Legend::Of(Ink::After), "improved: with the effects");
const SAME: (Legend, &str) = (Legend::Of(Ink::After), "refitted; no effect was added");
const HELD_OUT: (Legend, &str) = (Legend::Shade, "no fit has seen it");
/// Width and height of a panel among others.
const PANEL: [f64; 2] = [262.0, 130.0];
/// Strongest orders that are listed.
const STRONGEST: usize = 6;

/// The section.
pub(super) fn section(page: &mut String, findings: &Findings) {
    if findings.disturbance.before.iter().all(|value| *value == 0.0 || !value.is_finite()) {
        return;
    }
    let equation = &findings.disturbance.equation;
    let _ = writeln!(
        page,
        "<h2>Where they disagree</h2>\n<p>{}. The disturbance is what the log asks to be added to the {} \
         equation at every moment, as a random walk.</p>\n{}",
        escape(&capital(&place(&findings.verdict.whereabouts))),
        escape(equation),
        legend(&keys(findings, &[HELD_OUT]))
    );
    leading(page, findings);
    along(page, findings);
    panels(page, findings);
    orders(page, findings);
    hysteresis(page, findings);
}

/// What leads: the coordinate of what has no name where something has none, else that of the whole disturbance.
fn leading_shape(findings: &Findings) -> &Shape {
    let budget = findings.verdict.budget.as_ref().filter(|budget| budget.unnamed > 0.0);
    let unknown = findings.verdict.verdict == Answer::Unknown;
    let follows = budget.and_then(|budget| budget.unnamed_follows.split(", ").next());
    let own = follows.and_then(|name| findings.courses.iter().find(|own| own.coordinate == name));
    own.filter(|_| unknown).unwrap_or(&findings.shape)
}

/// The disturbance against what it follows.
fn leading(page: &mut String, findings: &Findings) {
    let shape = leading_shape(findings);
    let (name, _) = quantity(&shape.coordinate);
    let title = format!("Disturbance of the {} against {name}", findings.disturbance.equation);
    page.push_str(&against(findings, title, shape).sized(WIDTH, 200.0).svg());
}

/// What the colours mean; where nothing was added there is one model.
fn keys(findings: &Findings, more: &[(Legend, &'static str)]) -> Vec<(Legend, &'static str)> {
    let models: &[_] = if added(findings) { &[BEFORE, AFTER] } else { &[SAME] };
    [models, more].concat()
}

fn added(findings: &Findings) -> bool {
    !findings.verdict.effects.is_empty()
}

fn disturbance(findings: &Findings) -> Axis<'static> {
    Axis::linear("disturbance", findings.disturbance.unit)
}

fn against<'a>(findings: &Findings, title: String, shape: &'a Shape) -> Plot<'a> {
    let (name, unit) = quantity(&shape.coordinate);
    let plot = Plot::new(title, Axis::linear(name, unit), disturbance(findings));
    let series = pair(findings, Mark::Dots, &shape.centres, [&shape.before, &shape.after]);
    Plot { series, ..plot }
}

/// Along the log, zoomed with the runs.
fn along(page: &mut String, findings: &Findings) {
    let push = &findings.disturbance;
    let title = format!("Disturbance of the {} along the log", push.equation);
    let plot = Plot::new(title, Axis::linear("time", "s"), disturbance(findings));
    let series = pair(findings, Mark::Line, &findings.time_s, [&push.before, &push.after]);
    let bands = bands(&findings.time_s, &findings.held_out);
    page.push_str(&Plot { series, bands, ..plot.sized(WIDTH, 140.0).linked(TIME) }.svg());
}

/// Against everything else, what explains most first.
fn panels(page: &mut String, findings: &Findings) {
    let shown = &leading_shape(findings).coordinate;
    let others = findings.courses.iter();
    let mut courses: Vec<&Shape> =
        others.filter(|own| own.coordinate != *shown && own.centres.len() > 1).collect();
    if courses.is_empty() {
        return;
    }
    courses.sort_by(|a, b| b.explained.total_cmp(&a.explained));
    page.push_str("<h3>The same against everything else</h3>\n<div class=\"panels\">\n");
    for own in courses {
        let (name, _) = quantity(&own.coordinate);
        let title = format!("{} ({})", capital(&name), per_cent(own.explained));
        let plot = against(findings, title, own).sized(PANEL[0], PANEL[1]);
        page.push_str(&Plot { zoom: false, ..plot }.svg());
    }
    page.push_str(
        "</div><p class=note>Means of the disturbance by bin; in brackets the share of its variance that the \
         coordinate explains in the refitted model.</p>\n",
    );
}

/// Amplitudes by order of the motor angle.
fn orders(page: &mut String, findings: &Findings) {
    let lines = spectrum(&findings.angles.motor_rad, &findings.orders, &findings.disturbance);
    if lines.is_empty() {
        return;
    }
    let column = |k: usize| -> Vec<f64> { lines.iter().map(|row| row[k]).collect() };
    let [order, before, after] = [0, 1, 2].map(column);
    let plot = Plot::new(
        "Order spectrum: amplitude of the disturbance by order of the motor angle",
        Axis::linear("order, per turn", ""),
        disturbance(findings),
    );
    let series = pair(findings, Mark::Bars, &order, [&before, &after]);
    page.push_str(&Plot { series, ..plot.sized(WIDTH, 130.0) }.svg());
    let mut strongest = lines;
    strongest.sort_by(|a, b| b[1].total_cmp(&a[1]));
    strongest.truncate(STRONGEST);
    let unit = findings.disturbance.unit;
    let names = if added(findings) { &["refitted", "improved"][..] } else { &["refitted"] };
    page.push_str("<table><tr><th>strongest orders, per turn");
    names.iter().for_each(|name| page.push_str(&format!("<th class=n>{name}")));
    for row in &strongest {
        let _ = write!(page, "</tr>\n<tr><td>{}", order_of(row[0]));
        for value in &row[1..=names.len()] {
            let _ = write!(page, "<td class=n>{}", escape(&si(*value, unit, 2)));
        }
    }
    page.push_str(
        "</tr></table>\n<p class=note>The disturbance is estimated as a random walk, so that fast lines show \
         smaller than they are.</p>\n",
    );
}

/// The disturbance over the wind-up, while it grows and while it falls.
fn hysteresis(page: &mut String, findings: &Findings) {
    let angles = &findings.angles;
    let push = &findings.disturbance;
    if angles.windup_rad.is_empty() || !csv::measured(findings).contains(&Channel::Output) {
        return;
    }
    let plot = Plot::new(
        "Hysteresis: disturbance against the wind-up of the last stage",
        Axis::linear("wind-up at the output", "rad"),
        disturbance(findings),
    );
    let mut series = Vec::new();
    let before = ("refitted", Ink::Before, &push.before);
    let models = match added(findings) {
        true => vec![before, ("improved", Ink::After, &push.after)],
        false => vec![("refitted", Ink::After, &push.after)],
    };
    for (name, ink, values) in models {
        let [growing, falling] = loops(&angles.windup_rad, values);
        for (way, mark, [x, y]) in
            [("growing", Mark::Line, growing), ("falling", Mark::Rings, falling)]
        {
            series.push(Series::new(format!("{name}, {way}"), ink, mark, x, y));
        }
    }
    page.push_str(&Plot { series, ..plot.sized(WIDTH, 180.0).explained() }.svg());
    page.push_str("<p class=note>Two courses apart are a loop: what the model misses there depends on how the wind-up came about.</p>\n");
}

/// Errors of the predictions one sample ahead.
pub(super) fn predictions(page: &mut String, findings: &Findings) {
    let channels = csv::measured(findings);
    if channels.is_empty() {
        return;
    }
    let _ = writeln!(
        page,
        "<h3>Errors of predictions one sample ahead</h3>\n{}",
        legend(&keys(findings, &[HELD_OUT]))
    );
    let bands = bands(&findings.time_s, &findings.held_out);
    for channel in channels {
        let c = channel as usize;
        let of = |rows: &[[f64; 3]]| -> Vec<f64> { rows.iter().map(|row| row[c]).collect() };
        let (before, after) = (of(&findings.before), of(&findings.after));
        let title = capital(&words(channel.column()));
        let errors = Axis::linear("error, noise sigmas", "");
        let plot = Plot::new(title, Axis::linear("time", "s"), errors);
        let series = pair(findings, Mark::Line, &findings.time_s, [&before, &after]);
        let plot = plot.sized(WIDTH, 100.0).linked(TIME);
        page.push_str(&Plot { series, bands: bands.clone(), ..plot }.svg());
    }
}

/// Both models' values, or those of one where they are the same.
fn pair<'a>(
    findings: &Findings,
    mark: Mark,
    x: &'a [f64],
    [before, after]: [&'a [f64]; 2],
) -> Vec<Series<'a>> {
    let after_series = Series::new("improved", Ink::After, mark, x, after);
    match added(findings) {
        true => vec![Series::new("refitted", Ink::Before, mark, x, before), after_series],
        false => vec![Series { name: "refitted".into(), ..after_series }],
    }
}
