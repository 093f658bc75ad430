//! What to measure next: the excitation or sensor that would tell what this log cannot.

use joint_core::effect::Kind;
use joint_core::params::Location;

use super::experiment::{Experiment, experiment};
use super::findings::Answer;
use crate::discover::candidates::card;
use crate::discover::state::rounds::title;
use crate::discover::state::search::Search;
use crate::estimate::record::{Channel, Record};
use crate::interrupt;
use crate::model::Model;
use crate::plant::BuildError;

/// Units of log-likelihood beyond which an experiment is sure to tell two models apart.
const SURE: f64 = 1000.0;

/// What shows more of a joint than most logs do.
const MORE: &str = "drive the joint through reversals under load, at several speeds up to its highest, and \
     slowly over a full turn of the output";

/// Advice in a sentence; `blind` where there are stages that no sensor looks behind, `constant` is what a
/// constant torque explains as well.
pub(crate) fn advice(
    answer: Answer,
    names: &[(Kind, Location)],
    close_rival: Option<(Kind, Location)>,
    blind: bool,
    constant: Option<Kind>,
    equation: &str,
) -> String {
    if let Some((kind, _)) = names.first().filter(|(kind, _)| constant == Some(*kind)) {
        let name = kind.spec().kind;
        return format!("{name} or a constant torque: {}", card(*kind).experiment);
    }
    if let (Some(name), Some(rival)) = (names.first(), close_rival) {
        return format!("{} or {}: {}", title(*name), title(rival), card(rival.0).experiment);
    }
    match answer {
        Answer::Undecided => MORE.to_owned(),
        Answer::Adequate => format!("nothing is missing in this log; to look further, {MORE}"),
        Answer::Effect => match names.first() {
            Some((kind, _)) => format!("to confirm: {}", card(*kind).experiment),
            None => String::new(),
        },
        Answer::Unknown if blind => format!(
            "the {equation} equation misses something; an encoder behind the last stage would tell \
             motor, gear and load apart"
        ),
        Answer::Unknown => format!(
            "the {equation} equation misses something that no listed effect explains; repeat slowly \
             in both directions, at two loads, and at a high constant speed, to see whether it \
             follows angle, speed, load or time"
        ),
    }
}

/// The experiment that would tell the name from its best rival, or from nothing where it has none.
pub(crate) fn decisive(
    found: &Search,
    record: &Record,
    micro_steps: u32,
) -> Result<Option<Experiment>, BuildError> {
    if interrupt::asked() {
        return Ok(None);
    }
    let Some(round) = found.rounds.last() else { return Ok(None) };
    let rival = round.runner_up.as_ref().unwrap_or(&found.before);
    experiment(record, micro_steps, [&found.after, rival])
}

/// An experiment in a sentence. What tells two models apart beyond doubt is told no closer: parameters that
/// may still move would take most of it.
pub(crate) fn told(experiment: &Experiment) -> String {
    let units = |worth: f64| match worth > SURE {
        true => format!("more than {SURE:.0}"),
        false => format!("{worth:.0}"),
    };
    let mut text = format!(
        "; the input in next_experiment.csv ({}) would separate the best two models by {} units of log-likelihood",
        experiment.name,
        units(experiment.worth),
    );
    if let Some(seen) = experiment.with_output {
        text += &format!(", with an encoder behind the last stage by {}", units(seen));
    }
    text
}

/// Whether there are stages that no sensor looks behind.
pub(crate) fn blind(model: &Model, record: &Record) -> bool {
    !model.stages.is_empty() && !record.has(Channel::Output)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_short_travel_leaves_open_is_asked_of_a_longer_one() {
        let names = [(Kind::Gravity, Location::Output), (Kind::Cogging, Location::Motor)];
        let asked = |names: &[_], constant: bool| {
            let constant = constant.then_some(Kind::Gravity);
            advice(Answer::Unknown, names, None, false, constant, "rotor torque")
        };
        let open = asked(&names, true);
        assert!(open.contains("gravity or a constant torque") && open.contains("full output turn"));
        assert!(asked(&names[1..], true).contains("the rotor torque equation"));
        assert!(asked(&names, false).contains("the rotor torque equation"));
    }
}
