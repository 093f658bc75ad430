//! The cross-check as a page: error over step, one panel per state, readable offline; then what fewer
//! micro-steps than the joint chooses cost, and error over instructions.

use std::fmt::Write;

use super::pareto::{self, Point};
use super::{CrossCheck, Row};
use crate::plot;
use crate::plot::text::escape;
use crate::plot::{Axis, Ink, Legend, Mark, Plot, Series, legend};

/// The steps that are run, µs, and a little beside them.
const STEPS: [f64; 4] = [10.0, 25.0, 50.0, 100.0];
const ACROSS: [f64; 2] = [8.0, 125.0];
/// A drive's own step, at which the study is drawn.
const DRIVE_STEP_US: f64 = 50.0;

impl CrossCheck {
    /// The page; the points are those of error over instructions.
    pub fn page(&self, points: &[Point]) -> String {
        let mut scenarios: Vec<&str> = self.rows.iter().map(|row| row.scenario).collect();
        scenarios.dedup();
        let mut states: Vec<&str> = Vec::new();
        for row in &self.rows {
            if !states.contains(&row.state.as_str()) {
                states.push(&row.state);
            }
        }
        let of_scenarios = scenarios.iter().enumerate();
        let of_scenarios = of_scenarios.map(|(k, name)| (Legend::Of(Ink::Nth(k)), *name));
        let colours: Vec<_> = of_scenarios.collect();
        let mut bounds =
            vec![(Legend::Dot, "f32"), (Legend::Ring, "f64"), (Legend::Level(Ink::Soft), "bound")];
        if !self.passed() {
            bounds.push((Legend::Of(Ink::Wrong), "beyond its bound"));
        }
        let count = |of: fn(&Row) -> bool| self.rows.iter().filter(|row| of(row)).count();
        let mut body = format!(
            "<p class=over>The embedded step against the reference</p>\n<div class=\"answer{}\">\
             <h1>{}</h1>\n<p class=first>{}</p></div>\n<p>Relative RMS error of each state over the step, in \
             as many micro-steps as the joint chooses, sampled every 100 µs over each scenario of \
             0.1 s of the paper's joint. Point at a dot for its number.</p>\n{}<div class=\"panels\">\n",
            if self.passed() { "" } else { " unknown" },
            match self.broken().len() {
                0 => "Every bound holds".to_owned(),
                1 => "One bound is broken".to_owned(),
                count => format!("{count} bounds are broken"),
            },
            format_args!(
                "{} of {} rows have a bound; {} are a study of forced micro-steps, which is promised nothing.",
                count(|row| row.bound.is_some()),
                self.rows.len(),
                count(|row| !row.chosen)
            ),
            legend(&[&colours[..], &bounds].concat())
        );
        for state in states {
            body.push_str(&self.panel(state, &scenarios).svg());
        }
        let _ = write!(
            body,
            "</div>\n<h2>Fewer micro-steps than the joint chooses</h2>\n<p>A study, without a bound: \
             the worst state of each scenario at a step of {DRIVE_STEP_US} µs in f32 where one and two \
             micro-steps are forced, and with as many as the joint chooses.</p>\n{}{}",
            legend(&colours),
            self.study(&scenarios).svg()
        );
        if !points.is_empty() {
            let _ = write!(
                body,
                "<h2>Error over instructions</h2>\n<p>The number beside a dot is that of micro-steps, \
                 or the step of an explicit method.</p>\n{}",
                pareto::plot(points).svg()
            );
        }
        let _ = write!(
            body,
            "<details><summary>Every run</summary><pre>{}</pre></details>",
            escape(&self.to_string())
        );
        plot::page("Cross-check", &body)
    }

