//! Two names that explain about as much, of which neither is all.
//!
//! Which of them comes first is then decided by a local minimum of the fit, and every later name is one beside it.
//! So where something is still missing in the end, the way that the second one leads is gone as well: a beam of two.

use super::rounds::look;
use crate::discover::bounds::{AS_MUCH, DOUBTED, LEAST_GAIN};
use crate::discover::checks::bootstrap::stays_ahead;
use crate::discover::state::rounds::{Contender, Round};
use crate::discover::state::search::{CloseSecond, Search};
use crate::estimate::fit::Problem;
use crate::estimate::refit::cost;
use crate::interrupt;
use crate::plant::BuildError;

impl Search {
    /// Keeps the name that came second in the first round, where it explained about as much.
    pub(crate) fn keep_close_second(&mut self) {
        let [first] = &self.rounds[..] else { return };
        let (Some(stage), Some(contender)) = (&first.runner_up, first.rivals.first()) else {
            return;
        };
        if contender.gain >= AS_MUCH * first.gain {
            let first = Contender { name: first.name, gain: first.gain };
            let (contender, stage) = (contender.clone(), stage.clone());
            self.close_second = Some(CloseSecond { contender, first, stage });
        }
    }
}

/// Searches again from the second name, where something is missing at the end; keeps what explains more.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn try_close_second(last: Problem<'_>, search: &mut Search) -> Result<(), BuildError> {
    let Some(second) = search.close_second.take() else { return Ok(()) };
    if interrupt::asked() || search.noise_ratio() < DOUBTED {
        return Ok(());
    }
    let CloseSecond { contender: Contender { name, gain }, first, stage } = second;
    let mut other = search.clone();
    other.rounds = vec![Round {
        name,
        gain,
        rivals: vec![first],
        runner_up: None,
        stays_ahead: stays_ahead(&stage.fit, &[&search.before.fit], last.mask),
    }];
    other.after = stage;
    other.scores.retain(|row| row.round == 1);
    other.chance.truncate(1);
    look(last, &mut other)?;
    if cost(&search.after.fit) - cost(&other.after.fit) > LEAST_GAIN {
        let reached = &search.after;
        other.rounds[0].stays_ahead =
            stays_ahead(&other.after.fit, &[&reached.fit, &search.before.fit], last.mask);
        other.rounds[0].runner_up = Some(reached.clone());
        *search = other;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use joint_core::effect::Kind;
    use joint_core::params::Location;

    use super::*;
    use crate::discover::candidates::cogging;
    use crate::discover::state::stage::Stage;
    use crate::discover::trial;
    use crate::estimate::noise;
    use crate::estimate::record::Record;

    const LINE: (Kind, Location) = (Kind::Cogging, Location::Motor);

    /// The order of the line that is left of two, where the first one explained nothing, the second one's
    /// gain was this share of the first one's, and order 12 is the right one.
    fn left(orders: [f64; 2], share: f64) -> f64 {
        let nominal = trial::motor();
        let record = Record::new(&trial::log(&nominal, trial::line(12.0), 4.0), None);
        let mask = vec![1.0; record.measured.len()];
        let problem = Problem::new(&record, &mask).rough();
        let expected = noise::expected(&nominal, &record);
        let with = |order| trial::fitted(&problem, &nominal, &[cogging::line(order, 0.01, false)]);
        let [first, second]: [Stage; 2] = orders.map(with);
        let before = trial::fitted(&problem, &nominal, &[]);
        let mut search = Search::new(before, &[], expected);
        search.rounds.push(Round {
            name: LINE,
            gain: 1000.0,
            rivals: vec![Contender { name: LINE, gain: share * 1000.0 }],
            runner_up: Some(second),
            stays_ahead: 0.5,
        });
        search.after = first;
        search.keep_close_second();
        try_close_second(problem, &mut search).unwrap();
        assert_eq!(search.rounds.len(), 1);
        search.after.fit.model.effects[0].values[0]
    }

    #[test]
    fn what_came_second_is_tried_where_something_is_missing_in_the_end() {
        assert_eq!(left([5.0, 12.0], 0.95), 12.0);
        assert_eq!(left([12.0, 5.0], 0.95), 12.0);
        assert_eq!(left([5.0, 12.0], 0.5), 5.0);
    }
}
