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
    use super::super::gravity::tests::swinging;
    use super::*;

    #[test]
    fn a_weight_is_measured_where_one_hangs() {
        let [none, heavy] = [0.0, 0.1].map(|weight| {
            let (model, log) = swinging(weight);
            measured(&model, &[log])
        });
        assert_eq!(none, []);
        let [weight] = &heavy[..] else { panic!("{heavy:?}") };
        assert_eq!((weight.kind, weight.location), (Kind::Gravity, Location::Motor));
        // Bristles bias a regression that takes friction for a sign: 5 %.
        assert!((weight.values[0] / 0.1 - 1.0).abs() < 0.05, "{weight:?}");
    }
}