    fn panel<'a>(&'a self, state: &'a str, scenarios: &[&'a str]) -> Plot<'a> {
        let of = |scenario: &str, scalar: &str| -> Vec<&Row> {
            let mut rows: Vec<&Row> = self
                .rows
                .iter()
                .filter(|row| row.step_us > 0.0 && row.chosen && row.state == state)
                .filter(|row| row.scenario == scenario && row.scalar == scalar)
                .collect();
            rows.sort_by(|a, b| a.step_us.total_cmp(&b.step_us));
            rows
        };
        let bounds = scenarios.first().map(|first| of(first, "f32")).unwrap_or_default();
        let bounds = bounds.into_iter().filter_map(|row| Some((row.step_us, 100.0 * row.bound?)));
        let (steps, most): (Vec<f64>, Vec<f64>) = bounds.unzip();
        let mut series = vec![Series::new("bound", Ink::Soft, Mark::Levels, steps, most)];
        for (k, scenario) in scenarios.iter().enumerate() {
            for (scalar, mark) in [("f64", Mark::Rings), ("f32", Mark::Dots)] {
                let rows = of(scenario, scalar);
                series.push(errors(&rows, Ink::Nth(k), mark, |row| row.step_us));
            }
        }
        let broken: Vec<&Row> = self
            .rows
            .iter()
            .filter(|row| row.step_us > 0.0 && row.state == state && !row.holds())
            .collect();
        series.push(errors(&broken, Ink::Wrong, Mark::Points, |row| row.step_us));
        let marked = STEPS.map(|step| (step, step.to_string())).to_vec();
        let steps = Axis::log("step", "µs").within(ACROSS).marked(marked);
        let most = broken.iter().map(|row| 150.0 * row.relative_rms).fold(10.0, f64::max);
        let up = Axis::log("error", "%").within([1e-5, most]);
        let plot = Plot::new(state, steps, up).sized(264.0, 190.0);
        Plot { series, zoom: false, ..plot }
    }

    /// The worst state of each scenario over the number of micro-steps.
    fn study<'a>(&'a self, scenarios: &[&'a str]) -> Plot<'a> {
        let of = |scenario: &str| -> Vec<&Row> {
            let own = self.rows.iter().filter(|row| {
                row.scenario == scenario && row.scalar == "f32" && row.step_us == DRIVE_STEP_US
            });
            let mut worst: Vec<&Row> = Vec::new();
            for row in own {
                match worst.iter_mut().find(|other| other.micro_steps == row.micro_steps) {
                    Some(other) if row.relative_rms > other.relative_rms => *other = row,
                    Some(_) => {}
                    None => worst.push(row),
                }
            }
            worst.sort_by_key(|row| row.micro_steps);
            worst
        };
        let all: Vec<Vec<&Row>> = scenarios.iter().map(|scenario| of(scenario)).collect();
        let mut counts: Vec<(u32, bool)> =
            all.iter().flatten().map(|row| (row.micro_steps, row.chosen)).collect();
        counts.sort_unstable();
        counts.dedup();
        let marked = counts.into_iter().map(|(count, chosen)| {
            (f64::from(count), format!("{count} {}", if chosen { "(chosen)" } else { "(forced)" }))
        });
        let across = Axis::log("micro-steps in a step", "").marked(marked.collect());
        let series = all.iter().enumerate();
        let series = series
            .map(|(k, rows)| errors(rows, Ink::Nth(k), Mark::Dots, |row| row.micro_steps.into()));
        let plot = Plot::new("Worst state", across, Axis::log("error", "%")).sized(560.0, 240.0);
        Plot { series: series.collect(), zoom: false, ..plot }
    }
}

/// The errors of rows, each with what it says.
fn errors<'a>(rows: &[&'a Row], ink: Ink, mark: Mark, across: fn(&Row) -> f64) -> Series<'a> {
    let shown = || rows.iter().filter(|row| row.relative_rms > 0.0);
    let notes = shown().map(|row| {
        format!(
            "{}, {}, {} µs, {} micro-steps, {}: {:.4} %",
            row.scenario,
            row.scalar,
            row.step_us,
            row.micro_steps,
            row.state,
            100.0 * row.relative_rms
        )
    });
    let name = rows.first().map_or("", |row| row.scenario);
    let x: Vec<f64> = shown().map(|row| across(row)).collect();
    let y: Vec<f64> = shown().map(|row| 100.0 * row.relative_rms).collect();
    Series { notes: notes.collect(), ..Series::new(name, ink, mark, x, y) }
}
