//! Runs of several models with the same gains: those that differ by their numbers alone are run side by
//! side, up to as many as there are lanes in the time of one or two.
//!
//! A derivative by differences, and the score of a name, are a run for every value that may move.

use std::sync::atomic::{AtomicBool, Ordering};

use joint_core::number::Number;
use joint_core::work::Work;
use rayon::prelude::*;

use super::filter::{Equation, Gains, Observer};
use super::fit::Problem;
use super::record::{CHANNELS, Channel};
use joint_simulation::lanes::{Abreast, LANES, Lanes};
use joint_simulation::model::Model;
use joint_simulation::plant::{Plant, plant};
use joint_simulation::wide;

/// Innovations by sample and channel.
pub type Rows = Vec<[f64; CHANNELS]>;

impl Problem<'_> {
    /// Innovations of models with frozen gains, bit for bit those of [`Problem::innovations`]; `None`
    /// where a model cannot be built.
    pub fn innovations_of(&self, models: &[Model], gains: &Gains) -> Vec<Option<Rows>> {
        let plant = |model| plant(model, &self.record.grid, self.record.drive).ok();
        let plants: Vec<Option<Box<dyn Plant>>> = models.iter().map(plant).collect();
        let mut alike: Vec<Vec<usize>> = Vec::new();
        for number in (0..models.len()).filter(|number| plants[*number].is_some()) {
            let own = alike.iter_mut().find(|known| are_alike(&models[known[0]], &models[number]));
            match own {
                Some(known) => known.push(number),
                None => alike.push(vec![number]),
            }
        }
        let together: Vec<&[usize]> = alike.iter().flat_map(|own| own.chunks(LANES)).collect();
        let run = |numbers: &&[usize]| {
            let own =
                numbers.iter().filter_map(|number| Some((*number, plants[*number].as_deref()?)));
            let observers: Vec<Observer<'_>> =
                own.map(|(number, plant)| self.observer(&models[number], plant)).collect();
            numbers.iter().copied().zip(innovations(&observers, gains)).collect::<Vec<_>>()
        };
        let mut found = vec![None; models.len()];
        for (number, rows) in together.par_iter().flat_map_iter(run).collect::<Vec<_>>() {
            found[number] = Some(rows);
        }
        found
    }

    /// The same of models, no more than there are lanes, all of them side by side; `None` where that cannot be
    /// done, or as soon as they are stopped.
    pub(super) fn side_by_side(
        &self,
        models: &[Model],
        gains: &Gains,
        stopped: &AtomicBool,
    ) -> Option<Vec<Rows>> {
        let over = || stopped.load(Ordering::Relaxed);
        if models.is_empty() || models.len() > LANES || over() {
            return None;
        }
        let plant = |model| plant(model, &self.record.grid, self.record.drive).ok();
        let plants: Vec<Box<dyn Plant>> = models.iter().map(plant).collect::<Option<_>>()?;
        let alike = models.iter().all(|model| are_alike(&models[0], model));
        let own = models.iter().zip(&plants);
        let observers: Vec<_> = own.map(|(model, own)| self.observer(model, &**own)).collect();
        let joints = alike.then(|| abreast(&observers)).flatten()?;
        let rows = wide::run(Together { observers: &observers, joints: &*joints, gains, stopped });
        (!over()).then_some(rows)
    }
}

/// Samples after which a run that may be stopped asks whether it is.
const ASKED: usize = 64;

/// Whether models have the same laws at the same places.
fn are_alike(one: &Model, other: &Model) -> bool {
    let laws = |model: &Model| {
        let effects = model.effects.iter().map(|effect| (effect.kind, effect.location));
        effects.collect::<Vec<_>>()
    };
    one.stages.len() == other.stages.len() && laws(one) == laws(other)
}

