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
    let walks = problem.pushed(walk).walks(noise, model);
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
        Equation::Sensor(Channel::Current) | Equation::CurrentBefore => {
            ("current sensor".into(), "A")
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::actuator;
    use crate::discover::trial;
    use crate::estimate::noise;
    use crate::estimate::record::Record;
    use crate::log::Log;
    use crate::synthetic::{Experiment, record};
    use joint_core::params::Stage;

    #[test]
    fn every_equation_that_a_log_shows_may_be_disturbed_at_three_rates_of_its_scale() {
        let model = actuator();
        let log = record(&model, &Experiment::clean(0.01), 1).unwrap();
        let record = Record::new(&Log { output_angle_rad: None, ..log }, None);
        let mask = vec![1.0; record.len()];
        let noise =
            Noise { torque: 2.0, sensors: [3.0, 4.0, 5.0], ..noise::expected(&model, &record) };
        let largest = record.drive_values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let scales = [
            (Equation::Voltage, 0.05 * largest),
            (Equation::Torque(0), 40.0),
            (Equation::Torque(1), 40.0),
            (Equation::Sensor(Channel::Current), 5.0 * noise.sensors[Channel::Current as usize]),
            (Equation::Sensor(Channel::Motor), 5.0 * noise.sensors[Channel::Motor as usize]),
        ];
        let of = |(equation, scale): (Equation, f64)| {
            [1.0, 10.0, 100.0].map(|rate| Walk::random(equation, scale, rate * scale))
        };
        let wanted: Vec<Walk> = scales.into_iter().flat_map(of).collect();
        assert!(largest > 1.0);
        assert_eq!(disturbances(&Problem::new(&record, &mask), &model, &noise), wanted);
    }

    #[test]
    fn the_equation_that_misses_a_torque_comes_first_at_its_likeliest_rate_and_shows_that_torque() {
        let nominal = trial::motor();
        let record = Record::new(&trial::log(&nominal, trial::line(12.0), 4.0), None);
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask).rough();
        let noise = noise::expected(&nominal, &record);
        let before = trial::fitted(&problem, &nominal, &[]);
        let fits = disagreeing(&problem, &before, &noise, false).unwrap();
        assert_eq!(fits[0].0.equation, Equation::Torque(0));
        assert!(fits.is_sorted_by(|a, b| cost(&a.1) <= cost(&b.1)));
        let model = &before.fit.model;
        let mut along = Cow::Owned(Linearisation::default());
        problem.design_along(&mut along, model, &noise).unwrap();
        let deviance = |walk| problem.pushed(walk).deviance_along(&along, model, &noise).unwrap();
        for (walk, _) in &fits {
            let own = disturbances(&problem, model, &noise).into_iter();
            let least = own.filter(|other| other.equation == walk.equation).map(deviance);
            assert_eq!(deviance(*walk), least.fold(f64::INFINITY, f64::min), "{walk:?}");
        }
        let found = disturbance_along(&problem, &nominal, &noise, fits[0].0).unwrap();
        assert_eq!(found.len(), record.len());
        let angles = record.measured.iter().map(|row| row[Channel::Motor as usize]);
        let line: Vec<f64> = angles.map(|angle| -0.02 * (12.0 * angle + 0.8).sin()).collect();
        let squares = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
        let left: Vec<f64> = line.iter().zip(&found).map(|(line, found)| line - found).collect();
        assert!(squares(&left) < 0.1 * squares(&line), "{} {}", squares(&left), squares(&line));
    }

    #[test]
    fn an_equation_is_told_in_words_with_its_unit() {
        let told = |equation| title(equation, Drive::Voltage, 2);
        assert_eq!(told(Equation::Voltage), ("voltage".into(), "V"));
        assert_eq!(title(Equation::Voltage, Drive::Current, 2), ("imposed current".into(), "A"));
        assert_eq!(told(Equation::Torque(0)), ("rotor torque".into(), "Nm"));
        assert_eq!(told(Equation::Torque(1)), ("stage 1 torque".into(), "Nm at the motor"));
        assert_eq!(told(Equation::Torque(2)), ("output torque".into(), "Nm at the motor"));
        assert_eq!(told(Equation::Sensor(Channel::Output)), ("output encoder".into(), "rad"));
    }

    #[test]
    fn a_disturbance_may_follow_the_motor_the_drive_and_the_shaft_behind_all_gears() {
        let mut model = actuator();
        model.stages.push(Stage { reduction: 4.0, ..model.stages[0] });
        let log = record(&model, &Experiment::clean(0.01), 1).unwrap();
        let record = Record::new(&log, None);
        let mask = vec![1.0; record.len()];
        // Current and angle, deflections, speeds, bristles.
        let state = vec![3.0, 8.0, 0.5, 0.25, 6.0, 7.0, 72.0, 0.1, 0.2, 0.3];
        let run = Run { innovations: Vec::new(), states: vec![state; 2] };
        let of = |model: &Model, record: &Record| -> BTreeMap<&str, f64> {
            let all = coordinates(&Problem::new(record, &mask), model, &run);
            all.into_iter().map(|(name, series)| (name, series[1])).collect()
        };
        let wanted = [
            (TURN, 8.0 - TAU),
            ("motor_angle_rad (over the travel)", 8.0),
            ("motor_speed_rad_per_s", 6.0),
            ("i_a", 3.0),
            ("u_v", record.drive_values[1]),
            ("t_s", record.time_s[1]),
            ("output_angle_rad", 7.25 / 36.0),
            ("output_speed_rad_per_s", 2.0),
            (WINDUP, 0.25 / 36.0),
        ];
        let told = of(&model, &record);
        assert_eq!(told.len(), wanted.len());
        for (name, value) in wanted {
            assert!((told[name] - value).abs() < 1e-12, "{name}: {}, {value}", told[name]);
        }
        // A current that is imposed is known; a motor alone has no other shaft.
        let mut imposed = record.clone();
        imposed.drive = Drive::Current;
        assert_eq!(of(&model, &imposed)["i_a"], record.drive_values[1]);
        assert_eq!(of(&trial::motor(), &record).len(), 6);
    }
}
