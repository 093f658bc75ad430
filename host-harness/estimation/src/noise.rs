//! How much of a record's scatter is noise: what the sensors add, and what the joint really felt.
//!
//! Sensor noise comes from the model's `[sensor]` table where it says so, and from an encoder's readings where
//! they scatter by more. The rest is found by maximum likelihood, with an expectation: a supply that is quiet to
//! some 0.2 % of the largest voltage, a friction torque that scatters by some 2 % of its breakaway level (on the
//! rotor, and on the last mass where a record asks for it), and as much as its sensor's noise makes where a
//! current is the input. The expectation keeps a missing effect from being declared noise.

use std::borrow::Cow;

use joint_core::joint::Drive;
use joint_core::per_unit::Bases;
use nalgebra::{DMatrix, DVector};

use super::filter::{Linearisation, Noise};
use super::fit::Problem;
use super::record::{Channel, Record};
use super::scoring::Source;
use crate::interrupt;
use joint_simulation::model::Model;
use joint_simulation::plant::BuildError;

/// Largest step of the search, in the logarithm of a noise.
const LARGEST_STRIDE: f64 = 3.2;
/// Times what is expected that drive and rotor are taken to scatter at most: a filter that believes its
/// model any less learns nothing from it.
const MOST: f64 = 8000.0;
/// Most steps of it, and most attempts at one.
const MOST_ROUNDS: usize = 10;
const ATTEMPTS: usize = 4;
/// What a step must promise of minus twice the log-likelihood to be made, where a model is to be known
/// and where it is only to be compared.
const WORTH: f64 = 0.3;
const ROUGH: f64 = 1.5;

/// One sigma, in the logarithm, of a noise of which little is known beforehand.
const UNKNOWN: f64 = 3.0;

/// One noise that can be moved.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Knob {
    source: Source,
    /// Logarithm of what is expected.
    expected: f64,
    /// One sigma of the expectation, in the logarithm.
    spread: f64,
}

impl Knob {
    /// How far a noise is off what is expected, in sigmas.
    fn off(&self, noise: &Noise) -> f64 {
        (self.source.sigma(noise).ln() - self.expected) / self.spread
    }

    /// A noise moved by a step.
    fn moved(&self, noise: &Noise, step: f64) -> Noise {
        let most = match self.source {
            Source::Sensor(_) | Source::Coloured(_) | Source::Reversal => f64::INFINITY,
            Source::Drive | Source::Torque | Source::Output => self.expected + MOST.ln(),
        };
        let there = (self.source.sigma(noise).ln() + step).min(most);
        self.source.with_sigma(noise, there.exp())
    }
}

/// What noise a record's sensors and a joint's nature lead one to expect.
pub fn expected(model: &Model, record: &Record) -> Noise {
    let largest = record.drive_values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let bases = Bases::si(&model.motor, &model.stages);
    let breakaway = |mass: usize| {
        let friction = match mass.checked_sub(1) {
            None => &model.motor.friction,
            Some(k) => &model.stages[k].friction,
        };
        friction.breakaway_nm() * bases.shaft(mass).abs()
    };
    let stages = model.stages.len();
    let last = breakaway(stages);
    let breakaway: f64 = (0..=stages).map(breakaway).sum();
    let constant = model.motor.torque_constant_nm_per_a;
    let felt = |breakaway: f64| match breakaway > 0.0 {
        true => 0.02 * breakaway,
        false => 1e-3 * largest * constant,
    };
    // A measured current as the input brings its sensor's noise along.
    let brought = match record.drive {
        Drive::Voltage => 0.0,
        Drive::Current => model.sensor.current_noise_a * constant,
    };
    Noise {
        drive: (2e-3 * largest).max(record.drive_noise).max(1e-9),
        torque: felt(breakaway).hypot(brought),
        reversal: 0.0,
        output: if record.output_disturbed && stages > 0 { felt(last) } else { 0.0 },
        sensors: Channel::ALL.map(|channel| record.sensor_sigma(model, channel)),
        coloured: Default::default(),
    }
}

/// Moves the noise to where the record's likelihood is highest at this model.
///
/// # Errors
/// The model cannot be built.
pub fn refine(
    problem: &Problem<'_>,
    model: &Model,
    expected: &Noise,
    start: &Noise,
) -> Result<Noise, BuildError> {
    refine_along(problem, &mut Cow::Owned(Linearisation::default()), model, expected, start)
}

