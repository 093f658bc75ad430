//! Where model and log disagree, before any name: which equation, and along which coordinate.
//!
//! Each equation in turn is given a disturbance that wanders; the one whose disturbance makes the log most likely
//! is the one that misses something. The disturbance is then laid against everything it might follow.

use std::f64::consts::TAU;

use super::findings::{Angles, Disturbance, Shape, Whereabouts};
use crate::discover::evidence::disturbance::{
    TURN, WINDUP, coordinates, disagreeing, disturbance_along, disturbance_of, run_beside, title,
};
use crate::discover::state::stage::Stage;
use crate::estimate::filter::{Noise, Run, Walk};
use crate::estimate::fit::Problem;
use crate::estimate::record::Channel;
use crate::model::Model;
use crate::plant::{BuildError, Layout};

/// Bins of a coordinate, and the highest order that bins of a turn can show.
const BINS: usize = 48;
const SHOWN: f64 = 6.0;

/// The disagreement of one model with a record.
#[derive(Default)]
pub(crate) struct Disagreement {
    /// The random-walk disturbance that makes the log most likely; `None` where no filter could be run.
    pub(crate) walk: Option<Walk>,
    /// The answer.
    pub(crate) whereabouts: Whereabouts,
    /// The disturbance along the record.
    pub(crate) disturbance: Disturbance,
    /// The disturbance against what it follows.
    pub(crate) shape: Shape,
    /// The disturbance against everything that it might follow.
    pub(crate) courses: Vec<Shape>,
    /// The joint's angles beside it.
    pub(crate) angles: Angles,
}

/// Looks for where a model disagrees with a record, and how a better one does there; `along_lines`
/// says that orders of the rotor angle rival every other explanation.
///
/// # Errors
/// A model cannot be built.
pub(crate) fn locate(
    problem: &Problem<'_>,
    before: &Stage,
    after: &Model,
    noise: &Noise,
    orders: &[f64],
    along_lines: bool,
) -> Result<Disagreement, BuildError> {
    let biased = before.fit.noise.times(noise) > 1.0;
    let Some((walk, before)) =
        disagreeing(&problem.ahead(), before, noise, biased)?.into_iter().next()
    else {
        return Ok(Disagreement::default());
    };
    let before = &before.model;
    let run = run_beside(problem, before, noise, walk)?;
    let series = disturbance_of(&run);
    let series_after = disturbance_along(problem, after, noise, walk)?;
    let (equation, unit) = title(walk.equation, problem.record.drive, before.stages.len());
    let coordinates = coordinates(problem, before, &run);
    let courses: Vec<Shape> = coordinates
        .iter()
        .filter_map(|(name, values)| binned(name, values, &series, &series_after))
        .collect();
    let best = courses.iter().fold(None, |best: Option<&Shape>, own| match best {
        Some(most) if own.explained <= most.explained => best,
        _ => Some(own),
    });
    let lines = explained_by_lines(problem, &series, orders);
    let (explained, varies_with, shape) = match best {
        Some(own) if !along_lines => (own.explained, own.coordinate.clone(), own.clone()),
        Some(own) => {
            let (name, values) = folded(&run, orders);
            let folded = binned(&name, &values, &series, &series_after);
            (lines, "motor_angle_rad".to_owned(), folded.unwrap_or_else(|| own.clone()))
        }
        None => (0.0, String::new(), Shape::default()),
    };
    let whereabouts = Whereabouts {
        equation: equation.clone(),
        varies_with: column_of(&varies_with).to_owned(),
        orders: orders.to_vec(),
        explained,
    };
    let layout = Layout::of(before);
    let windup = coordinates.iter().find(|(name, _)| *name == WINDUP);
    let angles = Angles {
        motor_rad: run.states.iter().map(|x| x[Layout::ANGLE]).collect(),
        windup_rad: windup.filter(|_| layout.stages > 0).map_or(Vec::new(), |(_, own)| own.clone()),
    };
    let disturbance = Disturbance { equation, unit, before: series, after: series_after };
    Ok(Disagreement { walk: Some(walk), whereabouts, disturbance, shape, courses, angles })
}

/// The column that a coordinate is of.
fn column_of(coordinate: &str) -> &str {
    coordinate.split(" (").next().unwrap_or_default()
}

