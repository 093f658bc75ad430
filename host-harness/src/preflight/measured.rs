//! Effects that plain regressions measure.
//!
//! A regression over windows of many samples does not hear what shakes a joint from sample to sample, nor
//! trusts a model of it. What it is certain of is a first hypothesis with a value.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::{Case, gravity};
use crate::log::Log;
use crate::model::Model;
use crate::plant::output_shaft;

/// Effects that regressions are certain of, of the logs of one joint: of several the first that is certain.
pub(crate) fn measured(model: &Model, logs: &[Log]) -> Vec<EffectParameters> {
    for log in logs {
        let case = Case::new(model, log);
        if let Some(found) = weight(&case) {
            return vec![found];
        }
    }
    Vec::new()
}

/// A torque that follows the output's angle once a turn.
fn weight(case: &Case<'_>) -> Option<EffectParameters> {
    let weight = gravity::lacking(case)?;
    let place = if case.model.stages.is_empty() { Location::Motor } else { Location::Output };
    let amplitude = weight.amplitude().0 / output_shaft(case.model).abs();
    let gravity = EffectParameters::new(Kind::Gravity, place);
    let phase = weight.cosine.0.atan2(weight.sine.0);
    Some(gravity.with("amplitude_nm", amplitude).with("phase_rad", phase))
}

#[cfg(test)]
mod tests {
    use super::super::made::actuator_and_log;
    use super::*;
    use crate::synthetic::{Experiment, record};

    #[test]
    fn a_weight_is_measured_where_one_hangs() {
        let (model, log) = actuator_and_log();
        assert_eq!(measured(&model, &[log]), []);
        let mut heavy = model.clone();
        heavy.load.gravity_nm = 0.5;
        let log = record(&heavy, &Experiment::clean(4.0), 3).unwrap();
        let found = measured(&model, &[log]);
        let [weight] = &found[..] else { panic!("{found:?}") };
        assert_eq!((weight.kind, weight.location), (Kind::Gravity, Location::Output));
        // Bristles bias a regression that takes friction for a sign: 5 %.
        assert!((weight.values[0] / 0.5 - 1.0).abs() < 0.05, "{weight:?}");
    }
}