/// The same along a linearisation of this model, which is made if it is empty.
///
/// # Errors
/// The model cannot be built.
pub fn refine_along(
    problem: &Problem<'_>,
    along: &mut Cow<'_, Linearisation>,
    model: &Model,
    expected: &Noise,
    start: &Noise,
) -> Result<Noise, BuildError> {
    let mut knobs =
        vec![Knob { source: Source::Torque, expected: expected.torque.ln(), spread: 0.7 }];
    if problem.record.drive == Drive::Voltage {
        let expected = expected.drive.ln();
        knobs.push(Knob { source: Source::Drive, expected, spread: 0.7 });
    }
    if expected.output > 0.0 {
        knobs.push(Knob { source: Source::Output, expected: expected.output.ln(), spread: 0.7 });
    }
    if start.reversal > 0.0 {
        let expected = start.reversal.ln();
        knobs.push(Knob { source: Source::Reversal, expected, spread: UNKNOWN });
    }
    for (place, colour) in start.colours() {
        let source = Source::Coloured(place);
        knobs.push(Knob { source, expected: colour.deviation.ln(), spread: UNKNOWN });
    }
    for channel in Channel::ALL {
        if problem.record.has(channel) && !known(model, channel) {
            let expected = expected.sensors[channel as usize].ln();
            knobs.push(Knob { source: Source::Sensor(channel), expected, spread: UNKNOWN });
        }
    }
    let sources: Vec<Source> = knobs.iter().map(|knob| knob.source).collect();
    let mut scored = |noise: &Noise| -> Result<Scored, BuildError> {
        let (mut cost, mut gradient, mut curvature) =
            problem.scored_along(along, model, noise, &sources)?;
        for (k, knob) in knobs.iter().enumerate() {
            let off = knob.off(noise);
            cost += off * off;
            gradient[k] += 2.0 * off / knob.spread;
            curvature[(k, k)] += 2.0 / (knob.spread * knob.spread);
        }
        Ok(Scored { cost, gradient, curvature })
    };
    let worth = if problem.is_rough() { ROUGH } else { WORTH };
    let mut noise = *start;
    let mut here = scored(&noise)?;
    // A filter that trusts a wrong model too much may follow it to infinity.
    while !here.cost.is_finite() && noise.times(expected) < MOST {
        noise = noise.distrusted(10.0);
        here = scored(&noise)?;
    }
    let mut damping = 0.0;
    for _ in 0..MOST_ROUNDS {
        let mut better = None;
        for _ in 0..ATTEMPTS {
            if interrupt::asked() {
                break;
            }
            let Some((step, promised)) = here.step(damping) else { break };
            if promised < worth {
                break;
            }
            let moved = knobs.iter().zip(step.iter());
            let moved = moved.fold(noise, |noise, (knob, step)| knob.moved(&noise, *step));
            let there = scored(&moved)?;
            if there.cost < here.cost {
                better = Some((moved, there));
                break;
            }
            damping = 10.0 * f64::max(damping, 0.1);
        }
        let Some((moved, there)) = better else { break };
        (noise, here) = (moved, there);
        damping = if damping > 0.5 { 0.1 * damping } else { 0.0 };
    }
    Ok(noise)
}

/// What a noise costs, priors included, and how that changes with the logarithms.
struct Scored {
    cost: f64,
    gradient: DVector<f64>,
    curvature: DMatrix<f64>,
}

impl Scored {
    /// Where to go, and what that promises. A step of the logarithm is one of a variance first: a sensor
    /// that scatters r times what was taken, squared, asks for (r − 1)/2 there and for ln(r)/2.
    fn step(&self, damping: f64) -> Option<(DVector<f64>, f64)> {
        let mut damped = self.curvature.clone();
        for k in 0..damped.nrows() {
            damped[(k, k)] *= 1.0 + damping;
        }
        let step = -damped.cholesky()?.solve(&self.gradient);
        let promised = -step.dot(&(&self.gradient + 0.5 * &self.curvature * &step));
        let bent = step.map(|step| {
            let least = (-2.0 * LARGEST_STRIDE).exp();
            (0.5 * (1.0 + 2.0 * step).max(least).ln()).min(LARGEST_STRIDE)
        });
        (promised.is_finite() && bent.iter().all(|step| step.is_finite()))
            .then_some((bent, promised))
    }
}