/// The rotor's angle within a turn; within a period of the strongest order where bins of a turn would
/// blur it: a high one, or one that does not close with the turn.
fn folded(run: &Run, orders: &[f64]) -> (String, Vec<f64>) {
    let own = orders.first().filter(|order| **order > SHOWN || order.fract() != 0.0);
    let within = |span: f64| run.states.iter().map(|x| x[Layout::ANGLE].rem_euclid(span)).collect();
    match own {
        None => (TURN.to_owned(), within(TAU)),
        Some(order) => {
            let shown = (100.0 * order).round() / 100.0;
            (format!("motor_angle_rad (one of {shown} periods a turn)"), within(TAU / order))
        }
    }
}

/// Means of a series by bins of a coordinate, with the share of its variance that they explain.
fn binned(name: &str, coordinate: &[f64], series: &[f64], after: &[f64]) -> Option<Shape> {
    let finite = coordinate.iter().copied().filter(|c| c.is_finite());
    let (low, high) =
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), c| (l.min(c), h.max(c)));
    if low >= high || !(high - low).is_finite() {
        return None;
    }
    let bin = |c: f64| (((c - low) / (high - low) * BINS as f64) as usize).min(BINS - 1);
    let (mut count, mut sum, mut sum_after) = ([0.0; BINS], [0.0; BINS], [0.0; BINS]);
    for ((c, s), a) in coordinate.iter().zip(series).zip(after) {
        count[bin(*c)] += 1.0;
        sum[bin(*c)] += s;
        sum_after[bin(*c)] += a;
    }
    let total = series.len() as f64;
    let mean = series.iter().sum::<f64>() / total;
    let variance = series.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / total;
    let between: f64 = (0..BINS)
        .filter(|k| count[*k] > 0.0)
        .map(|k| count[k] / total * (sum[k] / count[k] - mean).powi(2))
        .sum();
    let filled = |k: &usize| count[*k] > 0.0;
    let per = |sums: [f64; BINS]| (0..BINS).filter(filled).map(|k| sums[k] / count[k]).collect();
    Some(Shape {
        explained: if variance > 0.0 { between / variance } else { 0.0 },
        coordinate: name.to_owned(),
        centres: (0..BINS)
            .filter(filled)
            .map(|k| low + (high - low) * (k as f64 + 0.5) / BINS as f64)
            .collect(),
        before: per(sum),
        after: per(sum_after),
    })
}

/// Share of a disturbance that sines at these orders of the motor angle explain.
fn explained_by_lines(problem: &Problem<'_>, series: &[f64], orders: &[f64]) -> f64 {
    let mean = series.iter().sum::<f64>() / series.len().max(1) as f64;
    let variance: f64 = series.iter().map(|s| (s - mean).powi(2)).sum();
    let explained: f64 = orders
        .iter()
        .map(|order| {
            let (mut cos, mut sin) = (0.0, 0.0);
            for (row, value) in problem.record.measured.iter().zip(series) {
                let angle = order * row[Channel::Motor as usize];
                if angle.is_finite() {
                    cos += (value - mean) * angle.cos();
                    sin += (value - mean) * angle.sin();
                }
            }
            2.0 * (cos * cos + sin * sin) / series.len() as f64
        })
        .sum();
    if variance > 0.0 { (explained / variance).min(1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(order: f64) -> Shape {
        let angles: Vec<f64> = (0..4000).map(|k| f64::from(k) * 0.01).collect();
        let push: Vec<f64> = angles.iter().map(|angle| (order * angle).sin()).collect();
        let states = angles.iter().map(|angle| vec![0.0, *angle, 0.0, 0.0]).collect();
        let run = Run { innovations: Vec::new(), states };
        let (name, values) = folded(&run, &[order]);
        binned(&name, &values, &push, &push).unwrap()
    }

    #[test]
    fn a_line_of_any_order_shows_its_whole_height() {
        for order in [1.0, 6.0, 7.0, 66.0, 3.09, 400.5] {
            let shape = shown(order);
            let height = shape.before.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
            assert!(height > 0.8, "{order}: {height}, over {}", shape.coordinate);
        }
    }
}
