//! Free runs of any models on any logs: what a simulator's user sees, and the proof that a model holds on
//! records that no fit has seen.
//!
//! A model is run by a log's input alone, from the log's first state; nothing corrects it on the way. Open
//! loop a joint without a spring is an integrator, so that friction's level, which is another one every day,
//! decides the error. So the run is told as it is, with ONE scale on all friction that the record's first
//! seconds give ([`level`]), and over windows of a second from the measured state; beside it stand what a
//! trivial prediction misses and what a per cent of friction does.

mod course;
mod errors;
mod level;
mod run;

use serde::Serialize;

use crate::inputs::Missing;
use crate::log::Log;
use crate::model::Model;
use crate::plant::BuildError;
use crate::start::Measured;

pub use course::{Course, courses};
pub use errors::{Errors, Signal};
use errors::{Tally, signals};
use run::Runner;

/// Length of the windows from the measured state, s.
pub const WINDOW_S: f64 = 1.0;

/// The errors of a model on a log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Transfer {
    /// Each signal's.
    pub signals: Vec<SignalErrors>,
    /// Scale on all friction that the first seconds ask for; `None` where the model has none or they do not
    /// tell.
    pub friction_scale: Option<f64>,
    /// The seconds that told it.
    pub level_s: f64,
    /// Windows from the measured state.
    pub windows: usize,
    /// What was filled or let go, a sentence each.
    pub notes: Vec<String>,
}

/// The errors of one signal, in its unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SignalErrors {
    /// The log's column.
    pub signal: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// The whole record from its first state, as it is.
    pub free_run: Errors,
    /// The same with one scale on all friction.
    pub relevelled: Option<Errors>,
    /// Over windows of a second from the measured state.
    pub windows: Option<Errors>,
    /// The whole record, had it stayed at its first value.
    pub resting: Errors,
    /// The windows, had they gone on at their measured speed.
    pub coasting: Option<Errors>,
    /// RMS by which a per cent more friction moves the free run.
    pub per_percent_friction: f64,
}

/// Runs a model on a log.
///
/// # Errors
/// The model cannot be built.
pub fn transfer(model: &Model, log: &Log) -> Result<Transfer, BuildError> {
    let signals = signals(log);
    let measured = Measured::new(model, log);
    let runner = Runner::new(model, log)?;
    let missing: &Missing = runner.missing();
    let mut notes = missing.told(&log.time_s);
    let whole = 0..log.len();
    let first = (0..log.len()).find_map(|k| Some((k, measured.at(k)?)));
    let Some((begin, start)) = first else {
        return Ok(Transfer {
            signals: Vec::new(),
            friction_scale: None,
            level_s: 0.0,
            windows: 0,
            notes: vec!["no angle is known".into()],
        });
    };
    let whole = begin..whole.end;
    if log.output_angle_rad.is_some() && measured.output_offset() != 0.0 {
        notes.push(format!(
            "the output encoder's zero is taken {:.4} rad off the motor's through the gear",
            measured.output_offset()
        ));
    }
    let offset = measured.output_offset();
    let tallied = |run: &[run::Shown]| {
        let mut tally = Tally::new(&signals);
        tally.add(log, &whole, run, offset);
        tally
    };
    let plain = runner.run(&start, whole.clone());
    let free = tallied(&plain);
    let (scale, level_s) = level::scale(model, log, &measured, begin)?;
    if scale.is_none() {
        notes.push(format!("the first {level_s:.2} s do not tell a level of friction"));
    }
    let relevelled = match scale {
        Some(scale) => {
            let run = Runner::new(&model.with_friction(scale), log)?.run(&start, whole.clone());
            Some(tallied(&run))
        }
        None => None,
    };
    let more = Runner::new(&model.with_friction(1.01), log)?.run(&start, whole.clone());
    let moved = errors::apart(&signals, &plain, &more);
    let (windows, coasting, count) = in_windows(&runner, log, &measured, &signals, begin);
    let resting = errors::resting(&signals, log, &whole);
    let signals = signals.iter().enumerate().map(|(s, signal)| SignalErrors {
        signal: signal.column,
        unit: signal.unit,
        free_run: free.errors(s),
        relevelled: relevelled.as_ref().map(|tally| tally.errors(s)),
        windows: (count > 0).then(|| windows.errors(s)),
        resting: resting[s],
        coasting: (count > 0).then(|| coasting.errors(s)),
        per_percent_friction: moved[s],
    });
    Ok(Transfer {
        signals: signals.collect(),
        friction_scale: scale,
        level_s,
        windows: count,
        notes,
    })
}

