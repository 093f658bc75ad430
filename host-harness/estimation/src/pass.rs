//! A filter's way along a record: every sample corrects the state, and the covariance says by how much;
//! both are carried to the next.
//!
//! It is made in stretches, so that what watches it may be done with one on another core while the next is
//! under way.

use std::borrow::Cow;
use std::ops::Range;

use super::covariance::{Covariance, Transition};
use super::energy::Energy;
use super::gains::{Equation, Linearisation, Noise, Walk};
use super::keep::{Keep, Measured, Passed};
use super::observer::Observer;
use super::record::Channel;
use super::scales::Scales;
use joint_simulation::lanes::Linear;

/// How far a filter has come, and what it takes along.
pub(super) struct Pass<'p, 'a, 'l> {
    observer: &'p Observer<'a>,
    along: &'p mut Cow<'l, Linearisation>,
    noise: &'p Noise,
    walks: &'p [Walk],
    scales: Scales,
    /// What linearises the joint where it has not been.
    linear: Option<Box<dyn Linear>>,
    x: Vec<f64>,
    p: Covariance,
    scratch: Scratch,
}

impl<'p, 'a, 'l> Pass<'p, 'a, 'l> {
    /// Along a linearisation, which is made if it is empty.
    pub(super) fn new(
        observer: &'p Observer<'a>,
        along: &'p mut Cow<'l, Linearisation>,
        noise: &'p Noise,
        walks: &'p [Walk],
    ) -> Self {
        let (samples, states) = (observer.record.len(), observer.layout.len());
        let made = along.covers(samples, states);
        if !made {
            along.to_mut().reserve(samples, states);
        }
        Self {
            observer,
            noise,
            walks,
            scales: observer.known.scales(observer.record, observer.layout),
            linear: (!made).then(|| observer.plant.linear()),
            along,
            x: Vec::new(),
            p: Covariance::independent(std::iter::empty()),
            scratch: Scratch::new(states + walks.len()),
        }
    }

    /// Samples on its way.
    pub(super) fn samples(&self) -> usize {
        self.observer.record.len()
    }

    /// Runs over the next samples.
    pub(super) fn over(&mut self, samples: Range<usize>, keep: &mut impl Keep) {
        let observer = self.observer;
        for k in samples {
            if observer.is_idle(k) {
                if self.linear.is_some() {
                    self.along.to_mut().skip(observer.layout.len());
                }
                keep.corrected(&self.x);
                continue;
            }
            if observer.record.starts.contains(&k) {
                self.x = observer.start(k, self.walks, |state| self.x.get(state).copied());
                self.p = observer.start_covariance(k, &self.scales, self.walks, &mut self.p);
                keep.began();
            }
            for channel in Channel::ALL {
                self.take(k, channel, keep);
            }
            keep.corrected(&self.x);
            if k + 1 < observer.record.len() {
                self.linearise(k);
                self.predict(k);
                let Scratch { transition, column: drive, kick, behind, reversing, .. } =
                    &self.scratch;
                let reversing = *reversing;
                let interval = observer.record.grid.interval(k);
                keep.passed(&Passed { transition, drive, kick, behind, reversing, interval });
            }
        }
    }

    /// Takes what a sensor has measured, if it has.
    fn take(&mut self, k: usize, channel: Channel, keep: &mut impl Keep) {
        let Self { observer, noise, walks, x, p, scratch, .. } = self;
        let c = channel as usize;
        let measured = observer.late.measured[k][c];
        if !measured.is_finite() {
            return;
        }
        let row = &mut scratch.row;
        observer.sensitivity(channel, walks, row);
        p.times(row, &mut scratch.column);
        let sensor = noise.sensors[c];
        let scatter = sensor * sensor + observer.record.jitter(k, channel);
        let variance = dot(row, &scratch.column) + scatter;
        let weight = 1.0 / variance.sqrt();
        let innovation = measured - observer.shown(channel, x, walks);
        let error = innovation * weight;
        let column = &scratch.column;
        keep.measured(&Measured { sample: k, channel, row, column, innovation, variance });
        let gains = scratch.gain.iter_mut().zip(x).zip(&scratch.column);
        for ((gain, x), column) in gains {
            *gain = column * weight;
            *x += *gain * error;
        }
        keep.taken(k, c, error, weight, &scratch.gain);
        p.add_square(-weight * weight, &scratch.column);
    }

