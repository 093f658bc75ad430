//! What an observer found, drawn over what is true.

use super::score::Guess;
use crate::plot::{Axis, Ink, Mark, Plot, Series, picture};

/// Load, last wind-up and friction against time, and of each the error between two standard
/// deviations either side.
pub fn plot(title: &str, step_s: f64, truth: &[Guess], found: &[Guess], sigma: &[Guess]) -> String {
    let time: Vec<f64> = (0..truth.len()).map(|k| k as f64 * step_s).collect();
    let all_of_it = [0.0, time.last().copied().unwrap_or(0.0)];
    // While it starts an estimate may be off the page.
    let started = |(k, value): (usize, f64)| if k < truth.len() / 50 { f64::NAN } else { value };
    let panels = |what: &str, unit, value: fn(&Guess) -> f64| {
        let of = |rows: &[Guess]| -> Vec<f64> { rows.iter().map(value).collect() };
        let deviation = |sign: f64| -> Vec<f64> {
            sigma.iter().map(|s| sign * 2.0 * value(s)).enumerate().map(started).collect()
        };
        let errors = found.iter().zip(truth).map(|(f, t)| value(f) - value(t)).enumerate();
        let errors: Vec<f64> = errors.map(started).collect();
        let panel = |title: String, series| {
            let across = Axis::linear("time", "s").within(all_of_it);
            let plot = Plot::new(title, across, Axis::linear(what.to_owned(), unit));
            Plot { series, ..plot.sized(760.0, 190.0).explained() }
        };
        [
            panel(
                format!("{title}: {what}"),
                vec![
                    Series::new("truth", Ink::Text, Mark::Line, &time, of(truth)),
                    Series::new("estimate", Ink::After, Mark::Line, &time, of(found)),
                ],
            ),
            panel(
                "its error, and two standard deviations".to_owned(),
                vec![
                    Series::band("±2 σ", Ink::After, &time, [deviation(-1.0), deviation(1.0)]),
                    Series::new("error", Ink::Before, Mark::Line, &time, errors),
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
    picture(&all)
}
