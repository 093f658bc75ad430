//! The cross-check as a page: error over step, one panel per state, readable offline.
//!
//! Plain SVG in one HTML file; every point says its number when it is pointed at.

use std::fmt::Write;

use super::{CrossCheck, Row};

const WIDTH: f64 = 360.0;
const HEIGHT: f64 = 250.0;
const LEFT: f64 = 54.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 26.0;
const BOTTOM: f64 = 36.0;
/// Decades of relative error shown, as powers of ten.
const DECADES: (i32, i32) = (-7, 0);
const COLOURS: [&str; 8] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#555555", "#a6761d"];

impl CrossCheck {
    /// The page.
    pub fn page(&self) -> String {
        let mut scenarios: Vec<&str> = self.rows.iter().map(|row| row.scenario).collect();
        scenarios.dedup();
        let mut states: Vec<&str> = Vec::new();
        for row in &self.rows {
            if !states.contains(&row.state.as_str()) {
                states.push(&row.state);
            }
        }
        let mut page = String::from(HEAD);
        page.push_str("<p class=legend>");
        for (scenario, colour) in scenarios.iter().zip(COLOURS.iter().cycle()) {
            let _ = write!(page, "<span style=\"color:{colour}\">&#9679; {scenario}</span> ");
        }
        page.push_str("<span>&#9679; f32, rule's micro-steps</span> <span>&#9675; f64</span> ");
        page.push_str("<span>grey bar: bound</span></p>\n<div class=panels>\n");
        for state in states {
            self.panel(&mut page, state, &scenarios);
        }
        let _ = write!(page, "</div>\n<pre>{self}</pre>\n</body></html>\n");
        page
    }

    fn panel(&self, page: &mut String, state: &str, scenarios: &[&str]) {
        let _ = write!(
            page,
            "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" width={WIDTH} height={HEIGHT}>\
             <text x={LEFT} y=16 class=title>{state}</text>"
        );
        axes(page);
        let of = |scenario: &str, scalar: &str| -> Vec<&Row> {
            let mut rows: Vec<&Row> = self
                .rows
                .iter()
                .filter(|row| row.method == "embedded" && row.chosen && row.state == state)
                .filter(|row| row.scenario == scenario && row.scalar == scalar)
                .collect();
            rows.sort_by(|a, b| a.step_us.total_cmp(&b.step_us));
            rows
        };
        for row in scenarios.first().map(|first| of(first, "f32")).unwrap_or_default() {
            if let Some(bound) = row.bound {
                let (x, y) = (across(row.step_us), up(bound));
                let (from, to) = (x - 16.0, x + 16.0);
                let _ = write!(page, "<path d=\"M{from:.1} {y:.1}H{to:.1}\" class=bound />");
            }
        }
        for (scenario, colour) in scenarios.iter().zip(COLOURS.iter().cycle()) {
            line(page, &of(scenario, "f32"), colour, colour);
            line(page, &of(scenario, "f64"), colour, "none");
        }
        page.push_str("</svg>\n");
    }
}

fn line(page: &mut String, rows: &[&Row], colour: &str, fill: &str) {
    let shown: Vec<_> = rows.iter().filter(|row| row.relative_rms > 0.0).collect();
    let mut path = String::new();
    for (k, row) in shown.iter().enumerate() {
        let command = if k == 0 { 'M' } else { 'L' };
        let _ = write!(path, "{command}{:.1} {:.1}", across(row.step_us), up(row.relative_rms));
    }
    let dash = if fill == "none" { " stroke-dasharray=\"2 3\"" } else { "" };
    let _ = write!(page, "<path d=\"{path}\" fill=none stroke=\"{colour}\"{dash} />");
    for row in shown {
        let _ = write!(
            page,
            "<circle cx={:.1} cy={:.1} r=3 fill=\"{fill}\" stroke=\"{colour}\"><title>{}, {}, {} µs, \
             {} micro-steps: {:.4} %</title></circle>",
            across(row.step_us),
            up(row.relative_rms),
            row.scenario,
            row.scalar,
            row.step_us,
            row.micro_steps,
            100.0 * row.relative_rms
        );
    }
}

fn axes(page: &mut String) {
    let (right, bottom) = (WIDTH - RIGHT, HEIGHT - BOTTOM);
    for decade in DECADES.0..=DECADES.1 {
        let y = up(10.0_f64.powi(decade));
        let (label, per_cent) = (LEFT - 5.0, decade + 2);
        let text = if (-2..=2).contains(&per_cent) {
            format!("{} %", 10.0_f64.powi(per_cent))
        } else {
            format!("1e{per_cent} %")
        };
        let _ = write!(
            page,
            "<path d=\"M{LEFT} {y:.1}H{right}\" class=grid /><text x={label} y={:.1} \
             text-anchor=end>{text}</text>",
            y + 3.5
        );
    }
    for step in [10.0, 25.0, 50.0, 100.0] {
        let x = across(step);
        let _ = write!(
            page,
            "<path d=\"M{x:.1} {TOP}V{bottom}\" class=grid /><text x={x:.1} y={:.1} \
             text-anchor=middle>{step}</text>",
            bottom + 14.0
        );
    }
    let _ = write!(
        page,
        "<text x={:.1} y={:.1} text-anchor=middle>step, µs</text>",
        0.5 * (LEFT + right),
        HEIGHT - 6.0
    );
}

/// Place of a step on the axis from 8 to 125 µs.
fn across(step_us: f64) -> f64 {
    let share = (step_us / 8.0).ln() / (125.0_f64 / 8.0).ln();
    LEFT + share * (WIDTH - LEFT - RIGHT)
}

/// Place of a relative error, kept inside the panel.
fn up(error: f64) -> f64 {
    let (low, high) = (f64::from(DECADES.0), f64::from(DECADES.1));
    let share = (error.log10().clamp(low, high) - low) / (high - low);
    HEIGHT - BOTTOM - share * (HEIGHT - TOP - BOTTOM)
}

const HEAD: &str = "<!doctype html>
<html lang=en><head><meta charset=utf-8><title>Cross-check</title><style>
body{font:14px system-ui,sans-serif;margin:24px;color:#222;background:#fff}
.panels{display:flex;flex-wrap:wrap;gap:12px}
svg text{font:10px system-ui,sans-serif;fill:#444}
svg .title{font-size:13px;fill:#000}
.grid{stroke:#e4e4e4;fill:none}
.bound{stroke:#888;stroke-width:3;fill:none}
.legend span{margin-right:14px}
pre{font-size:12px;overflow-x:auto}
</style></head><body>
<h1>The embedded step against the reference</h1>
<p>Relative RMS error of each state over the step, sampled every 100 µs over each scenario of
0.1 s of the paper's joint. Point at a dot for its number.</p>
";