    /// The state one interval forward, and its derivatives where they are not known.
    fn linearise(&mut self, k: usize) {
        let Self { observer, walks, x, scratch, .. } = self;
        let Some(linear) = self.linear.as_deref() else {
            return observer.advance(k, x, walks);
        };
        let n = observer.layout.len();
        // Away from the reversal: friction's derivative is taken on the side it moves to.
        let away = |step: &f64, x: &f64| if *x < 0.0 { -step } else { *step };
        let steps = &self.scales.steps;
        scratch.steps.clear();
        scratch.steps.extend(steps.iter().zip(&x[..n]).map(|(step, x)| away(step, x)));
        scratch.steps.extend(steps.last());
        let inputs = (observer.driven(k, x, walks), observer.record.load_nm[k]);
        observer.remember(x, walks);
        let Linearisation { transition, drive } = self.along.to_mut();
        let (made, driven) = (transition.len(), drive.len());
        scratch.before.clear();
        scratch.before.extend_from_slice(&x[..n]);
        linear.propagate(k, &mut x[..n], inputs, &scratch.steps, (transition, drive));
        let own = (&mut transition[made..], &mut drive[driven..]);
        believed(&observer.energy, scratch, own, |before, steps, derivatives| {
            linear.propagate(k, before, inputs, steps, derivatives);
        });
        observer.kick(k, x, walks);
    }

    /// The covariance one interval forward.
    fn predict(&mut self, k: usize) {
        let Self { observer, noise, walks, x, p, scratch, along, .. } = self;
        let n = observer.layout.len();
        let order = n + walks.len();
        let interval = observer.record.grid.interval(k);
        let by_drive = &along.drive[k * n..(k + 1) * n];
        let kick = &mut scratch.kick;
        kick.fill(0.0);
        observer.push(kick, 0, 1.0, interval);
        let own = &mut scratch.column;
        scratch.transition.set(|f| {
            f.fill(0.0);
            for i in 0..n {
                let row = &along.transition[(k * n + i) * n..(k * n + i + 1) * n];
                f[i * order..i * order + n].copy_from_slice(row);
            }
            for (j, walk) in walks.iter().enumerate() {
                match walk.equation {
                    Equation::Voltage => {
                        for i in 0..n {
                            f[i * order + n + j] = by_drive[i];
                        }
                    }
                    Equation::Torque(mass) => {
                        own.fill(0.0);
                        observer.push(own, mass, 1.0, interval);
                        for i in 0..n {
                            f[i * order + n + j] = own[i];
                        }
                    }
                    Equation::Sensor(_) => {}
                    Equation::CurrentBefore => {
                        let row = (n + j) * order;
                        observer.reported_by(&mut f[row..row + n]);
                        continue;
                    }
                }
                f[(n + j) * order + n + j] = walk.kept(interval);
            }
        });
        p.carry(&scratch.transition);
        scratch.column.fill(0.0);
        scratch.column[..n].copy_from_slice(by_drive);
        p.add_square(noise.drive * noise.drive, &scratch.column);
        scratch.reversing = observer.reversing(x);
        let [rotor, last] = scratch.reversing.map(|share| share * noise.reversal.powi(2));
        p.add_square(noise.torque.powi(2) + rotor, kick);
        let last = noise.output.powi(2) + last;
        if last > 0.0 {
            let behind = &mut scratch.behind;
            behind.fill(0.0);
            observer.push(behind, observer.layout.stages, 1.0, interval);
            p.add_square(last, behind);
        }
        for (j, walk) in walks.iter().enumerate() {
            p.add_variance(n + j, walk.gained(interval));
        }
    }
}