/// Whether the model says what this sensor adds.
fn known(model: &Model, channel: Channel) -> bool {
    0.0 < match channel {
        Channel::Current => model.sensor.current_noise_a,
        Channel::Motor => model.sensor.motor_encoder_counts_per_rev,
        Channel::Output => model.sensor.output_encoder_counts_per_rev,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use joint_simulation::demo::actuator;
    use joint_simulation::log::Log;

    #[test]
    fn slope_and_curvature_of_the_likelihood_are_those_of_its_differences() {
        let model = actuator();
        let log = joint_simulation::synthetic::record(
            &model,
            &joint_simulation::synthetic::Experiment::clean(0.4),
            5,
        );
        let record = Record::join(&[log.unwrap()], None).unwrap();
        let mask: Vec<f64> =
            (0..record.len()).map(|k| f64::from(u8::from(k % 700 < 500))).collect();
        let problem = Problem::new(&record, &mask);
        let expected = expected(&model, &record);
        let start =
            Noise { torque: 3.0 * expected.torque, drive: 0.5 * expected.drive, ..expected };
        let sources = [
            Source::Torque,
            Source::Drive,
            Source::Sensor(Channel::Motor),
            Source::Sensor(Channel::Current),
        ];
        let along = &mut Cow::Owned(Linearisation::default());
        let (cost, gradient, curvature) =
            problem.scored_along(along, &model, &start, &sources).unwrap();
        let plain = |noise: &Noise| problem.deviance_along(along, &model, noise).unwrap();
        assert!((plain(&start) - cost).abs() < 1e-9 * cost.abs());
        let step = 1e-3;
        for (k, source) in sources.into_iter().enumerate() {
            let at =
                |step: f64| plain(&source.with_sigma(&start, source.sigma(&start) * step.exp()));
            let (up, down) = (at(step), at(-step));
            let slope = (up - down) / (2.0 * step);
            assert!(
                (gradient[k] - slope).abs() < 1e-3 * slope.abs() + 0.1,
                "{source:?}: {} {slope}",
                gradient[k]
            );
            assert!(curvature[(k, k)] > 0.0);
        }
    }

    #[test]
    fn the_noise_that_is_found_is_where_no_step_helps() {
        let model = actuator();
        let log = joint_simulation::synthetic::record(
            &model,
            &joint_simulation::synthetic::Experiment::clean(0.4),
            5,
        );
        let record = Record::join(&[log.unwrap()], None).unwrap();
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask);
        let expected = expected(&model, &record);
        let along = &mut Cow::Owned(Linearisation::default());
        let mut found = Vec::new();
        for times in [0.02, 1.0, 300.0] {
            let start = expected.distrusted(times);
            let noise = refine_along(&problem, along, &model, &expected, &start).unwrap();
            let prior = |noise: &Noise| {
                let off = [(noise.torque, expected.torque), (noise.drive, expected.drive)];
                off.map(|(own, expected)| ((own / expected).ln() / 0.7).powi(2)).iter().sum::<f64>()
            };
            let cost = |noise: &Noise| {
                problem.deviance_along(along, &model, noise).unwrap() + prior(noise)
            };
            let here = cost(&noise);
            for shift in [-0.3_f64, 0.3] {
                let torque = Noise { torque: noise.torque * shift.exp(), ..noise };
                let drive = Noise { drive: noise.drive * shift.exp(), ..noise };
                assert!(cost(&torque).min(cost(&drive)) > here - WORTH, "{times} {shift}");
            }
            found.push(here);
        }
        let spread = found.iter().fold(f64::MIN, |a, b| a.max(*b))
            - found.iter().fold(f64::MAX, |a, b| a.min(*b));
        assert!(spread < 2.0 * WORTH, "{found:?}");
    }

    #[test]
    fn a_measured_current_as_the_input_brings_its_sensors_noise() {
        let mut model = actuator();
        let felt = |model: &Model, voltage: bool| {
            let values = Some(vec![1.0; 300]);
            let log = Log {
                time_s: (0..300).map(|k| f64::from(k) * 1e-3).collect(),
                voltage_v: voltage.then(|| vec![1.0; 300]),
                current_a: values,
                motor_angle_rad: vec![0.0; 300],
                ..Log::default()
            };
            expected(model, &Record::new(&log, None)).torque
        };
        let own = felt(&model, true);
        model.sensor.current_noise_a = 3.0 * own / model.motor.torque_constant_nm_per_a;
        assert!((felt(&model, false) / own - 10.0_f64.sqrt()).abs() < 1e-9);
        assert_eq!(felt(&model, true), own);
    }
}
