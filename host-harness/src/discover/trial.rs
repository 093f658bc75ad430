//! What the tests of the search share: a short log in which something is hidden, and models that are
//! fitted to it.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use crate::demo::actuator;
use crate::discover::candidates::cogging;
use crate::discover::candidates::hypothesis::Hypothesis;
use crate::discover::state::rounds::Round;
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::fit::Problem;
use crate::estimate::record::Record;
use crate::estimate::{noise, refit};
use crate::log::Log;
use crate::model::Model;
use crate::synthetic::{Experiment, record};

/// The motor of the demonstration without its gear.
pub(super) fn motor() -> Model {
    let mut model = actuator();
    model.stages.clear();
    model
}

/// A line of cogging at this order, one and a half times the motor's Coulomb level.
pub(super) fn line(order: f64) -> EffectParameters {
    EffectParameters::new(Kind::Cogging, Location::Motor)
        .with("order", order)
        .with("amplitude_nm", 0.02)
        .with("phase_rad", 0.8)
}

/// A clean log of 0.6 s of a model with an effect, swung with this voltage.
pub(super) fn log(nominal: &Model, effect: EffectParameters, volts: f64) -> Log {
    let mut truth = nominal.clone();
    truth.effects.push(effect);
    let push = |k: i32| volts * (f64::from(k) * 4e-3).sin();
    let voltage_v = Some((0..6000).map(push).collect());
    record(&truth, &Experiment { voltage_v, ..Experiment::clean(0.6) }, 5).unwrap()
}

/// Samples of a record that no fit sees, the last three tenths of every thousand, and the weights of all in a fit.
pub(super) fn split(record: &Record) -> (Vec<bool>, Vec<f64>) {
    let tested: Vec<bool> = (0..record.len()).map(|k| k % 1000 >= 700).collect();
    let weights = tested.iter().map(|tested| f64::from(u8::from(!tested))).collect();
    (tested, weights)
}

/// A search that has found the line of order 12.
pub(super) fn searched(problem: &Problem<'_>, nominal: &Model) -> Search {
    let expected = noise::expected(nominal, problem.record);
    let mut found = Search::new(fitted(problem, nominal, &[]), &[], expected);
    found.after = fitted(problem, nominal, &[cogging::line(12.0, 0.01, false)]);
    found.rounds.push(round(1e4));
    found
}

/// The nominal with these effects, refitted.
pub(super) fn fitted(problem: &Problem<'_>, nominal: &Model, added: &[Hypothesis]) -> Stage {
    let expected = noise::expected(nominal, problem.record);
    let mut origin = nominal.clone();
    let mut moved = refit::coordinates(nominal, problem);
    for hypothesis in added {
        moved.extend(hypothesis.coordinates(origin.effects.len()));
        origin = hypothesis.added(&origin);
    }
    let doubt = expected.distrusted(3.0);
    let fit = refit::polish(problem, &origin, &origin, &moved, &expected, &doubt).unwrap();
    Stage { fit, origin }
}

/// A round that found a cogging, without rivals.
pub(super) fn round(gain: f64) -> Round {
    Round {
        name: (Kind::Cogging, Location::Motor),
        gain,
        rivals: Vec::new(),
        runner_up: None,
        stays_ahead: 1.0,
    }
}
