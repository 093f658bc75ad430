//! What repeats and has no name goes into the model all the same.
//!
//! Where a generic family predicts what no named effect explains, and that matters, the disturbance of an
//! equation of torque is laid into a torque map. It is fitted to the samples that are fitted to, and stays only
//! if samples that no fit has seen are the likelier for it, less is missing there, and a free run over them comes
//! nearer. Of several maps the one does whose free run comes nearest: a disturbance that is estimated near
//! standstill follows the friction's state, and as a torque over the speed it would push a joint that rests.

use joint_core::effect::EffectParameters;
use joint_core::params::Location;
use rayon::prelude::*;

use super::blocks::{Blocks, Share};
use super::budget::FreeRun;
use super::disturbance::{disturbance_of, run_beside};
use super::map::{Unexplained, fitted_maps};
use super::shares::Disturbances;
use super::unseen::{Unseen, unseen};
use crate::discover::bounds::SIGMAS;
use crate::discover::state::stage::Stage;
use crate::estimate::coordinates::Coordinate;
use crate::estimate::filter::{Equation, Noise, Run, Walk};
use crate::estimate::fit::Problem;
use crate::estimate::refit::polish;
use crate::model::Model;
use crate::plant::{BuildError, Layout};

/// One sigma of a map's scale.
const WIDE: f64 = 10.0;
/// A map of what is left beside the effects.
#[derive(Clone, Debug)]
pub(crate) struct Rest {
    /// The model with it as its last effect, refitted.
    pub(crate) stage: Stage,
    /// What samples that no fit has seen say of it.
    pub(crate) unseen: Unseen,
    /// Share that it takes of what the model without it misses there.
    pub(crate) share: Share,
}

/// A model with a torque map of what it misses in an equation of torque; `None` where no map holds on the
/// samples of `tested`.
///
/// # Errors
/// The model without it cannot be built.
pub(crate) fn mapped(
    problem: &Problem<'_>,
    named: &Stage,
    walk: Walk,
    [noise, expected]: [&Noise; 2],
    tested: &[bool],
) -> Result<Option<Rest>, BuildError> {
    let Stage { fit, origin } = named;
    let Equation::Torque(mass) = walk.equation else { return Ok(None) };
    let run = run_beside(problem, &fit.model, noise, walk)?;
    let maps = Side::of(mass, &fit.model).map_or(Vec::new(), |side| side.maps(&run, tested));
    let missed = disturbance_of(&run);
    let blocks = Blocks::of_series(tested, &missed);
    let before = blocks.squares(&missed);
    let tried = maps.into_par_iter().map(|map| {
        let [mut origin, mut start] = [origin.clone(), fit.model.clone()];
        let effect = start.effects.len();
        origin.effects.push(map);
        start.effects.push(map);
        // What the filter makes of a disturbance is less than the disturbance, in one proportion.
        let mut moved = fit.coordinates.clone();
        moved.push(Coordinate::Effect { effect, value: 0, scale: 1.0, sigma: WIDE });
        let mut fit = polish(problem, &origin, &start, &moved, expected, &fit.noise)?;
        let unseen = unseen(problem, &named.fit, &fit, tested)?;
        let left = disturbance_of(&run_beside(problem, &fit.model, noise, walk)?);
        let gone = Disturbances { before: before.clone(), after: blocks.squares(&left) };
        let share = gone.named();
        let free_run = FreeRun::of(problem.record, [&named.fit, &fit], noise, tested)?.factor();
        if let Some(map) = fit.model.effects.last_mut() {
            *map = scaled(*map);
        }
        Ok((free_run, Rest { stage: Stage { fit, origin }, unseen, share }))
    });
    let tried: Vec<Result<_, BuildError>> = tried.collect();
    // A joint that has no room for a table is left as it is.
    let held = tried.into_iter().flatten();
    let held = held.filter(|(free_run, rest)| holds(rest.unseen.t, rest.share, *free_run));
    Ok(held.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, rest)| rest))
}

