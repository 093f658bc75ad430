//! Whether the best of what was proposed is added.

use crate::discover::bounds::WORTH_ANOTHER;
use crate::discover::checks::base_refit::refitted_base;
use crate::discover::checks::bootstrap::stays_ahead;
use crate::discover::checks::own_gain::{holds, owed_to_the_rest};
use crate::discover::proposals::linear_step::linear_step;
use crate::discover::proposals::proposed::{Proposed, Tried};
use crate::discover::state::rounds::{Contender, Round};
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::refit::cost;
use crate::plant::BuildError;

/// Looks at one round.
const LOOKS: usize = 3;

/// What one look at a round gave.
enum Look {
    /// A name.
    Added,
    /// No name.
    Nothing,
    /// No name, but a base that fits so much better that another look is worth it.
    BetterBase,
}

/// Adds the best name that one linear step finds; looks again where that only showed that the base could be fitted
/// better.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn add_by_linear_step(
    problem: Problem<'_>,
    search: &mut Search,
    round: usize,
) -> Result<bool, BuildError> {
    for _ in 0..LOOKS {
        let proposed = linear_step(problem, search, round)?;
        match proposed.map_or(Ok(Look::Nothing), |proposed| accept(&problem, search, proposed))? {
            Look::Added => return Ok(true),
            Look::Nothing => break,
            Look::BetterBase => {}
        }
    }
    Ok(false)
}

/// Adds the best of what was proposed in another way; where that only showed that the base could be fitted better, a
/// linear step goes on from there.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn add_proposed(
    problem: Problem<'_>,
    search: &mut Search,
    round: usize,
    proposed: Option<Proposed>,
) -> Result<bool, BuildError> {
    let Some(proposed) = proposed else { return Ok(false) };
    match accept(&problem, search, proposed)? {
        Look::Added => Ok(true),
        Look::Nothing => Ok(false),
        Look::BetterBase => add_by_linear_step(problem, search, round),
    }
}

fn accept(
    problem: &Problem<'_>,
    search: &mut Search,
    proposed: Proposed,
) -> Result<Look, BuildError> {
    match proposed {
        Proposed::Effects(tried) => accept_effect(problem, search, *tried),
        Proposed::Lines(rounds, stage) => {
            search.rounds.extend(rounds);
            search.after = *stage;
            Ok(Look::Added)
        }
    }
}

/// Adds the best of the effects that were tried, if it gains enough and the gain is its own: no better fit of the rest
/// has it as well.
fn accept_effect(
    problem: &Problem<'_>,
    search: &mut Search,
    tried: Tried,
) -> Result<Look, BuildError> {
    let Tried { base, cost: level, refined, by_chance, contenders } = tried;
    let expected = search.expected;
    // What refitting on has driven to where no joint is believed is none of them.
    let believed =
        |(_, stage): &(Contender, Stage)| search.believes(&stage.fit.model, problem.record);
    let believed: Vec<_> = contenders.into_iter().filter(believed).collect();
    let mut contenders = believed.into_iter();
    let Some((winner, won)) = contenders.next() else { return Ok(Look::Nothing) };
    let least = by_chance.max(search.least_gain(winner.name.1));
    if winner.gain.is_nan() || winner.gain < least {
        return Ok(Look::Nothing);
    }
    let weak = search.weak_gain(winner.name.1);
    if winner.gain < weak && !holds(*problem, &refined, &won.fit, &expected)? {
        search.defer(winner, won);
        return Ok(Look::Nothing);
    }
    let plain = refitted_base(problem, &base, &won, least, &expected)?;
    let owed = (level - cost(&plain.fit)).max(0.0);
    if owed > 0.0 && search.rounds.is_empty() {
        search.before = plain.clone();
    }
    let gains = [winner.gain, winner.gain - owed, weak];
    if gains[1] < least || owed_to_the_rest(*problem, &plain.fit, &won.fit, gains, &expected)? {
        search.after = plain;
        return Ok(if owed < WORTH_ANOTHER { Look::Nothing } else { Look::BetterBase });
    }
    let less = |(rival, stage): (Contender, Stage)| {
        (Contender { gain: rival.gain - owed, ..rival }, stage)
    };
    let (rivals, beaten): (Vec<_>, Vec<_>) = contenders.map(less).unzip();
    let runner_up = beaten.into_iter().next();
    let others: Vec<&Fit> = runner_up.iter().map(|stage| &stage.fit).chain([&plain.fit]).collect();
    let stays_ahead = stays_ahead(&won.fit, &others, problem.mask);
    let (name, gain) = (winner.name, gains[1]);
    search.rounds.push(Round { name, gain, rivals, runner_up, stays_ahead });
    search.after = won;
    Ok(Look::Added)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::bounds::MOST_EFFECTS;
    use crate::discover::trial;
    use crate::estimate::noise;
    use crate::estimate::record::Record;

    #[test]
    fn a_person_who_waits_reads_what_is_tried_and_of_how_many() {
        let nominal = trial::motor();
        let record = Record::new(&trial::log(&nominal, trial::line(12.0), 4.0), None);
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask).rough();
        let expected = noise::expected(&nominal, &record);
        let mut search = Search::new(trial::fitted(&problem, &nominal, &[]), &[], expected);
        add_by_linear_step(problem, &mut search, 1).unwrap();
        let message = search.bar.message();
        let start = format!("effect 1 of at most {MOST_EFFECTS}: fitting the ");
        assert!(message.starts_with(&start), "{message}");
        assert!(message.ends_with(" known effects"), "{message}");
    }
}