/// [`Observer::innovations`] of observers, no more than there are lanes, whose records differ in what was
/// measured alone; side by side if their plants are alike.
pub(super) fn innovations(observers: &[Observer<'_>], gains: &Gains) -> Vec<Rows> {
    let joints = (observers.len() > 1).then(|| abreast(observers)).flatten();
    match joints {
        Some(joints) => {
            let stopped = &AtomicBool::new(false);
            wide::run(Together { observers, joints: &*joints, gains, stopped })
        }
        None => observers.iter().map(|own| own.innovations(gains)).collect(),
    }
}

/// The plants of observers side by side; `None` where they are not alike after all.
fn abreast(observers: &[Observer<'_>]) -> Option<Box<dyn Abreast>> {
    let first = observers.first()?;
    let constants: Vec<_> = observers.iter().map(|own| own.plant.constants()).collect();
    first.plant.abreast(&constants.iter().collect::<Vec<_>>())
}

/// Observers whose plants are side by side, one at least, and the gains of them all.
struct Together<'a, 'o> {
    observers: &'a [Observer<'o>],
    joints: &'a dyn Abreast,
    gains: &'a Gains,
    /// Whether nobody waits for them any more.
    stopped: &'a AtomicBool,
}

impl Work for Together<'_, '_> {
    type Output = Vec<Rows>;

    /// [`Observer::innovations`] of each, as far as somebody waits for them.
    #[inline(always)]
    fn run(self) -> Vec<Rows> {
        let Self { observers, joints, gains, stopped } = self;
        let first = &observers[0];
        let of_lane = |lane: usize| observers.get(lane).unwrap_or(first);
        let designed = gains.order - gains.walks.len();
        let own = first.layout.len();
        let common = designed.min(own);
        let order = own + gains.walks.len();
        let before = gains.walks.iter().position(|walk| walk.equation == Equation::CurrentBefore);
        let plain = before.is_none() && observers.iter().all(|own| !own.sensor_errors);
        let shafts = Lanes(std::array::from_fn(|lane| of_lane(lane).shaft));
        let late: [Lanes; CHANNELS] =
            std::array::from_fn(|c| Lanes(std::array::from_fn(|lane| of_lane(lane).late.by[c])));
        let measured: [&[[f64; CHANNELS]]; LANES] =
            std::array::from_fn(|lane| &*of_lane(lane).late.measured);
        let mut x = vec![Lanes::ZERO; order];
        let mut rows = vec![vec![[0.0; CHANNELS]; first.record.len()]; observers.len()];
        for k in 0..first.record.len() {
            if k % ASKED == 0 && stopped.load(Ordering::Relaxed) {
                break;
            }
            if first.is_idle(k) {
                continue;
            }
            if first.record.starts.contains(&k) {
                for lane in 0..LANES {
                    let before = |state: usize| Some(x[state].0[lane]);
                    let start = of_lane(lane).start(k, &gains.walks, before);
                    x.iter_mut().zip(start).for_each(|(x, value)| x.0[lane] = value);
                }
            }
            for channel in Channel::ALL {
                let c = channel as usize;
                let weight = gains.weight[k][c];
                if weight == 0.0 {
                    continue;
                }
                let shown = if plain {
                    let [bias, there, speed] =
                        first.seen(channel, |state| x[state], &gains.walks, shafts);
                    (bias + there + late[c] * speed).0
                } else {
                    std::array::from_fn(|lane| {
                        of_lane(lane).shown_of(channel, |state| x[state].0[lane], &gains.walks)
                    })
                };
                let mut errors = Lanes::ZERO;
                for ((error, shown), measured) in errors.0.iter_mut().zip(shown).zip(measured) {
                    let own = (measured[k][c] - shown) * weight;
                    *error = if own.is_finite() { own } else { 0.0 };
                }
                for (rows, error) in rows.iter_mut().zip(&errors.0) {
                    rows[k][c] = *error;
                }
                let slot = (k * CHANNELS + c) * gains.order;
                let (states, walks) = gains.gain[slot..slot + gains.order].split_at(designed);
                let (head, tail) = x.split_at_mut(own);
                let corrected =
                    head[..common].iter_mut().zip(states).chain(tail.iter_mut().zip(walks));
                for (value, gain) in corrected {
                    *value = *value + Lanes::all(*gain) * errors;
                }
            }
            let own_drives: [_; LANES] =
                std::array::from_fn(|lane| of_lane(lane).late.drives(first.record, k));
            let mut drives = [0, 1].map(|part| Lanes(own_drives.map(|drives| drives[part])));
            for (walk, push) in gains.walks.iter().zip(&x[own..]) {
                if walk.equation == Equation::Voltage {
                    drives = drives.map(|drive| drive + *push);
                }
            }
            if let Some(j) = before {
                for lane in 0..LANES {
                    x[own + j].0[lane] = of_lane(lane).reported(|state| x[state].0[lane]);
                }
            }
            joints.propagate(k, &mut x[..own], drives, first.record.load_nm[k]);
            let interval = first.record.grid.interval(k);
            for (j, walk) in gains.walks.iter().enumerate() {
                if let Equation::Torque(mass) = walk.equation {
                    let torques = x[own + j];
                    for (lane, torque) in torques.0.into_iter().enumerate() {
                        let change = |state: usize, by| x[state].0[lane] += by;
                        of_lane(lane).pushed(mass, torque, interval, change);
                    }
                }
                x[own + j] = x[own + j] * Lanes::all(walk.kept(interval));
            }
        }
        rows
    }
}
