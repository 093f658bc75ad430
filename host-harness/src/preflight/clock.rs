//! The stamps: gaps, jitter, and whether they are the instants of the samples.
//!
//! Where stamps jitter but the angle does not follow them, they were made when a row was written and not when
//! it was sampled; where the angle follows the stamp of a neighbour, they belong to another row. Between two
//! samples a joint turns by its speed times the interval, so a regression of the one on the intervals around
//! it tells which one acted.

use super::regression::Rows;
use super::windows::{Windows, scatter, typical_interval};
use super::{Case, Check, Finding};
use crate::grid::GAP;
use crate::model::Model;

/// Standard errors beyond which an interval acts, or acts not.
const CERTAIN: f64 = 4.0;
/// Samples of the windows that tell the speed.
const WIDTH: usize = 20;
/// How far the model's sample time may be off the log's, as a share of it.
const ALLOWED: f64 = 0.1;

pub(super) const CHECK: Check =
    Check { name: "clock", compares: "time stamps against each other and against the motion", run };

fn run(case: &Case<'_>) -> Vec<Finding> {
    let log = case.log;
    let typical = typical_interval(&log.time_s);
    let mut all = Vec::new();
    let gap = |k: &usize| log.time_s[*k] - log.time_s[k - 1] > GAP * typical;
    let gaps: Vec<usize> = (1..log.len()).filter(gap).collect();
    if let Some(first) = gaps.first() {
        let lost: f64 = gaps.iter().map(|k| log.time_s[*k] - log.time_s[k - 1]).sum();
        all.push(
            Finding::warning(format!(
                "the clock has {} gaps, {lost:.3} s in all, first before t_s = {}",
                gaps.len(),
                log.time_s[*first]
            ))
            .help("each stretch is fitted from its own start; log without gaps if you can")
            .at(*first),
        );
    }
    all.extend(other_unit(case.model, typical));
    all.extend(stamps(case, typical));
    all
}

/// Whether the log's interval is the model's in another unit.
fn other_unit(model: &Model, typical: f64) -> Option<Finding> {
    let nominal = model.sensor.sample_time_s;
    let ratio = typical / nominal;
    if nominal <= 0.0 || (ratio - 1.0).abs() < ALLOWED {
        return None;
    }
    let told =
        format!("t_s rises by {typical:.3e} a sample, the model's sample_time_s is {nominal:.3e}");
    let unit = [(1e3, "ms"), (1e6, "µs"), (1e9, "ns")];
    let unit = unit.iter().find(|(factor, _)| (ratio / factor - 1.0).abs() < ALLOWED);
    Some(match unit {
        Some((_, unit)) => Finding::error(format!("{told}: it looks as if t_s is in {unit}"))
            .help("convert t_s to seconds"),
        None => Finding::note(told),
    })
}

