//! What to measure next: the excitation or sensor that would tell what this log cannot.

use joint_core::effect::Kind;
use joint_core::params::Location;

use super::candidates::card;
use super::findings::Answer;

/// What shows more of a joint than most logs do.
const MORE: &str = "drive the joint through reversals under load, at several speeds up to its highest, and \
     slowly over a full turn of the output";

/// Advice in a sentence; `blind` where there are stages that no sensor looks behind, `constant` where a
/// constant torque explains what gravity does.
pub fn advice(
    answer: Answer,
    names: &[(Kind, Location)],
    close_rival: Option<(Kind, Location)>,
    blind: bool,
    constant: bool,
    equation: &str,
) -> String {
    if let (true, Some((Kind::Gravity, _))) = (constant, names.first()) {
        return format!("gravity or a constant torque: {}", card(Kind::Gravity).experiment);
    }
    if let (Some(name), Some(rival)) = (names.first(), close_rival) {
        return format!(
            "{} or {}: {}",
            super::search::title(*name),
            super::search::title(rival),
            card(rival.0).experiment
        );
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_short_travel_leaves_open_is_asked_of_a_longer_one() {
        let names = [(Kind::Gravity, Location::Output), (Kind::Cogging, Location::Motor)];
        let asked = |names: &[_], constant: bool| {
            advice(Answer::Unknown, names, None, false, constant, "rotor torque")
        };
        let open = asked(&names, true);
        assert!(open.contains("gravity or a constant torque") && open.contains("full output turn"));
        assert!(asked(&names[1..], true).contains("the rotor torque equation"));
        assert!(asked(&names, false).contains("the rotor torque equation"));
    }
}
