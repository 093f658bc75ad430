//! Whether a log and a model speak of the same machine, in the same units, before anything is fitted.
//!
//! A gear ratio that is off, a current in milliamperes, an angle in degrees or a model without friction are
//! the first things that go wrong at a bench. No effect explains them, and a fit biases every parameter to
//! make up for them. Each check is one [`Check`] in a file of its own; it looks at the log through short
//! windows ([`windows`]) and plain regressions ([`regression`]) whose errors come from the scatter between
//! parts of the log, so that no bound depends on an assumed noise.

mod angle_jumps;
mod bus_ripple;
mod clock;
mod excitation;
mod finding;
mod friction;
mod gear_ratio;
mod gravity;
mod length;
mod measured;
mod moves;
mod outliers;
mod plausible;
mod regression;
mod repeats;
mod torque;
mod torque_balance;
mod unit;
mod winding;
mod windows;

pub(crate) use angle_jumps::wraps;
pub use excitation::{Excitation, excitation};
pub use finding::{Finding, Severity};
pub use length::LEAST_SAMPLES;
pub(crate) use measured::measured;
pub(crate) use regression::median;
pub(crate) use windows::scatter;

use crate::log::Log;
use crate::model::Model;
use torque_balance::TorqueBalance;

/// A model and a log of its joint, with what several checks look at.
pub struct Case<'a> {
    /// The model.
    pub model: &'a Model,
    /// The log.
    pub log: &'a Log,
    balance: Option<TorqueBalance>,
}

impl<'a> Case<'a> {
    /// Of a model and a log.
    pub fn new(model: &'a Model, log: &'a Log) -> Self {
        let balance = TorqueBalance::of(model, log);
        Self { model, log, balance }
    }
}

/// One question that is asked of every model and log.
#[derive(Clone, Copy, Debug)]
pub struct Check {
    /// Its name, as findings carry it.
    pub name: &'static str,
    /// What it compares, in a sentence.
    pub compares: &'static str,
    run: fn(&Case<'_>) -> Vec<Finding>,
}

/// Every check, in the order in which findings are told.
pub const CHECKS: [&Check; 14] = [
    &length::CHECK,
    &outliers::CHECK,
    &clock::CHECK,
    &angle_jumps::CHECK,
    &repeats::CHECK,
    &moves::CHECK,
    &plausible::CHECK,
    &winding::CHECK,
    &torque::CHECK,
    &gear_ratio::CHECK,
    &friction::CHECK,
    &gravity::CHECK,
    &bus_ripple::CHECK,
    &excitation::CHECK,
];

/// What the checks find, errors first. Where a sample is no measurement, the rest would be nonsense and is
/// not asked.
pub fn findings(model: &Model, log: &Log) -> Vec<Finding> {
    let case = Case::new(model, log);
    let mut all: Vec<Finding> = Vec::new();
    for check in CHECKS {
        let found = (check.run)(&case);
        all.extend(found.into_iter().map(|finding| finding.of(check.name)));
        let unusable = |finding: &Finding| {
            finding.severity == Severity::Error
                && [length::CHECK.name, outliers::CHECK.name, angle_jumps::CHECK.name]
                    .contains(&finding.check)
        };
        if all.iter().any(unusable) {
            break;
        }
    }
    all.sort_by_key(|finding| finding.severity);
    all
}

/// What a recording shows of its own mistakes, whatever the model.
pub fn recording(log: &Log) -> Vec<Finding> {
    let found = angle_jumps::of(log).into_iter();
    found.map(|finding| finding.of(angle_jumps::CHECK.name)).collect()
}

/// The sentences of the findings that doubt a log or its model, errors first: what a verdict's reasons tell.
pub fn doubts(model: &Model, log: &Log) -> Vec<String> {
    let doubted = findings(model, log).into_iter().filter(|f| f.severity != Severity::Note);
    let told = |finding: Finding| match finding.help.as_str() {
        "" => finding.message,
        help => format!("{}: {help}", finding.message),
    };
    doubted.map(told).collect()
}

#[cfg(test)]
pub(crate) mod made {
    //! Made logs that the checks are tested on.

    use super::{Case, Check, Finding, findings};
    use crate::demo::actuator;
    use crate::log::Log;
    use crate::model::Model;
    use crate::synthetic::{Experiment, record};

    /// An actuator with a log of 1.5 s.
    pub(crate) fn actuator_and_log() -> (Model, Log) {
        let model = actuator();
        let log = record(&model, &Experiment::default(), 3).unwrap();
        (model, log)
    }

    /// What one check says.
    pub(crate) fn of(check: &Check, model: &Model, log: &Log) -> Vec<Finding> {
        (check.run)(&Case::new(model, log))
    }

    #[test]
    fn nothing_is_doubted_in_a_good_log() {
        let (model, log) = actuator_and_log();
        assert_eq!(super::doubts(&model, &log), Vec::<String>::new());
        assert!(!findings(&model, &log).is_empty(), "notes say what was measured");
    }
}
