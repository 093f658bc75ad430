//! The figures in the paper's layout, and one page with all of them and the table.

use std::borrow::Cow;
use std::fmt::Write;

use super::Runs;
use super::numbers::Number;
use super::trace::Trace;
use crate::plot;
use crate::plot::text::{digits, escape};
use crate::plot::{Axis, Ink, Mark, Plot, Series, picture};

const LEVELS: [&str; 3] = ["motor", "1st stage", "2nd stage"];
/// A quantity and its unit.
type Quantity = (&'static str, &'static str);
const SPEED: Quantity = ("speed at the motor", "rad/s");
const ANGLE: Quantity = ("angle at the motor", "rad");
const DIFFERENCE: Quantity = ("motor less 2nd stage", "rad");
const SHARE: Quantity = ("speed over the reference's amplitude", "");
const CURRENT: Quantity = ("current", "A");
/// Width and height of a panel's field, pixels.
const SIZE: [f64; 2] = [760.0, 200.0];

/// A figure: panels one above the other, as the paper stacks its a), b) and c).
pub struct Figure<'a> {
    /// Its file's name.
    pub file: String,
    /// What it shows.
    pub title: String,
    /// From the top down.
    panels: Vec<Plot<'a>>,
}

impl<'a> Figure<'a> {
    fn new(file: String, title: String, panels: Vec<Plot<'a>>) -> Self {
        let lettered = panels.into_iter().zip('a'..).map(|(panel, letter)| Plot {
            title: format!("{letter}) {}", panel.title).into(),
            ..panel
        });
        Self { file, title, panels: lettered.collect() }
    }

    /// As an SVG file.
    pub fn picture(&self) -> String {
        picture(&self.panels)
    }
}

/// Every figure with both motors, and the numerical claim.
pub fn figures(runs: &Runs) -> Vec<Figure<'_>> {
    let mut all = Vec::new();
    for (six_step, suffix, motor) in
        [(false, "", "prescribed motor"), (true, "-six-step", "six-step motor")]
    {
        let of = |file| runs.of(file, six_step);
        let mut add = |number: &str, title: &str, panels| {
            let title = format!("Fig. {number}: {title}, {motor}");
            all.push(Figure::new(format!("figure{number}{suffix}.svg"), title, panels));
        };
        let (free, sine, step) = (of("figure06"), of("figure08"), of("figure09"));
        add(
            "06",
            "speed of the gear stages without load",
            vec![
                reference(free),
                speeds(free, "output speed of the first and second stage", None),
                speeds(free, "the change from -300 to 500 rad/s", Some([0.0505, 0.0605])),
            ],
        );
        add(
            "07",
            "angle of the gear stages without load",
            vec![
                angles(free, "output position of the gear stages", None),
                angles(free, "magnified", Some([0.0195, 0.0205])),
                windup(free),
            ],
        );
        add(
            "08",
            "gear stages under a sine load",
            vec![
                speeds(sine, "output speed of the gear stages", None),
                angles(sine, "output position of the gear stages", None),
                windup(sine),
            ],
        );
        add(
            "09",
            "speed of the gear stages with a step load at 0.01 s",
            vec![
                speeds(step, "output speed of the gear stages", None),
                speeds(step, "magnified", Some([0.0095, 0.0145])),
            ],
        );
        add(
            "10",
            "angle of the gear stages with a step load at 0.01 s",
            vec![
                angles(step, "output angles of the gear stages", None),
                angles(step, "magnified", Some([0.009, 0.013])),
                windup(step),
            ],
        );
        add(
            "11",
            "speed over its amplitude at the motor",
            vec![
                normalised(of("figure11_start_stop"), "start-stop", None),
                normalised(of("figure11_forward_reverse"), "forward-reverse", None),
                normalised(of("figure11_forward_reverse"), "a reversal", Some([0.023, 0.034])),
            ],
        );
    }
    all.push(Figure::new(
        "commutation.svg".to_owned(),
        "Equations (4) to (10): three phases and their DC equivalent".to_owned(),
        commutation(runs),
    ));
    all.push(Figure::new(
        "claim.svg".to_owned(),
        "Section 5.1: error over step and over cost".to_owned(),
        claim(runs),
    ));
    all
}