/// Takes derivatives that are not believed the other way, where that makes less of them: a jump is on one side.
fn believed(
    energy: &Energy,
    scratch: &mut Scratch,
    (by_state, by_drive): (&mut [f64], &mut [f64]),
    propagate: impl FnOnce(&mut [f64], &[f64], (&mut Vec<f64>, &mut Vec<f64>)),
) {
    let n = scratch.before.len();
    let doubted: Vec<usize> = energy.unbelieved(&scratch.before, (by_state, by_drive)).collect();
    if doubted.is_empty() {
        return;
    }
    doubted.iter().for_each(|number| scratch.steps[*number] *= -1.0);
    let (mut others, mut other) = (Vec::new(), Vec::new());
    propagate(&mut scratch.before, &scratch.steps, (&mut others, &mut other));
    for number in doubted {
        let own = energy.gained(number, (by_state, by_drive));
        if energy.gained(number, (&others, &other)) >= own {
            continue;
        }
        match number == n {
            true => by_drive.copy_from_slice(&other),
            false => (number..n * n).step_by(n).for_each(|k| by_state[k] = others[k]),
        }
    }
}

struct Scratch {
    /// A state before it is carried on.
    before: Vec<f64>,
    row: Vec<f64>,
    column: Vec<f64>,
    gain: Vec<f64>,
    steps: Vec<f64>,
    kick: Vec<f64>,
    behind: Vec<f64>,
    reversing: [f64; 2],
    transition: Transition,
}

impl Scratch {
    fn new(order: usize) -> Self {
        Self {
            before: Vec::with_capacity(order),
            row: vec![0.0; order],
            column: vec![0.0; order],
            gain: vec![0.0; order],
            steps: Vec::with_capacity(order + 1),
            kick: vec![0.0; order],
            behind: vec![0.0; order],
            reversing: [0.0; 2],
            transition: Transition::none(order),
        }
    }
}

/// Sum of the products of two vectors' numbers.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::expected;
    use crate::record::Record;
    use crate::replicate::replicate;
    use joint_simulation::log::Log;
    use joint_simulation::model::Model;
    use joint_simulation::plant::plant;
    use joint_simulation::scenario::paper;

    /// The paper's joint in a slow multisine, as it would have made it itself, at one micro-step per sample.
    fn reversing(model: &Model, volts: f64) -> Record {
        let time_s: Vec<f64> = (0..20_000).map(|k| f64::from(k) * 1e-4).collect();
        let sines = |t: f64| [31.0, 77.0, 143.0].map(|of| (of * t).sin()).iter().sum::<f64>();
        let log = Log {
            voltage_v: Some(time_s.iter().map(|t| volts * sines(*t)).collect()),
            current_a: Some(vec![0.0; time_s.len()]),
            motor_angle_rad: vec![0.0; time_s.len()],
            output_angle_rad: Some(vec![0.0; time_s.len()]),
            time_s,
            ..Log::default()
        };
        let blank = Record::new(&log, Some(1));
        replicate(model, &blank, &expected(model, &blank), 1).unwrap()
    }

    #[test]
    fn a_filter_does_not_take_a_jump_of_a_stepped_joint_for_a_derivative() {
        let mut model = paper();
        model.sensor.motor_encoder_counts_per_rev = 3000.0;
        model.sensor.output_encoder_counts_per_rev = 65536.0;
        model.sensor.current_noise_a = 1e-3;
        for volts in [0.1, 0.2, 0.332] {
            let record = reversing(&model, volts);
            let plant = plant(&model, &record.grid, record.drive).unwrap();
            let observer = Observer::new(&model, &*plant, &record);
            let mut along = Cow::Owned(Linearisation::default());
            let (_, run) = observer.design_along(&mut along, &expected(&model, &record), &[]);
            let n = observer.layout.len();
            let by_sample = along.transition.chunks_exact(n * n).zip(along.drive.chunks_exact(n));
            let believed = by_sample.zip(&run.states).all(|(derivatives, x)| {
                observer.energy.unbelieved(&x[..n], derivatives).next().is_none()
            });
            assert!(believed && run.states.iter().flatten().all(|x| x.is_finite()), "{volts}");
        }
    }
}