/// A model with the level of friction that a log's first seconds tell; as it is where they do not.
///
/// # Errors
/// The model cannot be built.
pub fn levelled(model: &Model, log: &Log) -> Result<Model, BuildError> {
    let measured = Measured::new(model, log);
    let Some(begin) = (0..log.len()).find(|k| measured.at(*k).is_some()) else {
        return Ok(model.clone());
    };
    let (scale, _) = level::scale(model, log, &measured, begin)?;
    Ok(scale.map_or_else(|| model.clone(), |scale| model.with_friction(scale)))
}

/// Errors over windows from the measured state, of the model and of one that goes on at its speed, and how
/// many there are.
fn in_windows(
    runner: &Runner<'_>,
    log: &Log,
    measured: &Measured<'_>,
    signals: &[Signal],
    begin: usize,
) -> (Tally, Tally, usize) {
    let (mut own, mut coasting) = (Tally::new(signals), Tally::new(signals));
    let mut count = 0;
    for range in course::windows(log, begin, WINDOW_S) {
        if let Some(start) = measured.at(range.start) {
            own.add(log, &range, &runner.run(&start, range.clone()), measured.output_offset());
            let coast = runner.coasting(&start, range.clone());
            coasting.add(log, &range, &coast, measured.output_offset());
            count += 1;
        }
    }
    (own, coasting, count)
}

#[cfg(test)]
mod tests {
    use joint_core::effect::{EffectParameters, Kind};
    use joint_core::params::Location;

    use super::*;
    use crate::demo::actuator;
    use crate::synthetic::{Experiment, record};

    fn angle(transfer: &Transfer) -> &SignalErrors {
        transfer.signals.iter().find(|s| s.signal == "motor_angle_rad").unwrap()
    }

    #[test]
    fn the_true_model_runs_free_far_better_than_a_wrong_one_and_a_trivial_one() {
        let truth = actuator();
        let log = record(&truth, &Experiment::clean(2.5), 2).unwrap();
        let mut wrong = truth.clone();
        wrong.motor.torque_constant_nm_per_a *= 1.1;
        let (right, wrong) = (transfer(&truth, &log).unwrap(), transfer(&wrong, &log).unwrap());
        assert_eq!(right.windows, 2);
        let (right, wrong) = (angle(&right), angle(&wrong));
        assert!(wrong.free_run.rms > 3.0 * right.free_run.rms, "{right:?} {wrong:?}");
        assert!(right.resting.rms > 10.0 * right.free_run.rms, "{right:?}");
        assert!(right.coasting.unwrap().rms > 10.0 * right.windows.unwrap().rms, "{right:?}");
    }

    #[test]
    fn a_voltage_that_acts_late_is_run_late() {
        let late = EffectParameters::new(Kind::InputDelay, Location::Inverter);
        let at = |delay| Model { effects: vec![late.with("delay_s", delay)], ..actuator() };
        let truth = at(6.4e-3);
        let log = record(&truth, &Experiment::clean(2.5), 2).unwrap();
        let errors = |model: &Model| angle(&transfer(model, &log).unwrap()).free_run.rms;
        let [right, prompt] = [errors(&truth), errors(&actuator())];
        assert!(prompt > 10.0 * right, "{right} {prompt}");
    }

    #[test]
    fn another_level_of_friction_is_found_and_taken_out() {
        let truth = actuator();
        let log = record(&truth.with_friction(1.1), &Experiment::clean(2.5), 2).unwrap();
        let told = transfer(&truth, &log).unwrap();
        assert!((told.friction_scale.unwrap() / 1.1 - 1.0).abs() < 0.02, "{told:?}");
        let errors = angle(&told);
        assert!(errors.relevelled.unwrap().rms < 0.3 * errors.free_run.rms, "{errors:?}");
        assert!(errors.per_percent_friction > 0.0);
    }
}
