//! What was measured before the search: effects that plain regressions over windows are certain of.
//!
//! Noise that differs from sample to sample hides from a filter what a regression over many of them shows
//! plainly. Such an effect is fitted first, from its measured value, and stays if that makes the log likelier.

use joint_core::effect::EffectParameters;

use crate::discover::bounds::MOST_EFFECTS;
use crate::discover::candidates;
use crate::discover::candidates::hypothesis::Hypothesis;
use crate::discover::checks::bootstrap::stays_ahead;
use crate::discover::proposals::refits::gained;
use crate::discover::proposals::score_test::ScoreTest;
use crate::discover::state::rounds::Round;
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::fit::Problem;
use crate::estimate::refit;
use crate::interrupt;
use crate::plant::BuildError;

/// Adds those of the measured effects that make the log likelier.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn add_measured(
    problem: Problem<'_>,
    search: &mut Search,
    measured: &[EffectParameters],
) -> Result<(), BuildError> {
    for effect in measured {
        let Some(hypothesis) = begun(problem, search, effect) else { continue };
        if search.rounds.len() >= MOST_EFFECTS || interrupt::asked() {
            break;
        }
        let base = &search.after;
        let (origin, moved) = base.widened(&hypothesis);
        let (start, noise) = (hypothesis.added(&base.fit.model), &base.fit.noise);
        let fit = refit::polish(&problem, &origin, &start, &moved, &search.expected, noise)?;
        let gain = gained(&base.fit, &fit);
        // Regressions are certain of it already: the likelihood has only to go along.
        if gain > 0.0 && search.believes(&fit.model, problem.record) {
            let stays_ahead = stays_ahead(&fit, &[&search.after.fit], problem.mask);
            let (name, rivals) = (hypothesis.name(), Vec::new());
            search.rounds.push(Round { name, gain, rivals, runner_up: None, stays_ahead });
            search.measured.push(name);
            search.after = Stage { fit, origin };
        }
    }
    Ok(())
}

/// What candidates propose of an effect, begun at what was measured.
fn begun(problem: Problem<'_>, search: &Search, effect: &EffectParameters) -> Option<Hypothesis> {
    let Stage { fit, origin } = &search.after;
    let test = ScoreTest::new(problem, origin, fit, 0)?;
    let scene = test.scene();
    let proposed = candidates::proposed(&scene, &search.withdrawn);
    let own = proposed.into_iter().find(|it| it.name() == (effect.kind, effect.location))?;
    Some(Hypothesis { start: *effect, ..own })
}

#[cfg(test)]
mod tests {
    use joint_core::effect::Kind;
    use joint_core::params::Location;

    use super::*;
    use crate::discover::trial;
    use crate::estimate::noise;
    use crate::estimate::record::Record;

    #[test]
    fn a_measured_weight_is_taken_where_one_hangs_and_a_withdrawn_one_is_not() {
        let nominal = trial::motor();
        let weight = |torque: f64| {
            let gravity = EffectParameters::new(Kind::Gravity, Location::Motor);
            gravity.with("amplitude_nm", torque).with("phase_rad", 0.3)
        };
        let record = Record::new(&trial::log(&nominal, weight(0.02), 4.0), None);
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask).rough();
        let expected = noise::expected(&nominal, &record);
        let base = trial::fitted(&problem, &nominal, &[]);
        let found = |withdrawn: &[Kind]| {
            let mut search = Search::new(base.clone(), withdrawn, expected);
            add_measured(problem, &mut search, &[weight(0.015)]).unwrap();
            search
        };
        assert!(found(&[Kind::Gravity]).rounds.is_empty());
        let search = found(&[]);
        assert_eq!(search.rounds[0].name, (Kind::Gravity, Location::Motor));
        assert_eq!(search.measured, [search.rounds[0].name]);
        let torque = search.after.fit.model.effects[0].values[0];
        assert!((torque / 0.02 - 1.0).abs() < 0.05, "{torque}");
    }
}
