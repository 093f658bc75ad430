//! What an observer found, drawn over what is true.

use super::score::Guess;
use crate::reproduce::figure::{Axes, Line, Panel, svg};

/// Load, last wind-up and friction against time, and of each the error between two standard
/// deviations either side.
pub fn plot(title: &str, step_s: f64, truth: &[Guess], found: &[Guess], sigma: &[Guess]) -> String {
    let time: Vec<f64> = (0..truth.len()).map(|k| k as f64 * step_s).collect();
    let line = |name: &str, y: Vec<f64>| Line { name: name.to_owned(), x: time.clone(), y };
    let panels = |what: &str, up: &'static str, value: fn(&Guess) -> f64| {
        let of = |rows: &[Guess]| -> Vec<f64> { rows.iter().map(value).collect() };
        // While it starts an estimate may be off the page.
        let from = truth.len() / 50;
        let deviation = |sign: f64| -> Vec<f64> {
            let all = sigma.iter().map(|s| sign * 2.0 * value(s)).enumerate();
            all.map(|(k, v)| if k < from { f64::NAN } else { v }).collect()
        };
        let errors = found.iter().zip(truth).map(|(f, t)| value(f) - value(t)).enumerate();
        let errors = errors.map(|(k, v)| if k < from { f64::NAN } else { v }).collect();
        let panel = |title: String, lines: Vec<Line>| Panel {
            title,
            across: "time, s",
            up,
            window: None,
            axes: Axes::Linear,
            lines,
        };
        [
            panel(
                format!("{title}: {what}"),
                vec![line("truth", of(truth)), line("estimate", of(found))],
            ),
            panel(
                "its error, and two standard deviations".to_owned(),
                vec![
                    line("+2 σ", deviation(1.0)),
                    line("−2 σ", deviation(-1.0)),
                    line("error", errors),
                ],
            ),
        ]
    };
    let mut all = Vec::new();
    all.extend(panels("load torque", "Nm", |g| g.load));
    if truth.iter().any(|t| t.windup.is_finite()) {
        all.extend(panels("wind-up of the last stage", "rad", |g| g.windup));
    }
    all.extend(panels("friction at the motor", "Nm", |g| g.friction));
    svg(&all)
}