fn panel<'a>(
    title: &'a str,
    (quantity, unit): Quantity,
    window: Option<[f64; 2]>,
    series: Vec<Series<'a>>,
) -> Plot<'a> {
    let time = Axis::linear("t", "s").within(window);
    let plot = Plot::new(title, time, Axis::linear(quantity, unit));
    Plot { series, size: SIZE, ..plot.explained() }
}

/// The first of some is black.
fn line<'a>(k: usize, name: &'a str, x: &'a [f64], y: impl Into<Cow<'a, [f64]>>) -> Series<'a> {
    let ink = k.checked_sub(1).map_or(Ink::Text, Ink::Nth);
    Series::new(name, ink, Mark::Line, x, y)
}

fn reference(trace: &Trace) -> Plot<'_> {
    let lines = vec![line(0, "reference", &trace.time_s, &trace.reference)];
    panel("reference speed of the motor", SPEED, None, lines)
}

/// The stages swing around the motor, which is drawn first.
fn levels<'a>(trace: &'a Trace, values: Vec<Cow<'a, [f64]>>) -> Vec<Series<'a>> {
    let named = LEVELS.iter().enumerate().zip(values);
    named.map(|((k, name), values)| line(k, name, &trace.time_s, values)).collect()
}

fn borrowed(values: &[Vec<f64>]) -> Vec<Cow<'_, [f64]>> {
    values.iter().map(Cow::from).collect()
}

fn speeds<'a>(trace: &'a Trace, title: &'a str, window: Option<[f64; 2]>) -> Plot<'a> {
    panel(title, SPEED, window, levels(trace, borrowed(&trace.speed)))
}

fn angles<'a>(trace: &'a Trace, title: &'a str, window: Option<[f64; 2]>) -> Plot<'a> {
    panel(title, ANGLE, window, levels(trace, borrowed(&trace.angle)))
}

fn windup(trace: &Trace) -> Plot<'_> {
    let lines = vec![line(0, "motor less 2nd stage", &trace.time_s, trace.windup())];
    panel("difference of the angles, at the motor", DIFFERENCE, None, lines)
}

fn normalised<'a>(trace: &'a Trace, title: &'a str, window: Option<[f64; 2]>) -> Plot<'a> {
    let top = super::trace::peak(&trace.reference).max(f64::MIN_POSITIVE);
    let scaled = trace.speed.iter().map(|level| level.iter().map(|v| v / top).collect());
    panel(title, SHARE, window, levels(trace, scaled.collect()))
}

fn commutation(runs: &Runs) -> Vec<Plot<'_>> {
    let found = &runs.commutation;
    let line = |k, name, y| line(k, name, &found.time_s, y);
    let [a, b, c] = &found.phases_a;
    let [three, one] = &found.speed;
    let magnified = found.time_s.first().map(|start| [*start, start + 4e-4]);
    let phases = [a, b, c].into_iter().zip(["a", "b", "c"]).enumerate();
    let phases = phases.map(|(k, (y, name))| line(k, name, Cow::from(y))).collect();
    vec![
        panel("phase currents", CURRENT, None, phases),
        panel(
            "torque over k_t",
            CURRENT,
            magnified,
            vec![
                line(0, "three phases", Cow::from(&found.torque_a)),
                line(1, "DC equivalent", Cow::from(&found.equivalent_a)),
            ],
        ),
        panel(
            "where they differ: torque of three phases less that of (10), over it",
            ("share", ""),
            None,
            vec![line(0, "difference", Cow::from(found.difference()))],
        ),
        panel(
            "speed",
            ("speed", "rad/s"),
            None,
            vec![
                line(0, "three phases", Cow::from(three)),
                line(1, "DC equivalent", Cow::from(one)),
            ],
        ),
    ]
}

