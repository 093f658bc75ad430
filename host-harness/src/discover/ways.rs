//! How a name is looked for where the base is lost: in which order the ways are asked, and when one has
//! said enough.

use super::annealed::add_annealed;
use super::bootstrap::stays_ahead;
use super::gate::PLAIN_TORQUE_EXCESS;
use super::protected::add_protected;
use super::search::{Contender, LOST, Search, add_settled, excess};
use crate::estimate::fit::Problem;
use crate::estimate::refit::{ADRIFT, cost};
use crate::interrupt;
use crate::plant::BuildError;

/// Share of the noise that is left where growing trust has found what is missing most.
const EXPLAINED: f64 = 0.1;
/// Share of it that names leave which explain nothing: the first of two that are as large leaves less.
const FUTILE: f64 = 0.75;

/// How a name is looked for.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    /// By one linear step from the base.
    Settled,
    /// With trust that grows.
    Annealed,
    /// Beside a push.
    Protected,
}

/// Adds the best name to a base that is lost, by the way that explains most of the log; none is asked
/// after one that leaves what a right model may need, after two that agree, nor after growing trust where
/// that leaves a model that is not lost, or a tenth of what there was. A push takes with it what changes
/// slowly, and a lost fit bends to what is large.
pub(super) fn add_to_lost(
    problem: Problem<'_>,
    search: &mut Search,
    round: usize,
) -> Result<bool, BuildError> {
    use Way::{Annealed, Protected, Settled};
    let adrift = excess(search) > ADRIFT;
    let ways = match search.before.origin.stages.len() {
        _ if adrift => [Annealed, Protected, Settled],
        0 | 1 => [Settled, Annealed, Protected],
        // Behind two gears short fits end in hollows.
        _ => [Annealed, Settled, Protected],
    };
    // A push that showed no name before shows none beside names that explain nothing.
    let ways = ways.iter().filter(|way| **way != Protected || !is_futile(search));
    let ways: Vec<Way> = ways.copied().collect();
    let base = search.clone();
    let name = |search: &Search| search.rounds.last().map(|round| round.name);
    let mut found = false;
    for way in ways {
        if found && adrift && way == Settled {
            break;
        }
        let mut other = base.clone();
        other.hope = search.hope.take();
        let added = match way {
            Settled => add_settled(problem, &mut other, round)?,
            Annealed => add_annealed(problem, &mut other, round)?,
            Protected => add_protected(problem, &mut other, round)?,
        };
        // A base that is lost no more when it is fitted from elsewhere misses no name.
        if !added && excess(&other) <= LOST && cost(&other.after.fit) < cost(&search.after.fit) {
            *search = other;
            return Ok(false);
        }
        let hopeless = !added && way == Annealed && is_hopeless(&base);
        let agreed = found && added && name(&other) == name(search);
        if found && added {
            better_of(search, other, base.rounds.len(), problem.mask);
        } else if !found {
            *search = other;
        }
        found |= added;
        let enough = match way {
            Annealed => LOST.max(EXPLAINED * excess(&base)),
            Settled | Protected => PLAIN_TORQUE_EXCESS,
        };
        if interrupt::asked() || agreed || hopeless || found && excess(search) < enough {
            break;
        }
    }
    Ok(found)
}

/// Whether the names so far leave a lost model as lost as it was.
pub(super) fn is_futile(search: &Search) -> bool {
    let before = search.before.fit.noise.times(&search.expected);
    !search.rounds.is_empty() && excess(search) > LOST.max(FUTILE * before)
}

/// Whether they do so of a nominal that may still be believed to be near: what growing trust then finds none
/// beside is hidden to the other ways as well.
pub(super) fn is_hopeless(search: &Search) -> bool {
    is_futile(search) && search.before.fit.noise.times(&search.expected) <= ADRIFT
}