/// Whether a map stays: unseen samples are the likelier for it by this t, it takes a share of what is missing there, and
/// a free run is off by this factor of what it was.
fn holds(unseen_t: f64, share: Share, free_run: f64) -> bool {
    unseen_t > SIGMAS && share.value > SIGMAS * share.error && free_run < 1.0
}

/// A map whose knots are its torques themselves.
fn scaled(map: EffectParameters) -> EffectParameters {
    let scale = map.values[0];
    let by = |curve: &[f64]| curve.iter().map(|torque| scale * torque).collect::<Vec<_>>();
    let [forward, backward] = [map.table.forward(), map.table.backward()].map(by);
    map.with("scale", 1.0).with_table(&forward, &backward).unwrap_or(map)
}

/// A side of the joint that has a map of its own.
struct Side {
    location: Location,
    /// Turns of the motor per turn of it.
    reduction: f64,
    layout: Layout,
    mass: usize,
}

impl Side {
    /// The side of a mass, if it is the rotor or the output.
    fn of(mass: usize, model: &Model) -> Option<Self> {
        let location = match mass {
            0 => Location::Motor,
            _ if mass == model.stages.len() => Location::Output,
            _ => return None,
        };
        let reduction = model.stages[..mass].iter().map(|stage| stage.reduction).product();
        Some(Self { location, reduction, layout: Layout::of(model), mass })
    }

    /// The maps of what a run shows to be missing, but for the samples of `tested`.
    fn maps(&self, run: &Run, tested: &[bool]) -> Vec<EffectParameters> {
        let Self { reduction, layout, mass, .. } = *self;
        let angle = |x: &Vec<f64>| {
            let wound: f64 = (0..mass).map(|stage| x[layout.deflection(stage)]).sum();
            (x[Layout::ANGLE] - wound) / reduction
        };
        let told =
            |(torque, tested): (f64, &bool)| if *tested { f64::NAN } else { torque * reduction };
        let torque: Vec<f64> = disturbance_of(run).into_iter().zip(tested).map(told).collect();
        let angle: Vec<f64> = run.states.iter().map(angle).collect();
        let speed: Vec<f64> =
            run.states.iter().map(|x| x[layout.speed(mass)] / reduction).collect();
        let of = Unexplained { torque_nm: &torque, angle_rad: &angle, speed_rad_per_s: &speed };
        fitted_maps(&of, self.location)
    }
}

#[cfg(test)]
mod tests {
    use joint_core::effect::Kind;
    use joint_core::params::Stage;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::demo::actuator;
    use crate::discover::trial;
    use crate::estimate::noise;
    use crate::estimate::record::Record;
    use crate::synthetic::{Experiment, record};

    /// The map of what a motor misses in whose log of 5 s a drag of that size is hidden.
    fn found(drag: f64) -> Option<Rest> {
        let nominal = trial::motor();
        let hidden = EffectParameters::new(Kind::QuadraticDrag, Location::Motor);
        let mut truth = nominal.clone();
        truth.effects.push(hidden.with("coefficient_nm_s2", drag));
        let swing = |k: i32| {
            let time_s = 2e-4 * f64::from(k);
            (1.0 + 3.0 * (0.9 * time_s).sin().powi(2)) * (20.0 * time_s).sin()
        };
        let voltage_v = Some((0..25_000).map(swing).collect());
        let log = record(&truth, &Experiment { voltage_v, ..Experiment::clean(5.0) }, 5).unwrap();
        let record = Record::new(&log, None);
        let (tested, mask) = trial::split(&record);
        let problem = Problem::new(&record, &mask).rough();
        let expected = noise::expected(&nominal, &record);
        let named = trial::fitted(&problem, &nominal, &[]);
        let scale = 20.0 * expected.torque;
        let walk = Walk::random(Equation::Torque(0), scale, 10.0 * scale);
        mapped(&problem, &named, walk, [&expected; 2], &tested).unwrap()
    }

    #[test]
    fn a_drag_without_a_name_is_laid_into_a_map_that_unseen_samples_bear_out() {
        let rest = found(2e-5).unwrap();
        let map = rest.stage.fit.model.effects[0];
        assert_eq!((map.kind, map.location), (Kind::TorqueMap, Location::Motor));
        assert!(
            rest.share.value > 5.0 * rest.share.error && rest.unseen.t > 5.0,
            "{:?}",
            rest.share
        );
    }

