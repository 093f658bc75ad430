//! How a name is looked for where the base is inconsistent: in which order the strategies are tried, and when one has
//! said enough.

use super::acceptance::{add_by_linear_step, add_proposed};
use crate::discover::bounds::{ADRIFT, EXPLAINED, LOST, PLAIN_TORQUE_RATIO};
use crate::discover::checks::bootstrap::stays_ahead;
use crate::discover::proposals::annealed::annealed;
use crate::discover::proposals::disturbance_state::beside_disturbance_state;
use crate::discover::state::rounds::Contender;
use crate::discover::state::search::Search;
use crate::estimate::fit::Problem;
use crate::estimate::refit::cost;
use crate::interrupt;
use crate::plant::BuildError;

/// How a name is looked for.
#[derive(Clone, Copy, PartialEq)]
enum Strategy {
    /// By one linear step from the base.
    LinearStep,
    /// At inflated process noise that falls.
    Annealed,
    /// Beside a disturbance state.
    DisturbanceState,
}

impl Strategy {
    /// Those that are tried of a base, in their order.
    fn order(search: &Search) -> Vec<Self> {
        use Strategy::{Annealed, DisturbanceState, LinearStep};
        let adrift = search.noise_ratio() > ADRIFT;
        let order = match search.before.origin.stages.len() {
            _ if adrift => [Annealed, DisturbanceState, LinearStep],
            0 | 1 => [LinearStep, Annealed, DisturbanceState],
            // Behind two gears short fits end in local minima.
            _ => [Annealed, LinearStep, DisturbanceState],
        };
        // A disturbance that showed no name before shows none beside names that explain nothing.
        let hidden = search.has_not_improved();
        order.into_iter().filter(|own| *own != DisturbanceState || !hidden).collect()
    }

    /// Adds the best name that it finds; `known` is what the best fit costs that another one has found.
    fn add(
        self,
        problem: Problem<'_>,
        search: &mut Search,
        round: usize,
        known: Option<f64>,
    ) -> Result<bool, BuildError> {
        let proposed = match self {
            Strategy::LinearStep => return add_by_linear_step(problem, search, round),
            Strategy::Annealed => annealed(problem, search, round)?,
            Strategy::DisturbanceState => beside_disturbance_state(problem, search, round, known)?,
        };
        add_proposed(problem, search, round, proposed)
    }

    /// Noise ratio below which nothing else is tried, from that of the base.
    fn enough(self, base: f64) -> f64 {
        match self {
            Strategy::Annealed => LOST.max(EXPLAINED * base),
            Strategy::LinearStep | Strategy::DisturbanceState => PLAIN_TORQUE_RATIO,
        }
    }
}

/// Adds the best name to a base that is inconsistent, by the strategy that explains most of the log; none is tried
/// after one that leaves what a right model may need, after two that agree, nor after the annealed refit where
/// that leaves a model that is not inconsistent, or a tenth of what there was. A disturbance takes with it what changes
/// slowly, and an inconsistent fit is biased by what is large.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn add_to_inconsistent(
    problem: Problem<'_>,
    search: &mut Search,
    round: usize,
) -> Result<bool, BuildError> {
    let base = search.clone();
    let adrift = base.noise_ratio() > ADRIFT;
    let name = |search: &Search| search.rounds.last().map(|round| round.name);
    let mut found = false;
    for strategy in Strategy::order(&base) {
        if found && adrift && strategy == Strategy::LinearStep {
            break;
        }
        let mut other = base.clone();
        other.deferred = search.deferred.take();
        let known = found.then(|| cost(&search.after.fit));
        let added = strategy.add(problem, &mut other, round, known)?;
        // A base that is consistent when it is fitted from elsewhere misses no name.
        if !added && other.noise_ratio() <= LOST && cost(&other.after.fit) < cost(&search.after.fit)
        {
            *search = other;
            return Ok(false);
        }
        let no_improvement =
            !added && strategy == Strategy::Annealed && base.has_not_improved_though_near();
        let agreed = found && added && name(&other) == name(search);
        if found && added {
            better_of(search, other, base.rounds.len(), problem.mask);
        } else if !found {
            *search = other;
        }
        found |= added;
        let enough = strategy.enough(base.noise_ratio());
        let enough = found && search.noise_ratio() < enough;
        if interrupt::asked() || agreed || no_improvement || enough {
            break;
        }
    }
    Ok(found)
}

/// Keeps what explains more of two strategies; the name that the other one gave is its rival from then on.
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

    use super::*;
    use crate::discover::candidates::cogging;
    use crate::discover::state::rounds::Round;
    use crate::discover::trial;
    use crate::estimate::noise;
    use crate::estimate::record::Record;

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