/// Whether uneven stamps are the instants of their samples.
fn stamps(case: &Case<'_>, typical: f64) -> Option<Finding> {
    let log = case.log;
    let intervals: Vec<f64> = log.time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let regular: Vec<f64> = intervals.iter().copied().filter(|dt| *dt < GAP * typical).collect();
    let mean = regular.iter().sum::<f64>() / regular.len().max(1) as f64;
    let spread =
        regular.iter().map(|dt| (dt - mean).powi(2)).sum::<f64>() / regular.len().max(1) as f64;
    let jitter = spread.sqrt();
    let windows = Windows::of(&log.time_s, WIDTH);
    let (speeds, _) = windows.derivatives(&log.time_s, &log.motor_angle_rad);
    let fastest =
        speeds.iter().filter(|w| w.is_finite()).fold(0.0_f64, |most, w| most.max(w.abs()));
    // Where the largest motion within the jitter is below the encoder's scatter, nothing tells.
    if fastest * jitter < scatter(&log.motor_angle_rad) {
        return None;
    }
    let mut rows = Rows::new(4);
    let stride = log.len() / 200_000 + 1;
    for k in (WIDTH..intervals.len().saturating_sub(WIDTH)).step_by(stride) {
        let around = k - WIDTH / 2..k + WIDTH / 2;
        let span = log.time_s[around.end] - log.time_s[around.start];
        let turned = log.motor_angle_rad[around.end] - log.motor_angle_rad[around.start];
        let speed = turned / span;
        if speed.abs() < 0.3 * fastest || span > (WIDTH as f64 + GAP) * typical {
            continue;
        }
        let step = (log.motor_angle_rad[k + 1] - log.motor_angle_rad[k]) / speed;
        let off = |j: usize| intervals[j] - mean;
        rows.push(step - mean, &[off(k), off(k - 1), off(k + 1), 1.0]);
    }
    let fit = rows.fit()?;
    let [(own, own_error), (before, before_error), (after, after_error)] =
        [0, 1, 2].map(|column| fit.coefficient(column));
    let told = format!("stamps jitter by {:.1} µs", 1e6 * jitter);
    let acts = |(value, error): (f64, f64)| value > 0.5 && value > CERTAIN * error;
    let rests = |(value, error): (f64, f64)| value + CERTAIN * error < 0.5;
    if !rests((own, own_error)) {
        return acts((own, own_error))
            .then(|| Finding::note(format!("{told}, and the angle follows them")));
    }
    let (what, help) = match (acts((before, before_error)), acts((after, after_error))) {
        (true, _) => (
            "the angle follows the interval before: each stamp belongs to the row after it",
            "shift t_s by a row",
        ),
        (_, true) => (
            "the angle follows the interval after: each stamp belongs to the row before it",
            "shift t_s by a row",
        ),
        _ => (
            "the angle does not follow them: they are not the instants of the samples",
            "stamp rows where they are sampled, or give them an even clock",
        ),
    };
    Some(Finding::warning(format!("{told}, and {what}")).help(help))
}

#[cfg(test)]
mod tests {
    use super::super::Severity;
    use super::super::made::of;
    use super::*;
    use crate::demo::actuator;
    use crate::log::Log;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// A log at 1 ms whose instants jitter by so many samples, with stamps of `shift` rows before.
    fn found(jitter: f64, shift: Option<usize>) -> Vec<Finding> {
        let mut model = actuator();
        model.sensor.sample_time_s = 1e-3;
        let mut random = ChaCha8Rng::seed_from_u64(6);
        let mut jittered = || -> Vec<f64> {
            (0..4000).map(|k| 1e-3 * (f64::from(k) + jitter * random.random::<f64>())).collect()
        };
        let (instants, others) = (jittered(), jittered());
        let stamp = |k: usize| match shift {
            None => others[k],
            Some(rows) => instants[k - rows.min(k)] + 1e-3 * rows.min(k) as f64,
        };
        let log = Log {
            time_s: (0..4000).map(stamp).collect(),
            motor_angle_rad: instants.iter().map(|t| 40.0 * t + 3.0 * (4.0 * t).sin()).collect(),
            ..Log::default()
        };
        of(&CHECK, &model, &log)
    }

    #[test]
    fn an_even_clock_is_not_told_and_one_that_jitters_rightly_is_a_note() {
        assert_eq!(found(0.0, Some(0)), []);
        let told = found(0.3, Some(0));
        assert!(told.len() == 1 && told[0].severity == Severity::Note, "{told:?}");
    }

    #[test]
    fn stamps_of_another_row_or_of_no_sample_are_told() {
        assert!(found(0.3, Some(1))[0].message.contains("belongs to the row before it"));
        assert!(found(0.3, None)[0].message.contains("not the instants of the samples"));
    }

    #[test]
    fn gaps_and_milliseconds_are_told() {
        let mut model = actuator();
        model.sensor.sample_time_s = 1e-3;
        let mut log = Log {
            time_s: (0..4000).map(|k| 1e-3 * f64::from(k)).collect(),
            motor_angle_rad: (0..4000).map(|k| f64::from(k).sin()).collect(),
            ..Log::default()
        };
        log.time_s[1000..].iter_mut().for_each(|t| *t += 2.0);
        let told = of(&CHECK, &model, &log);
        assert!(told[0].message.contains("1 gaps, 2.001 s in all"), "{told:?}");
        assert_eq!(told[0].row, Some(1000));
        log.time_s.iter_mut().for_each(|t| *t *= 1e3);
        assert!(of(&CHECK, &model, &log).iter().any(|told| told.message.ends_with("t_s is in ms")));
    }
}