/// Keeps what explains more of two ways; the name that the other one gave is its rival from then on.
fn better_of(search: &mut Search, other: Search, before: usize, mask: &[f64]) {
    let mut beaten = other;
    if cost(&beaten.after.fit) < cost(&search.after.fit) {
        std::mem::swap(search, &mut beaten);
    }
    let behind = cost(&beaten.after.fit) - cost(&search.after.fit);
    // Several lines at once are no rival of one name.
    let ([own], [rival]) = (&mut search.rounds[before..], &beaten.rounds[before..]) else { return };
    if own.name == rival.name {
        return;
    }
    let contender = Contender { name: rival.name, gain: own.gain - behind };
    let after = &search.after.fit;
    own.rivalled(contender, beaten.after, |rival| stays_ahead(after, &[&rival.fit], mask));
}

#[cfg(test)]
mod tests {
    use joint_core::effect::Kind;
    use joint_core::params::Location;

    use super::super::candidates::cogging;
    use super::super::search::Round;
    use super::super::trial;
    use super::*;
    use crate::estimate::noise;
    use crate::estimate::record::Record;

    #[test]
    fn names_are_futile_that_leave_a_lost_model_as_lost() {
        let nominal = trial::motor();
        let record = Record::new(&trial::log(&nominal, trial::line(12.0), 4.0), None);
        let mask = vec![1.0; record.measured.len()];
        let expected = noise::expected(&nominal, &record);
        let before = trial::fitted(&Problem::new(&record, &mask).rough(), &nominal, &[]);
        let mut search = Search::new(before, &[], expected);
        let mut futile = |first: f64, left: f64| {
            search.before.fit.noise = expected.distrusted(first);
            search.after.fit.noise = expected.distrusted(left);
            let named = is_futile(&search);
            let mut other = search.clone();
            other.rounds.push(trial::round(400.0));
            [named, is_futile(&other)]
        };
        assert_eq!(futile(40.0, 36.0), [false, true]);
        assert_eq!(futile(40.0, 20.0), [false, false]);
        assert_eq!(futile(5.0, 4.8), [false, false]);
        search.rounds.push(trial::round(400.0));
        let hopeless = |first: f64| {
            search.before.fit.noise = expected.distrusted(first);
            search.after.fit.noise = expected.distrusted(0.9 * first);
            is_hopeless(&search)
        };
        assert_eq!([ADRIFT / 2.0, 2.0 * ADRIFT].map(hopeless), [true, false]);
    }

    #[test]
    fn a_way_that_lost_gives_its_winner_a_rival() {
        let nominal = trial::motor();
        let record = Record::new(&trial::log(&nominal, trial::line(12.0), 4.0), None);
        let mask = vec![1.0; record.measured.len()];
        let problem = Problem::new(&record, &mask).rough();
        let expected = noise::expected(&nominal, &record);
        let before = trial::fitted(&problem, &nominal, &[]);
        let way = |order: f64, kind: Kind| {
            let mut search = Search::new(before.clone(), &[], expected);
            search.after = trial::fitted(&problem, &nominal, &[cogging::line(order, 0.01, false)]);
            let gain = cost(&before.fit) - cost(&search.after.fit);
            search.rounds.push(Round { name: (kind, Location::Motor), ..trial::round(gain) });
            search
        };
        for [first, second] in [[5.0, 12.0], [12.0, 5.0]] {
            let kind = |order: f64| if order == 12.0 { Kind::Cogging } else { Kind::Gravity };
            let mut search = way(first, kind(first));
            let other = way(second, kind(second));
            better_of(&mut search, other, 0, &mask);
            let [round] = &search.rounds[..] else { panic!("{:?}", search.rounds) };
            assert_eq!(round.name.0, Kind::Cogging);
            assert_eq!(round.rivals[0].name.0, Kind::Gravity);
            assert!(round.rivals[0].gain < 0.5 * round.gain, "{:?}", round.rivals);
            let rival = round.runner_up.as_ref().unwrap();
            assert_eq!(rival.fit.model.effects[0].values[0], 5.0);
        }
    }
}
