//! What repeats and has no name goes into the model all the same.
//!
//! Where a generic family predicts what no named effect explains, and that matters, the disturbance of the
//! rotor's torque is laid into a torque map. It is fitted to the samples that are fitted to, and stays only if
//! samples that no fit has seen are the likelier for it and less is missing there.

use joint_core::effect::Kind;
use joint_core::params::Location;

use super::super::search::Stage;
use super::super::whereabouts::{of_push, pushed};
use super::blocks::{Blocks, Share};
use super::map::{Unexplained, fitted_map};
use super::shares::Disturbances;
use super::unseen::{Unseen, unseen};
use crate::estimate::filter::{Equation, Noise, Run, Walk};
use crate::estimate::fit::Problem;
use crate::estimate::refit::polish;
use crate::plant::{BuildError, Layout};

/// Sigmas beyond which lies a twentieth of a normal deviate, one-sided.
const SIGMAS: f64 = 1.645;
/// The disturbance may be so many times the torque noise that is expected, and wanders as fast in a tenth of a
/// second.
const LARGE: f64 = 20.0;
const PER_SECOND: f64 = 10.0;

/// A map of what is left beside the effects.
#[derive(Clone, Debug)]
pub(in super::super) struct Rest {
    /// The model with it as its last effect, refitted.
    pub(in super::super) stage: Stage,
    /// What samples that no fit has seen say of it.
    pub(in super::super) unseen: Unseen,
    /// Share that it takes of what the model without it misses there.
    pub(in super::super) share: Share,
}

/// A model with a torque map of what it misses; `None` where no map holds on the samples of `tested`.
///
/// # Errors
/// The model without it cannot be built.
pub(in super::super) fn mapped(
    problem: &Problem<'_>,
    named: &Stage,
    expected: &Noise,
    tested: &[bool],
) -> Result<Option<Rest>, BuildError> {
    let Stage { fit, origin } = named;
    let scale = LARGE * expected.torque;
    let walk = Walk::random(Equation::Torque(0), scale, PER_SECOND * scale);
    let run = pushed(problem, &fit.model, expected, walk)?;
    let series = of(&run, tested, Layout::of(&fit.model));
    let Some(map) = fitted_map(&series.unexplained(), Location::Motor) else {
        return Ok(None);
    };
    debug_assert_eq!(map.kind, Kind::TorqueMap);
    let [mut origin, mut start] = [origin.clone(), fit.model.clone()];
    origin.effects.push(map);
    start.effects.push(map);
    let (moved, noise) = (&fit.coordinates, &fit.noise);
    // A joint that has no room for a table is left as it is.
    let Ok(fit) = polish(&problem.rough(), &origin, &start, moved, expected, noise) else {
        return Ok(None);
    };
    let unseen = unseen(&problem.rough(), &named.fit, &fit, tested)?;
    let left = of_push(&pushed(problem, &fit.model, expected, walk)?);
    let missed = of_push(&run);
    let blocks = Blocks::of_series(tested, &missed);
    let gone = Disturbances { before: blocks.squares(&missed), after: blocks.squares(&left) };
    let share = gone.named();
    let holds = unseen.t > SIGMAS && share.value > SIGMAS * share.error;
    Ok(holds.then_some(Rest { stage: Stage { fit, origin }, unseen, share }))
}

/// What a run shows to be missing at the rotor, but for the samples of `tested`.
fn of(run: &Run, tested: &[bool], layout: Layout) -> Series {
    let torque = of_push(run).into_iter().zip(tested);
    let state = |number: usize| run.states.iter().map(|x| x[number]).collect();
    Series {
        torque: torque.map(|(torque, tested)| if *tested { f64::NAN } else { torque }).collect(),
        angle: state(Layout::ANGLE),
        speed: state(layout.speed(0)),
    }
}

/// Torque that is missing at the rotor, Nm, its angle, rad, and its speed, rad/s, by sample.
struct Series {
    torque: Vec<f64>,
    angle: Vec<f64>,
    speed: Vec<f64>,
}

impl Series {
    fn unexplained(&self) -> Unexplained<'_> {
        Unexplained {
            torque_nm: &self.torque,
            angle_rad: &self.angle,
            speed_rad_per_s: &self.speed,
        }
    }
}

#[cfg(test)]
mod tests {
    use joint_core::effect::EffectParameters;

    use super::super::super::trial;
    use super::*;
    use crate::estimate::noise;
    use crate::estimate::record::Record;

    /// The map of what a motor misses in whose log a drag of that size is hidden.
    fn found(drag: f64) -> Option<Rest> {
        let nominal = trial::motor();
        let hidden = EffectParameters::new(Kind::QuadraticDrag, Location::Motor);
        let log = trial::log(&nominal, hidden.with("coefficient_nm_s2", drag), 4.0);
        let record = Record::new(&log, None);
        let tested: Vec<bool> = (0..record.len()).map(|k| k % 1000 >= 700).collect();
        let mask: Vec<f64> = tested.iter().map(|t| if *t { 0.0 } else { 1.0 }).collect();
        let problem = Problem::new(&record, &mask).rough();
        let expected = noise::expected(&nominal, &record);
        let named = trial::fitted(&problem, &nominal, &[]);
        mapped(&problem, &named, &expected, &tested).unwrap()
    }

    #[test]
    fn a_drag_without_a_name_is_laid_into_a_map_that_unseen_samples_bear_out() {
        let rest = found(2e-5).unwrap();
        let map = rest.stage.fit.model.effects[0];
        assert_eq!((map.kind, map.location), (Kind::TorqueMap, Location::Motor));
        assert!(rest.share.value > 0.5 && rest.unseen.t > SIGMAS, "{:?}", rest.share);
    }
}
