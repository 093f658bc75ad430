//! Where model and log disagree, before any name: which equation, and along which coordinate.
//!
//! Each equation in turn is given a push that wanders; the one whose push makes the log most likely
//! is the one that misses something. The push is then laid against everything it might follow.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

use rayon::prelude::*;

use super::findings::{Angles, Push, Shape, Whereabouts};
use super::search::Stage;
use crate::estimate::filter::{Equation, Linearisation, Noise, Observer, Run, Walk};
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::record::Channel;
use crate::estimate::refit::cost;
use crate::model::Model;
use crate::plant::{BuildError, Layout, output_shaft, plant};
use joint_core::joint::Drive;

/// How fast pushes wander: share of their scale per root second.
const RATES: [f64; 3] = [1.0, 10.0, 100.0];
/// Equations beside whose push the parameters are refitted, and rounds of that refit.
const REFITTED: usize = 4;
const ROUNDS: usize = 3;
/// Bins of a coordinate, and the highest order that bins of a turn can show.
const BINS: usize = 48;
const SHOWN: f64 = 6.0;

/// The rotor's angle within a turn.
const TURN: &str = "motor_angle_rad (one turn)";
/// Wind-up of the last stage.
const WINDUP: &str = "output_windup_rad";

/// The disagreement of one model with a record.
#[derive(Default)]
pub struct Disagreement {
    /// The random-walk disturbance that makes the log most likely; `None` where no filter could be run.
    pub walk: Option<Walk>,
    /// The answer.
    pub whereabouts: Whereabouts,
    /// The push along the record.
    pub push: Push,
    /// The push against what it follows.
    pub shape: Shape,
    /// The push against everything that it might follow.
    pub courses: Vec<Shape>,
    /// The joint's angles beside it.
    pub angles: Angles,
}

/// Looks for where a model disagrees with a record, and how a better one does there; `along_lines`
/// says that orders of the rotor angle rival every other explanation.
///
/// # Errors
/// A model cannot be built.
pub fn locate(
    problem: &Problem<'_>,
    before: &Stage,
    after: &Model,
    noise: &Noise,
    orders: &[f64],
    along_lines: bool,
) -> Result<Disagreement, BuildError> {
    let bent = before.fit.noise.times(noise) > 1.0;
    let Some((walk, before)) =
        disagreeing(&problem.ahead(), before, noise, bent)?.into_iter().next()
    else {
        return Ok(Disagreement::default());
    };
    let before = &before.model;
    let run = pushed(problem, before, noise, walk)?;
    let series = of_push(&run);
    let series_after = push_along(problem, after, noise, walk)?;
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
    let push = Push { equation, unit, before: series, after: series_after };
    Ok(Disagreement { walk: Some(walk), whereabouts, push, shape, courses, angles })
}

/// The column that a coordinate is of.
fn column_of(coordinate: &str) -> &str {
    coordinate.split(" (").next().unwrap_or_default()
}

fn pushes(problem: &Problem<'_>, model: &Model, noise: &Noise) -> Vec<Walk> {
    let largest = problem.record.drive_values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let mut scales = vec![(Equation::Voltage, 0.05 * largest)];
    for mass in 0..=model.stages.len() {
        scales.push((Equation::Torque(mass), 20.0 * noise.torque));
    }
    for channel in Channel::ALL.into_iter().filter(|channel| problem.record.has(*channel)) {
        scales.push((Equation::Sensor(channel), 5.0 * noise.sensors[channel as usize]));
    }
    let walk =
        |(equation, scale): (Equation, f64), rate: f64| Walk::random(equation, scale, rate * scale);
    scales.iter().flat_map(|scale| RATES.map(|rate| walk(*scale, rate))).collect()
}

/// The equations whose pushes make the log most likely, the best first, and the model refitted beside
/// each; from the nominal as well where the plain refit has `bent` its parameters to explain what the equation
/// misses.
///
/// # Errors
/// A model cannot be built.
pub fn disagreeing(
    problem: &Problem<'_>,
    before: &Stage,
    noise: &Noise,
    bent: bool,
) -> Result<Vec<(Walk, Fit)>, BuildError> {
    let Stage { fit: plain, origin } = before;
    let starts = [Some(&plain.model), bent.then_some(origin)]
        .into_par_iter()
        .flatten()
        .map(|model| {
            let mut along = Cow::Owned(Linearisation::default());
            problem.design_along(&mut along, model, noise)?;
            Ok((model, along))
        })
        .collect::<Result<Vec<_>, BuildError>>()?;
    let scored = pushes(problem, &plain.model, noise)
        .par_iter()
        .flat_map_iter(|walk| starts.iter().map(move |(model, along)| (*walk, *model, along)))
        .map(|(walk, model, along)| {
            let deviance = problem.pushed(walk).deviance_along(along, model, noise)?;
            Ok((deviance, walk, model))
        })
        .collect::<Result<Vec<_>, BuildError>>()?;
    let mut best: BTreeMap<Equation, (f64, Walk, &Model)> = BTreeMap::new();
    for row in scored {
        let own = best.entry(row.1.equation).or_insert(row);
        if row.0 < own.0 {
            *own = row;
        }
    }
    let mut ranked: Vec<_> = best.into_values().collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut fits = ranked
        .into_par_iter()
        .take(REFITTED)
        .map(|(_, walk, start)| {
            let fit = problem.pushed(walk).fit(origin, start, &plain.coordinates, noise, ROUNDS)?;
            Ok((walk, fit))
        })
        .collect::<Result<Vec<_>, BuildError>>()?;
    fits.sort_by(|a, b| cost(&a.1).total_cmp(&cost(&b.1)));
    Ok(fits)
}