    #[test]
    fn a_map_stays_only_where_likelihood_share_and_free_run_all_say_so() {
        let share = |errors: f64| Share { value: 0.01 * errors, error: 0.01 };
        let [little, enough] = [0.9 * SIGMAS, 1.1 * SIGMAS];
        assert!(holds(enough, share(enough), 0.99));
        assert!(!holds(little, share(enough), 0.99));
        assert!(!holds(enough, share(little), 0.99));
        assert!(!holds(enough, share(enough), 1.01));
    }

    #[test]
    fn a_fitted_maps_scale_goes_into_its_knots() {
        let map = EffectParameters::new(Kind::TorqueMap, Location::Motor).with("period_rad", 1.0);
        let map = map.with_table(&[1.0, -2.0], &[0.5, 4.0]).unwrap().with("scale", 3.0);
        let scaled = scaled(map);
        assert_eq!(scaled.get("scale"), Some(1.0));
        assert_eq!([scaled.table.forward(), scaled.table.backward()], [[3.0, -6.0], [1.5, 12.0]]);
    }

    /// The demonstration's joint with a second gear: 9:1, then 4:1.
    fn geared() -> Model {
        let mut model = actuator();
        model.stages.push(Stage { reduction: 4.0, ..model.stages[0] });
        model
    }

    #[test]
    fn rotor_and_output_have_maps_and_what_is_between_them_has_none() {
        let side = |mass| {
            let side = Side::of(mass, &geared());
            side.map(|side| (side.location, side.reduction))
        };
        let wanted = [Some((Location::Motor, 1.0)), None, Some((Location::Output, 36.0))];
        assert_eq!([0, 1, 2].map(side), wanted);
    }

    #[test]
    fn a_map_of_the_output_is_over_its_own_angle_and_speed_in_its_own_torque() {
        let model = geared();
        let layout = Layout::of(&model);
        let mut random = ChaCha8Rng::seed_from_u64(1);
        // To and fro; another law forth than back, and noise of a twentieth of it.
        let moves = |k: usize| {
            let phase = k as f64 * 0.011 + 0.5 * (k as f64 * 0.0013).sin();
            (2.0 * phase.sin(), 30.0 * phase.cos())
        };
        let law = |q: f64, v: f64| if v > 0.0 { 3.0 * q.sin() } else { -2.0 * q };
        let states = (0..8000).map(|k| {
            let (q, v) = moves(k);
            let noise = random.random_range(-0.2..0.2);
            let mut state = vec![0.0; layout.len() + 1];
            state[layout.deflection(0)] = 0.5;
            state[layout.deflection(1)] = 2.5;
            state[Layout::ANGLE] = 36.0 * q + 3.0;
            state[layout.speed(2)] = 36.0 * v;
            state[layout.len()] = (law(q, v) + noise) / 36.0;
            state
        });
        let run = Run { innovations: Vec::new(), states: states.collect() };
        let maps = Side::of(2, &model).unwrap().maps(&run, &[false; 8000]);
        let map = maps[0];
        let get = |key| map.get(key).unwrap();
        assert!((get("start_rad") + 2.0).abs() < 1e-3 && (get("span_rad") - 4.0).abs() < 1e-3);
        let rms = ((0..8000).map(|k| moves(k).1.powi(2)).sum::<f64>() / 8000.0).sqrt();
        assert!((get("blend_rad_per_s") / rms - 0.1).abs() < 1e-9, "{map:?}");
        let knots = map.table.forward();
        for (k, knot) in knots.iter().enumerate().skip(1).take(knots.len() - 2) {
            let wanted = law(4.0 * k as f64 / (knots.len() - 1) as f64 - 2.0, 1.0);
            assert!((knot - wanted).abs() < 0.3, "{k}: {knot} {wanted}");
        }
        assert!(Side::of(2, &model).unwrap().maps(&run, &[true; 8000]).is_empty());
    }
}
