//! Steps from one place at several dampings: the first that helps is taken, and near a minimum that is
//! often the third or none.
//!
//! One run uses one core and one lane of it. So the others are run side by side as soon as somebody has
//! time, and stopped where the first has helped.

use std::sync::atomic::{AtomicBool, Ordering};

use super::abreast::Rows;
use super::filter::Gains;
use super::fit::Problem;
use super::record::CHANNELS;
use joint_simulation::model::Model;

/// Errors, in sigmas, of a joint that is thrown: alone it counts turns as far as whole numbers go, and is
/// lost then; side by side it flies on.
const THROWN: f64 = 1e9;

/// What models make of a record with the same gains, each run when it is asked for or before.
pub(super) struct Trials<'t> {
    problem: &'t Problem<'t>,
    gains: &'t Gains,
    models: &'t [Model],
    /// Of those after the first, where they have been run side by side.
    others: Option<Vec<Rows>>,
}

impl<'t> Trials<'t> {
    /// Of models that are tried in this order.
    pub(super) fn of(problem: &'t Problem<'t>, gains: &'t Gains, models: &'t [Model]) -> Self {
        Self { problem, gains, models, others: None }
    }

    /// Innovations of the first; of the others as well, while it is under way, unless it `helps`.
    pub(super) fn first(&mut self, helps: impl Fn(&Rows) -> bool + Sync) -> Rows {
        let taken = AtomicBool::new(false);
        let first = || {
            let rows = self.alone(0);
            taken.store(helps(&rows), Ordering::Relaxed);
            rows
        };
        let others = || self.problem.side_by_side(&self.models[1..], self.gains, &taken);
        let (rows, others) = rayon::join(first, others);
        self.others = others;
        rows
    }

    /// Innovations of one of them.
    pub(super) fn run(&mut self, number: usize) -> Rows {
        let Some(place) = number.checked_sub(1) else { return self.alone(0) };
        if self.others.is_none() {
            let going_on = AtomicBool::new(false);
            let others = self.problem.side_by_side(&self.models[1..], self.gains, &going_on);
            self.others = others.or(Some(Vec::new()));
        }
        match self.others.as_mut().and_then(|others| others.get_mut(place)) {
            Some(rows) if !is_thrown(rows) => std::mem::take(rows),
            _ => self.alone(number),
        }
    }

    /// Of one by itself; no numbers where it cannot be built.
    fn alone(&self, number: usize) -> Rows {
        let rows = self.problem.innovations(&self.models[number], self.gains);
        rows.unwrap_or_else(|_| vec![[f64::NAN; CHANNELS]; self.problem.record.len()])
    }
}

/// Whether a joint was thrown.
fn is_thrown(rows: &Rows) -> bool {
    rows.iter().flatten().any(|error| error.abs() > THROWN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise;
    use crate::parameters::Quantity;
    use crate::record::Record;
    use joint_simulation::demo::actuator;
    use joint_simulation::synthetic::{Experiment, record};

    #[test]
    fn what_is_tried_side_by_side_has_the_bits_of_each_alone() {
        let model = actuator();
        let log = record(&model, &Experiment::clean(0.3), 5).unwrap();
        let record = Record::new(&log, None);
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask);
        let gains = problem.design(&model, &noise::expected(&model, &record)).unwrap().gains;
        let off = |step: f64| {
            let mut moved = model.clone();
            Quantity::Stiffness(0).shift(&mut moved, step);
            moved
        };
        let alike = [off(0.3), off(0.1), off(-0.1)];
        let mut broken = off(0.1);
        broken.motor.rotor_inertia_kg_m2 = -1.0;
        let with_broken = [off(0.3), broken, off(-0.1)];
        let alone = |model: &Model| problem.innovations(model, &gains).ok();
        for models in [&alike, &with_broken] {
            for first_helps in [false, true] {
                let mut trials = Trials::of(&problem, &gains, models);
                assert_eq!(Some(trials.first(|_| first_helps)), alone(&models[0]));
                for (number, model) in models.iter().enumerate().skip(1) {
                    let rows = trials.run(number);
                    match alone(model) {
                        Some(wanted) => assert_eq!(rows, wanted),
                        None => assert!(rows.iter().flatten().all(|error| error.is_nan())),
                    }
                }
            }
        }
        let stopped = AtomicBool::new(true);
        assert!(problem.side_by_side(&alike, &gains, &stopped).is_none());
        stopped.store(false, Ordering::Relaxed);
        assert!(problem.side_by_side(&alike, &gains, &stopped).is_some());
        assert!(problem.side_by_side(&with_broken, &gains, &stopped).is_none());
    }
}
