//! What the prediction errors pull at: their derivative with a push on any equation at any sample.
//!
//! One pass backward through the filter gives it for every sample at once, so that any shape a
//! missing effect may have along the record is tried at the cost of a sum over samples.

use super::filter::{Equation, Gains, Linearisation, Observer, Run};
use super::record::{CHANNELS, Channel};

/// By sample: how a push on an equation, held over the interval after the sample, would change the
/// weighted sum of the innovations.
#[derive(Clone, Debug, Default)]
pub struct Pull {
    /// Torques on every mass, reflected to the motor, per Nm.
    pub torque: Vec<Vec<f64>>,
    /// The drive, per V, or per A where the current is imposed.
    pub drive: Vec<f64>,
    /// What each sensor shows, at the sample itself, per its unit.
    pub sensor: [Vec<f64>; CHANNELS],
    /// Every disturbance state of the filter, before the sample is measured, per its unit.
    pub walks: Vec<Vec<f64>>,
}

impl Observer<'_> {
    /// The pull of `weights` by sample and channel: `Σ w ∂e/∂push`.
    pub fn pull(&self, gains: &Gains, along: &Linearisation, weights: &[[f64; CHANNELS]]) -> Pull {
        let (n, order, samples) = (self.layout.len(), gains.order, self.record.len());
        let masses = self.layout.stages + 1;
        let mut pull = Pull {
            torque: vec![vec![0.0; samples]; masses],
            drive: vec![0.0; samples],
            sensor: std::array::from_fn(|_| vec![0.0; samples]),
            walks: vec![vec![0.0; samples]; gains.walks.len()],
        };
        let mut later = vec![0.0; order];
        let mut now = vec![0.0; order];
        let mut row = vec![0.0; order];
        let mut kick = vec![0.0; order];
        for k in (0..samples).rev() {
            if k + 1 < samples {
                for (mass, torque) in pull.torque.iter_mut().enumerate() {
                    kick.fill(0.0);
                    self.push(&mut kick, mass, 1.0, self.record.grid.interval(k));
                    torque[k] = dot(&kick, &later);
                }
                pull.drive[k] = dot(&along.drive[k * n..(k + 1) * n], &later);
                now.copy_from_slice(&later);
                now[..n].fill(0.0);
                for (i, later) in later.iter().enumerate().take(n) {
                    let from = &along.transition[(k * n + i) * n..(k * n + i + 1) * n];
                    for (now, slope) in now.iter_mut().zip(from) {
                        *now += slope * later;
                    }
                }
                for (j, walk) in gains.walks.iter().enumerate() {
                    if walk.equation == Equation::CurrentBefore {
                        now[n + j] = 0.0;
                        row.fill(0.0);
                        self.reported_by(&mut row);
                        for (now, row) in now.iter_mut().zip(&row) {
                            *now += row * later[n + j];
                        }
                        continue;
                    }
                    now[n + j] *= walk.kept(self.record.grid.interval(k));
                    now[n + j] += match walk.equation {
                        Equation::Voltage => pull.drive[k],
                        Equation::Torque(mass) => pull.torque[mass][k],
                        Equation::Sensor(_) | Equation::CurrentBefore => 0.0,
                    };
                }
                later.copy_from_slice(&now);
            }
            for channel in Channel::ALL.into_iter().rev() {
                let c = channel as usize;
                let weight = gains.weight[k][c];
                if weight == 0.0 {
                    continue;
                }
                let slot = (k * CHANNELS + c) * order;
                let along_error = weights[k][c] + dot(&gains.gain[slot..slot + order], &later);
                pull.sensor[c][k] = -weight * along_error;
                self.sensitivity(channel, &gains.walks, &mut row);
                for (later, row) in later.iter_mut().zip(&row) {
                    *later -= weight * along_error * row;
                }
            }
            for (walk, later) in pull.walks.iter_mut().zip(&later[n..]) {
                walk[k] = *later;
            }
            if self.record.starts.contains(&k) {
                later.fill(0.0);
            }
        }
        pull
    }

    /// The last disturbance state of a run as all its samples show it, those that follow too, by sample: a filter's
    /// own estimate comes late. What the prior says of each of its steps is moved by what the innovations pull at
    /// (Bryson and Frazier, Smoothing for linear and nonlinear dynamic systems, 1963).
    pub fn smoothed(&self, gains: &Gains, along: &Linearisation, run: &Run) -> Option<Vec<f64>> {
        let walk = gains.walks.last()?;
        let pull = self.pull(gains, along, &run.innovations).walks.pop()?;
        let mut value = 0.0;
        let step = |(k, pull): (usize, f64)| {
            value = match k.checked_sub(1).filter(|_| !self.record.starts.contains(&k)) {
                None => -walk.initial.powi(2) * pull,
                Some(before) => {
                    let interval = self.record.grid.interval(before);
                    walk.kept(interval) * value - walk.gained(interval) * pull
                }
            };
            value
        };
        Some(pull.into_iter().enumerate().map(step).collect())
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;
    use std::f64::consts::TAU;

    use super::*;
    use crate::filter::Walk;
    use crate::fit::Problem;
    use crate::noise::expected;
    use crate::record::Record;
    use joint_simulation::demo::actuator;
    use joint_simulation::plant::plant;
    use joint_simulation::synthetic::{Experiment, record};

    #[test]
    fn a_smoothed_disturbance_ends_as_the_filters_does_and_is_nearer_to_the_truth_before() {
        let model = actuator();
        let load = |k: i32| 0.4 * (TAU * 4.0 * 2e-4 * f64::from(k)).sin();
        let load_nm: Vec<f64> = (0..5000).map(load).collect();
        let experiment = Experiment { load_nm: load_nm.clone(), ..Experiment::clean(1.0) };
        let record = Record::new(&record(&model, &experiment, 4).unwrap(), None);
        let noise = expected(&model, &record);
        let shaft: f64 = model.stages.iter().map(|stage| stage.reduction).product();
        let walk = Walk::random(Equation::Torque(model.stages.len()), 0.4 / shaft, 4.0 / shaft);
        let plant = plant(&model, &record.grid, record.drive).unwrap();
        let observer = Observer::new(&model, &*plant, &record);
        let mut along = Cow::Owned(Linearisation::default());
        let (gains, run) = observer.design_along(&mut along, &noise, &[walk]);
        let filtered: Vec<f64> = run.states.iter().map(|x| x[x.len() - 1]).collect();
        let smoothed = observer.smoothed(&gains, &along, &run).unwrap();
        let last = smoothed.len() - 1;
        assert!((smoothed[last] - filtered[last]).abs() < 1e-6 * 0.4 / shaft);
        // A load brakes: it is a torque against the positive direction.
        let off = |series: &[f64]| {
            let pairs = series.iter().zip(&load_nm);
            (pairs.map(|(own, load)| (own + load / shaft).powi(2)).sum::<f64>()).sqrt()
        };
        let (late, whole, truth) = (off(&filtered), off(&smoothed), off(&vec![0.0; last + 1]));
        assert!(whole < 0.5 * late && whole < 0.2 * truth, "{whole} {late} {truth}");
    }
    #[test]
    fn a_pull_is_the_change_of_the_errors_beside_a_current_that_is_late_by_parts_of_a_sample() {
        let mut model = actuator();
        model.sensor.current_delay_s = 2.8e-4;
        let record = Record::new(&record(&model, &Experiment::clean(0.2), 4).unwrap(), None);
        let noise = expected(&model, &record);
        let mask = vec![1.0; record.len()];
        let walks = Problem::new(&record, &mask).walks(&noise, &model);
        let plant = plant(&model, &record.grid, record.drive).unwrap();
        let observer = Observer::new(&model, &*plant, &record);
        let mut along = Cow::Owned(Linearisation::default());
        let (gains, run) = observer.design_along(&mut along, &noise, &walks);
        let pull = observer.pull(&gains, &along, &run.innovations);
        let pulled = |k: usize, push: f64| {
            let mut moved = record.clone();
            moved.drive_values[k] += push;
            let rows = Observer::new(&model, &*plant, &moved).innovations(&gains);
            let weighed = rows.iter().flatten().zip(run.innovations.iter().flatten());
            weighed.map(|(error, weight)| error * weight).sum::<f64>()
        };
        for k in [150, 400, 700] {
            let wanted = (pulled(k, 1e-5) - pulled(k, -1e-5)) / 2e-5;
            let off = (pull.drive[k] - wanted).abs();
            assert!(off < 1e-2 * wanted.abs(), "{k}: {} {wanted}", pull.drive[k]);
        }
    }
}
