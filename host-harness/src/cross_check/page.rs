//! The cross-check as a page: error over step, one panel per state, readable offline.
//!
//! Plain SVG in one HTML file; every point says its number when it is pointed at.

use std::fmt::Write;

use super::chart::Chart;
use super::{CrossCheck, Row};

/// Each panel: steps from 8 to 125 µs, decades of relative error.
const CHART: Chart = Chart {
    width: 360.0,
    height: 250.0,
    left: 54.0,
    right: 12.0,
    top: 26.0,
    bottom: 36.0,
    across: (0.903_09, 2.096_91),
    up: (-7.0, 0.0),
};
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
        let Chart { width, height, left, .. } = CHART;
        let _ = write!(
            page,
            "<svg viewBox=\"0 0 {width} {height}\" width={width} height={height}>\
             <text x={left} y=16 class=title>{state}</text>"
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
                let (x, y) = (CHART.x(row.step_us), CHART.y(bound));
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
    let path = CHART.path(shown.iter().map(|row| (row.step_us, row.relative_rms)));
    let dash = if fill == "none" { " stroke-dasharray=\"2 3\"" } else { "" };
    let _ = write!(page, "<path d=\"{path}\" fill=none stroke=\"{colour}\"{dash} />");
    for row in shown {
        let _ = write!(
            page,
            "<circle cx={:.1} cy={:.1} r=3 fill=\"{fill}\" stroke=\"{colour}\"><title>{}, {}, {} µs, \
             {} micro-steps: {:.4} %</title></circle>",
            CHART.x(row.step_us),
            CHART.y(row.relative_rms),
            row.scenario,
            row.scalar,
            row.step_us,
            row.micro_steps,
            100.0 * row.relative_rms
        );
    }
}

fn axes(page: &mut String) {
    let Chart { left, top, .. } = CHART;
    let (right, bottom) = (CHART.end(), CHART.floor());
    for decade in CHART.up.0 as i32..=CHART.up.1 as i32 {
        let y = CHART.y(10.0_f64.powi(decade));
        let (label, per_cent) = (left - 5.0, decade + 2);
        let text = if (-2..=2).contains(&per_cent) {
            format!("{} %", 10.0_f64.powi(per_cent))
        } else {
            format!("1e{per_cent} %")
        };
        let _ = write!(
            page,
            "<path d=\"M{left} {y:.1}H{right}\" class=grid /><text x={label} y={:.1} \
             text-anchor=end>{text}</text>",
            y + 3.5
        );
    }
    for step in [10.0, 25.0, 50.0, 100.0] {
        let x = CHART.x(step);
        let _ = write!(
            page,
            "<path d=\"M{x:.1} {top}V{bottom}\" class=grid /><text x={x:.1} y={:.1} \
             text-anchor=middle>{step}</text>",
            bottom + 14.0
        );
    }
    let _ = write!(
        page,
        "<text x={:.1} y={:.1} text-anchor=middle>step, µs</text>",
        0.5 * (left + right),
        CHART.height - 6.0
    );
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
