//! The figures in the paper's layout, and one page with all of them and the table.

use std::fmt::Write;

use super::Runs;
use super::figure::{Axes, Line, Panel, svg};
use super::numbers::Number;
use super::trace::Trace;
use crate::report::text::{digits, escape};

const LEVELS: [&str; 3] = ["motor", "1st stage", "2nd stage"];
const TIME: &str = "t, s";
const SPEED: &str = "speed at the motor, rad/s";
const ANGLE: &str = "angle at the motor, rad";
const DIFFERENCE: &str = "motor less 2nd stage, rad";

/// A picture: its file's name, what it shows, and the drawing.
pub(super) type Figure = (String, String, String);

/// Every figure with both motors, and the numerical claim.
pub fn figures(runs: &Runs) -> Vec<Figure> {
    let mut all = Vec::new();
    for (six_step, suffix, motor) in
        [(false, "", "prescribed motor"), (true, "-six-step", "six-step motor")]
    {
        let of = |file| runs.of(file, six_step);
        let mut add = |number: &str, title: &str, panels: Vec<Panel>| {
            let title = format!("Fig. {number}: {title}, {motor}");
            all.push((format!("figure{number}{suffix}.svg"), title, svg(&panels)));
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
    all.push((
        "commutation.svg".to_owned(),
        "Equations (4) to (10): three phases and their DC equivalent".to_owned(),
        svg(&commutation(runs)),
    ));
    all.push((
        "claim.svg".to_owned(),
        "Section 5.1: error over step and over cost".to_owned(),
        svg(&claim(runs)),
    ));
    all
}

fn panel(title: &str, up: &'static str, window: Option<[f64; 2]>, lines: Vec<Line>) -> Panel {
    let title = title.to_owned();
    Panel { title, across: TIME, up, window, axes: Axes::Linear, lines }
}

fn line(trace: &Trace, name: &str, values: &[f64]) -> Line {
    Line { name: name.to_owned(), x: trace.time_s.clone(), y: values.to_vec() }
}

fn reference(trace: &Trace) -> Panel {
    let lines = vec![line(trace, "reference", &trace.reference)];
    panel("reference speed of the motor", SPEED, None, lines)
}

fn levels(trace: &Trace, values: &[Vec<f64>]) -> Vec<Line> {
    let named = LEVELS.iter().zip(values);
    // The motor is drawn last, over the stages that swing around it.
    named.map(|(name, values)| line(trace, name, values)).collect()
}

fn speeds(trace: &Trace, title: &str, window: Option<[f64; 2]>) -> Panel {
    panel(title, SPEED, window, levels(trace, &trace.speed))
}

fn angles(trace: &Trace, title: &str, window: Option<[f64; 2]>) -> Panel {
    panel(title, ANGLE, window, levels(trace, &trace.angle))
}

fn windup(trace: &Trace) -> Panel {
    let lines = vec![line(trace, "motor less 2nd stage", &trace.windup())];
    panel("difference of the angles, at the motor", DIFFERENCE, None, lines)
}

fn normalised(trace: &Trace, title: &str, window: Option<[f64; 2]>) -> Panel {
    let top = super::trace::peak(&trace.reference).max(f64::MIN_POSITIVE);
    let scaled: Vec<Vec<f64>> =
        trace.speed.iter().map(|level| level.iter().map(|v| v / top).collect()).collect();
    panel(title, "speed over the reference's amplitude", window, levels(trace, &scaled))
}

fn commutation(runs: &Runs) -> Vec<Panel> {
    let found = &runs.commutation;
    let line = |name: &str, y: &[f64]| Line {
        name: name.to_owned(),
        x: found.time_s.clone(),
        y: y.to_vec(),
    };
    let [a, b, c] = &found.phases_a;
    let [three, one] = &found.speed;
    let magnified = found.time_s.first().map(|start| [*start, start + 4e-4]);
    vec![
        panel("phase currents", "current, A", None, vec![line("a", a), line("b", b), line("c", c)]),
        panel(
            "torque over k_t",
            "current, A",
            magnified,
            vec![line("three phases", &found.torque_a), line("DC equivalent", &found.equivalent_a)],
        ),
        panel(
            "where they differ: torque of three phases less that of (10), over it",
            "share",
            None,
            vec![line("difference", &found.difference())],
        ),
        panel(
            "speed",
            "speed, rad/s",
            None,
            vec![line("three phases", three), line("DC equivalent", one)],
        ),
    ]
}

fn claim(runs: &Runs) -> Vec<Panel> {
    let claim = &runs.claim;
    let methods = [
        ("Bogacki-Shampine", &claim.explicit),
        ("the drive's step, f32", &claim.embedded),
        ("never divided", &claim.undivided),
    ];
    let lines = |of: fn(&super::claim::Point) -> f64| {
        let mut lines: Vec<Line> = methods
            .iter()
            .map(|(name, points)| {
                let finite = || points.iter().filter(|point| point.error.is_finite());
                Line {
                    name: (*name).to_owned(),
                    x: finite().map(of).collect(),
                    y: finite().map(|point| point.error).collect(),
                }
            })
            .collect();
        let all: Vec<f64> = lines.iter().flat_map(|line| line.x.clone()).collect();
        let low = all.iter().copied().fold(f64::INFINITY, f64::min);
        let high = all.iter().copied().fold(0.0, f64::max);
        lines.push(Line { name: "1 %".to_owned(), x: vec![low, high], y: vec![0.01, 0.01] });
        lines
    };
    let panel = |title: &str, across, lines| Panel {
        title: title.to_owned(),
        across,
        up: "worst relative RMS error of a state",
        window: None,
        axes: Axes::Logarithmic,
        lines,
    };
    vec![
        panel("error over step", "step, us", lines(|point| point.step_us)),
        panel(
            "error over cost",
            "time over that of Bogacki-Shampine at 0.1 us",
            lines(|point| point.cost),
        ),
    ]
}

/// The table and every figure as one page that opens offline.
pub fn page(numbers: &[Number], figures: &[Figure]) -> String {
    let mut page = String::from(
        "<!doctype html><html lang=en><head><meta charset=utf-8><title>The paper, reproduced</title>\
         <style>body{font:14px sans-serif;max-width:60rem;margin:1rem auto;padding:0 1rem}\
         table{border-collapse:collapse}td,th{border-bottom:1px solid #ddd;padding:.2rem .5rem;\
         text-align:left;vertical-align:top}.no{background:#fdeee6}svg{max-width:100%;height:auto}\
         </style></head><body><h1>The paper, reproduced</h1>\
         <table><tr><th>figure<th>quantity<th>unit<th>paper<th>ours<th>agrees<th>note</tr>\n",
    );
    for row in numbers {
        let _ = writeln!(
            page,
            "<tr class={}><td>{}<td>{}<td>{}<td>{}<td>{}<td>{}{}<td>{}</tr>",
            if row.agrees { "yes" } else { "no" },
            escape(&row.figure),
            escape(&row.quantity),
            row.unit,
            escape(&row.paper.to_string()),
            digits(row.ours, 3),
            if row.agrees { "yes" } else { "no" },
            if row.tuned { ", tuned" } else { "" },
            escape(&row.note)
        );
    }
    page.push_str("</table>\n");
    for (_, title, drawing) in figures {
        // Clip paths are named by panel; each drawing keeps its own.
        let own = drawing.replace("id=\"p", &format!("id=\"{}-p", slug(title)));
        let own = own.replace("url(#p", &format!("url(#{}-p", slug(title)));
        let _ = writeln!(page, "<h2>{}</h2>\n{own}", escape(title));
    }
    page.push_str("</body></html>\n");
    page
}

fn slug(title: &str) -> String {
    title.chars().filter(char::is_ascii_alphanumeric).collect()
}