fn claim(runs: &Runs) -> Vec<Plot<'_>> {
    let claim = &runs.claim;
    let methods = [
        ("Bogacki-Shampine", &claim.explicit),
        ("the drive's step, f32", &claim.embedded),
        ("never divided", &claim.undivided),
    ];
    let panel = |title, across, of: fn(&super::claim::Point) -> f64| {
        let mut series: Vec<Series<'_>> = methods
            .iter()
            .enumerate()
            .map(|(k, (name, points))| {
                let finite = || points.iter().filter(|point| point.error.is_finite());
                let x: Vec<f64> = finite().map(of).collect();
                let y: Vec<f64> = finite().map(|point| 100.0 * point.error).collect();
                Series::new(*name, Ink::Nth(k), Mark::Dots, x, y)
            })
            .collect();
        let all = || series.iter().flat_map(|series| series.x.iter().copied());
        let ends = vec![all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max)];
        series.push(Series::new("1 %", Ink::Soft, Mark::Line, ends, vec![1.0; 2]));
        let up = Axis::log("worst relative RMS error of a state", "%");
        Plot { series, size: SIZE, ..Plot::new(title, across, up).explained() }
    };
    vec![
        panel("error over step", Axis::log("step", "µs"), |point| point.step_us),
        panel(
            "error over cost",
            Axis::log("time over that of Bogacki-Shampine at 0.1 µs", ""),
            |point| point.cost,
        ),
    ]
}

/// How many numbers agree, every figure, and the table, as one page that opens offline.
pub fn page(numbers: &[Number], figures: &[Figure<'_>]) -> String {
    let agree = numbers.iter().filter(|row| row.agrees).count();
    let tuned = numbers.iter().filter(|row| row.tuned).count();
    let class = if agree == numbers.len() { "" } else { " effect" };
    let mut body = format!(
        "<p class=over>The paper, reproduced</p>\n<div class=\"answer{class}\"><h1>{agree} of {} numbers of \
         the paper agree</h1>\n<p class=first>{tuned} of them were used to tune what the paper leaves open.</p>\n",
        numbers.len()
    );
    let apart: Vec<&Number> = numbers.iter().filter(|row| !row.agrees).collect();
    if !apart.is_empty() {
        body.push_str("<p>These do not:</p>\n<ul>");
        for row in apart {
            let unit = if row.unit == "1" { "" } else { row.unit };
            let _ = write!(
                body,
                "<li>figure {}, {}: {} {unit} in the paper, {} {unit} here",
                escape(&row.figure),
                escape(&row.quantity),
                escape(&row.paper.to_string()),
                digits(row.ours, 3)
            );
        }
        body.push_str("</ul>\n");
    }
    body.push_str("</div>\n");
    for figure in figures {
        let _ = writeln!(body, "<h2>{}</h2>", escape(&figure.title));
        figure.panels.iter().for_each(|panel| body.push_str(&panel.svg()));
    }
    table(&mut body, numbers);
    plot::page("The paper, reproduced", &body)
}

/// Every number beside ours.
fn table(body: &mut String, numbers: &[Number]) {
    body.push_str(
        "<h2>Every number</h2>\n<div class=wide><table class=cards><tr><th>quantity<th>figure<th class=n>paper<th class=n>ours\
         <th>unit<th>agrees<th>note</tr>\n",
    );
    for row in numbers {
        let _ = writeln!(
            body,
            "<tr class={}><td>{}<td data-h=figure>{}<td class=n data-h=paper>{}<td class=n data-h=ours>{}<td data-h=unit>{}\
             <td data-h=agrees>{}{}<td data-h=note>{}</tr>",
            if row.agrees { "yes" } else { "no" },
            escape(&row.quantity),
            escape(&row.figure),
            escape(&row.paper.to_string()),
            digits(row.ours, 3),
            row.unit,
            if row.agrees { "yes" } else { "no" },
            if row.tuned { ", tuned" } else { "" },
            escape(&row.note)
        );
    }
    body.push_str("</table></div>\n");
}
