//! The answer in sentences: what each name explains and how far the next one is, what contradicts a
//! name, and what is left.

use super::findings::Gap;
use super::force_error::relative_force_error;
use crate::discover::evidence::budget::Weighed;
use crate::discover::nuisances::{friction_shape, late_current};
use crate::discover::state::rounds::{Round, title};
use crate::discover::state::search::Search;
use crate::estimate::filter::{Disturbed, Noise};
use crate::estimate::record::Record;
use crate::estimate::timing;
use crate::model::Model;
use crate::plot::text::si;

/// Why the answer is what it is, in the order in which it was found.
pub(crate) fn reasons(
    found: &Search,
    (given, record): (&Model, &Record),
    gap: &Gap,
    complaints: &[String],
) -> Vec<String> {
    let mut all = explained(&found.rounds);
    all.extend(timing::told(record).map(str::to_owned));
    let [timed, model] = [&found.before, &found.after].map(|stage| &stage.fit.model);
    all.extend(late_current::told(given, timed, model));
    let constant = found.constant.and_then(|constant| {
        let own = found.rounds.iter().find(|round| round.name.0 == constant.of)?;
        Some(constant.told(own.gain))
    });
    all.extend(constant);
    all.extend(
        found.contradictions.iter().map(|(_, text)| format!("fits, but is contradicted: {text}")),
    );
    if found.rounds.is_empty() {
        let best = found.scores.iter().map(|row| row.score).fold(0.0, f64::max);
        let chance = found.chance.first().copied().unwrap_or_default();
        all.push(format!(
            "no listed effect explains what is missing: the best score is {best:.0}, chance is ruled out from {chance:.0} on, and a full refit must keep it"
        ));
    }
    all.extend(levels(&found.after.fit.model));
    all.extend(friction_shape::told(&found.after.fit.model));
    all.extend(disturbed(&found.after.fit.noise));
    if complaints.is_empty() {
        all.push(format!(
            "what is left is noise: {:.3} sigma on held-out data where bootstrap replicates leave {:.3}",
            gap.after, gap.floor
        ));
    } else {
        all.extend(complaints.iter().map(|text| format!("what is left is not noise: {text}")));
    }
    let force = |model: &Model| relative_force_error(model, record);
    if let (Some(before), Some(after)) =
        (force(&found.before.fit.model), force(&found.after.fit.model))
    {
        all.push(format!(
            "relative force error over the record: {:.2} % refitted, {:.2} % with the effects",
            100.0 * before,
            100.0 * after
        ));
    }
    all
}

/// How hard the joint rubs in each log, where there are several.
fn levels(model: &Model) -> Option<String> {
    let other = |(k, level): (usize, &f64)| format!("{level:.3} in log {}", k + 1);
    let levels: Vec<String> = model.friction_levels.iter().enumerate().skip(1).map(other).collect();
    (!levels.is_empty()).then(|| {
        format!(
            "friction of another level in each log, over that of the first: {}",
            levels.join(", ")
        )
    })
}

/// That more is left than friction, supply and sensors may scatter by, if it is.
pub(super) fn unbelievable(weighed: &Weighed) -> Option<String> {
    let budget = weighed.budget.as_ref().filter(|_| weighed.over_believable > 1.0)?;
    let unit = budget.unit.split(' ').next().unwrap_or_default();
    Some(format!(
        "beside white noise {} RMS are left in the {}, {:.1} times the most that friction, supply and sensors are believed to scatter by",
        si(budget.rms_left, unit, 2),
        budget.equation,
        weighed.over_believable,
    ))
}

/// What disturbs the joint beside noise that is white and alike at all speeds.
fn disturbed(noise: &Noise) -> impl Iterator<Item = String> {
    let reversal = (noise.reversal > 0.0).then(|| {
        format!(
            "friction departs from the model near reversals: by {} of torque at standstill",
            si(noise.reversal, "Nm", 2)
        )
    });
    let colours = noise.colours().map(|(place, colour)| {
        let (name, unit) = match place {
            Disturbed::Drive => ("drive", "V"),
            Disturbed::Rotor => ("rotor", "Nm"),
            Disturbed::Output => ("output", "Nm"),
        };
        format!(
            "a disturbance of the {name} wanders: {} RMS, correlated over {}; what is named is judged beside it",
            si(colour.deviation, unit, 2),
            si(colour.correlation_s, "s", 2)
        )
    });
    reversal.into_iter().chain(colours)
}

/// What each name took, and the next best one; lines that were added at once took it together.
fn explained(rounds: &[Round]) -> Vec<String> {
    let at_once = rounds.chunk_by(|one, next| one.name == next.name && one.gain == next.gain);
    at_once
        .map(|rounds| {
            let Round { name, gain, rivals, .. } = &rounds[0];
            let name = match rounds.len() {
                1 => format!("{} improves", title(*name)),
                several => format!("{}, {several} of them added at once, improve", title(*name)),
            };
            let next = rivals.first().map_or_else(
                || "no other one comes near".to_owned(),
                |rival| format!("the next best one, {}, by {:.0}", title(rival.name), rival.gain),
            );
            format!("{name} the fit by {gain:.0} (2 Δ log-likelihood); {next}")
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use joint_core::effect::Kind;
    use joint_core::params::Location;

    use super::*;
    use crate::discover::state::rounds::Contender;
    use crate::estimate::filter::Colour;

    fn round(kind: Kind, gain: f64, rivals: Vec<Contender>) -> Round {
        let name = (kind, Location::Motor);
        Round { name, gain, rivals, runner_up: None, stays_ahead: 1.0 }
    }

    #[test]
    fn a_disturbance_is_told_with_its_size_and_its_time() {
        let mut noise = Noise {
            drive: 0.1,
            torque: 0.1,
            reversal: 0.0,
            output: 0.0,
            sensors: [0.1; 3],
            coloured: Default::default(),
        };
        assert_eq!(disturbed(&noise).count(), 0);
        noise.reversal = 3e-3;
        noise.coloured[Disturbed::Rotor as usize] = Colour { deviation: 0.02, correlation_s: 0.4 };
        let told: Vec<String> = disturbed(&noise).collect();
        assert!(told[0].contains("3.0 mNm") && told[0].contains("reversals"), "{told:?}");
        assert!(told[1].contains("rotor wanders: 20 mNm RMS") && told[1].contains("400 ms"));
    }

    #[test]
    fn lines_that_were_added_at_once_took_their_gain_together() {
        let drag = Contender { name: (Kind::QuadraticDrag, Location::Motor), gain: 12.4 };
        let line = || round(Kind::Cogging, 1079.0, Vec::new());
        let told = explained(&[line(), line(), round(Kind::Gravity, 80.2, vec![drag]), line()]);
        let [lines, gravity, line] = &told[..] else { panic!("{told:?}") };
        assert!(
            lines
                .starts_with("cogging (motor), 2 of them added at once, improve the fit by 1079 (")
        );
        assert!(gravity.starts_with("gravity (motor) improves the fit by 80 ("));
        assert!(gravity.ends_with("the next best one, quadratic-drag (motor), by 12"));
        assert!(
            line.starts_with("cogging (motor) improves the fit by 1079")
                && line.ends_with("comes near")
        );
    }
}