/// The push on one equation by sample.
///
/// # Errors
/// The model cannot be built.
pub fn push_along(
    problem: &Problem<'_>,
    model: &Model,
    noise: &Noise,
    walk: Walk,
) -> Result<Vec<f64>, BuildError> {
    Ok(of_push(&pushed(problem, model, noise, walk)?))
}

/// The push of a run: its last state.
pub(super) fn of_push(run: &Run) -> Vec<f64> {
    run.states.iter().map(|x| x.last().copied().unwrap_or(0.0)).collect()
}

/// A run beside a push, whose value, as all samples show it, is each state's last.
///
/// # Errors
/// The model cannot be built.
pub(super) fn pushed(
    problem: &Problem<'_>,
    model: &Model,
    noise: &Noise,
    walk: Walk,
) -> Result<Run, BuildError> {
    let plant = plant(model, &problem.record.grid, problem.record.drive)?;
    let observer = Observer::new(model, &*plant, problem.record);
    let walks = problem.pushed(walk).walks(noise, model.stages.len());
    let mut along = Cow::Owned(Linearisation::default());
    let (gains, mut run) = observer.design_along(&mut along, noise, &walks);
    let smoothed = observer.smoothed(&gains, &along, &run).unwrap_or_default();
    for (state, value) in run.states.iter_mut().zip(smoothed) {
        state.last_mut().into_iter().for_each(|last| *last = value);
    }
    Ok(run)
}

/// An equation in words, and its unit.
pub(super) fn title(equation: Equation, drive: Drive, stages: usize) -> (String, &'static str) {
    match equation {
        Equation::Voltage if drive == Drive::Current => ("imposed current".into(), "A"),
        Equation::Voltage => ("voltage".into(), "V"),
        Equation::Torque(0) => ("rotor torque".into(), "Nm"),
        Equation::Torque(mass) if mass == stages => ("output torque".into(), "Nm at the motor"),
        Equation::Torque(mass) => (format!("stage {mass} torque"), "Nm at the motor"),
        Equation::Sensor(Channel::Current) => ("current sensor".into(), "A"),
        Equation::Sensor(Channel::Motor) => ("motor encoder".into(), "rad"),
        Equation::Sensor(Channel::Output) => ("output encoder".into(), "rad"),
    }
}

/// What a push may follow, by sample.
pub(super) fn coordinates(
    problem: &Problem<'_>,
    model: &Model,
    run: &Run,
) -> Vec<(&'static str, Vec<f64>)> {
    let layout = Layout::of(model);
    let shaft = output_shaft(model);
    let last = layout.speed(layout.stages);
    let series = |f: &dyn Fn(usize, &[f64]) -> f64| -> Vec<f64> {
        run.states.iter().enumerate().map(|(k, x)| f(k, x)).collect()
    };
    let output = |x: &[f64]| {
        let wound: f64 = (0..layout.stages).map(|k| x[layout.deflection(k)]).sum();
        (x[Layout::ANGLE] - wound) * shaft
    };
    let current = |k: usize, x: &[f64]| match problem.record.drive {
        Drive::Voltage => x[Layout::CURRENT],
        Drive::Current => problem.record.drive_values[k],
    };
    let mut all = vec![
        (TURN, series(&|_, x| x[Layout::ANGLE].rem_euclid(TAU))),
        ("motor_angle_rad (over the travel)", series(&|_, x| x[Layout::ANGLE])),
        ("motor_speed_rad_per_s", series(&|_, x| x[layout.speed(0)])),
        ("i_a", series(&|k, x| current(k, x))),
        ("u_v", series(&|k, _| problem.record.drive_values[k])),
        ("t_s", series(&|k, _| problem.record.time_s[k])),
    ];
    if layout.stages > 0 {
        all.push(("output_angle_rad", series(&|_, x| output(x))));
        all.push(("output_speed_rad_per_s", series(&|_, x| x[last] * shaft)));
        let windup = layout.deflection(layout.stages - 1);
        all.push((WINDUP, series(&|_, x| x[windup] * shaft)));
    }
    all
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

/// Share of a push that sines at these orders of the motor angle explain.
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
