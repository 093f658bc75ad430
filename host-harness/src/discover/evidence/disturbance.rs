//! The disturbance that a model leaves on an equation, as a filter with a random-walk state estimates it.
//!
//! Each equation in turn is given a disturbance that wanders; the one whose disturbance makes the log most likely
//! is the one that misses something. What it may follow is every quantity that the filter knows by sample.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

use joint_core::joint::Drive;
use rayon::prelude::*;

use crate::discover::state::stage::Stage;
use crate::estimate::filter::{Equation, Linearisation, Noise, Observer, Run, Walk};
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::record::Channel;
use crate::estimate::refit::cost;
use crate::model::Model;
use crate::plant::{BuildError, Layout, output_shaft, plant};

/// How fast disturbances wander: share of their scale per root second.
const RATES: [f64; 3] = [1.0, 10.0, 100.0];
/// Equations beside whose disturbance the parameters are refitted, and rounds of that refit.
const REFITTED: usize = 4;
const ROUNDS: usize = 3;
/// The rotor's angle within a turn.
pub(crate) const TURN: &str = "motor_angle_rad (one turn)";
/// Wind-up of the last stage.
pub(crate) const WINDUP: &str = "output_windup_rad";

fn disturbances(problem: &Problem<'_>, model: &Model, noise: &Noise) -> Vec<Walk> {
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

/// The equations whose disturbances make the log most likely, the best first, and the model refitted beside
/// each; from the nominal as well where the plain refit has `biased` its parameters to explain what the equation
/// misses.
///
/// # Errors
/// A model cannot be built.
pub(crate) fn disagreeing(
    problem: &Problem<'_>,
    before: &Stage,
    noise: &Noise,
    biased: bool,
) -> Result<Vec<(Walk, Fit)>, BuildError> {
    let Stage { fit: plain, origin } = before;
    let starts = [Some(&plain.model), biased.then_some(origin)]
        .into_par_iter()
        .flatten()
        .map(|model| {
            let mut along = Cow::Owned(Linearisation::default());
            problem.design_along(&mut along, model, noise)?;
            Ok((model, along))
        })
        .collect::<Result<Vec<_>, BuildError>>()?;
    let scored = disturbances(problem, &plain.model, noise)
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

/// The disturbance on one equation by sample.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn disturbance_along(
    problem: &Problem<'_>,
    model: &Model,
    noise: &Noise,
    walk: Walk,
) -> Result<Vec<f64>, BuildError> {
    Ok(disturbance_of(&run_beside(problem, model, noise, walk)?))
}

/// The disturbance of a run: its last state.
pub(crate) fn disturbance_of(run: &Run) -> Vec<f64> {
    run.states.iter().map(|x| x.last().copied().unwrap_or(0.0)).collect()
}

/// A run beside a disturbance, whose value, as all samples show it, is each state's last.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn run_beside(
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
pub(crate) fn title(equation: Equation, drive: Drive, stages: usize) -> (String, &'static str) {
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

/// What a disturbance may follow, by sample.
pub(crate) fn coordinates(
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
