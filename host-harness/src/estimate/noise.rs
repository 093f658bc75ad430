//! How much of a record's scatter is noise: what the sensors add, and what the joint really felt.
//!
//! Sensor noise comes from the model's `[sensor]` table where it says so. The rest is found by
//! maximum likelihood, with an expectation: a supply that is quiet to some 0.2 % of the largest
//! voltage, a friction torque that scatters by some 2 % of its breakaway level, and as much as its
//! sensor's noise makes where a current is the input. The expectation keeps a missing effect from being
//! declared noise.

use std::borrow::Cow;

use super::filter::{Linearisation, Noise};
use super::fit::Problem;
use super::record::{CHANNELS, Channel, Record};
use crate::interrupt;
use crate::model::Model;
use crate::plant::BuildError;
use joint_core::joint::Drive;
use joint_core::per_unit::Bases;

/// Steps of the search, in the logarithm of a noise: the first, and the largest where it goes far.
const FIRST_STRIDE: f64 = 0.8;
const LARGEST_STRIDE: f64 = 3.2;
/// Times what is expected that drive and rotor are taken to scatter at most: a filter that believes its
/// model any less learns nothing from it.
const MOST: f64 = 8000.0;
/// Most rounds of it.
const MOST_ROUNDS: usize = 8;
/// What a parabola must promise of minus twice the log-likelihood for its lowest point to be tried.
const WORTH: f64 = 0.5;

/// One noise that can be moved.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Knob {
    which: usize,
    /// Logarithm of what is expected.
    expected: f64,
    /// One sigma of the expectation, in the logarithm.
    spread: f64,
}

/// What noise a record's sensors and a joint's nature lead one to expect.
pub fn expected(model: &Model, record: &Record) -> Noise {
    let largest = record.drive_values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let bases = Bases::si(&model.motor, &model.stages);
    let breakaway: f64 = (0..=model.stages.len())
        .map(|mass| {
            let friction = match mass.checked_sub(1) {
                None => &model.motor.friction,
                Some(k) => &model.stages[k].friction,
            };
            friction.breakaway_nm() * bases.shaft(mass).abs()
        })
        .sum();
    let constant = model.motor.torque_constant_nm_per_a;
    let felt = if breakaway > 0.0 { 0.02 * breakaway } else { 1e-3 * largest * constant };
    // A measured current as the input brings its sensor's noise along.
    let brought = match record.drive {
        Drive::Voltage => 0.0,
        Drive::Current => model.sensor.current_noise_a * constant,
    };
    Noise {
        drive: (2e-3 * largest).max(1e-9),
        torque: felt.hypot(brought),
        sensors: Channel::ALL.map(|channel| record.sensor_sigma(model, channel)),
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
    let mut knobs = vec![Knob { which: 1, expected: expected.torque.ln(), spread: 0.7 }];
    if problem.record.drive == Drive::Voltage {
        knobs.push(Knob { which: 0, expected: expected.drive.ln(), spread: 0.7 });
    }
    for channel in Channel::ALL {
        if problem.record.has(channel) && !known(model, channel) {
            let expected = expected.sensors[channel as usize].ln();
            knobs.push(Knob { which: 2 + channel as usize, expected, spread: 3.0 });
        }
    }
    let prior = |noise: &Noise| -> f64 {
        let off = |knob: &Knob| (get(noise, knob.which).ln() - knob.expected) / knob.spread;
        knobs.iter().map(|knob| off(knob).powi(2)).sum()
    };
    let mut best = problem.design_along(along, model, start)?.deviance + prior(start);
    let cost = |noise: &Noise| -> Result<f64, BuildError> {
        Ok(problem.deviance_along(along, model, noise)? + prior(noise))
    };
    let mut noise = *start;
    let mut stride = FIRST_STRIDE;
    for _ in 0..MOST_ROUNDS {
        if interrupt::asked() {
            break;
        }
        let mut farthest = 0.0_f64;
        for knob in &knobs {
            let here = get(&noise, knob.which).ln();
            let moved = |shift: f64| {
                let mut moved = noise;
                let most = if knob.which < 2 { knob.expected + MOST.ln() } else { f64::INFINITY };
                set(&mut moved, knob.which, (here + shift).min(most).exp());
                moved
            };
            let (high, low) = rayon::join(|| cost(&moved(stride)), || cost(&moved(-stride)));
            let mut trials = vec![(high?, stride), (low?, -stride)];
            let [(high, _), (low, _)] = trials[..] else { continue };
            // The parabola through three points, kept within twice the stride.
            let bend = high + low - 2.0 * best;
            let slope = low - high;
            let mut shift = if slope > 0.0 { 2.0 * stride } else { -2.0 * stride };
            let mut promised = f64::INFINITY;
            if bend > 0.0 {
                shift = (0.5 * stride * slope / bend).clamp(-2.0 * stride, 2.0 * stride);
                promised = slope * slope / (8.0 * bend) - (best - high.min(low)).max(0.0);
            }
            if promised > WORTH {
                trials.push((cost(&moved(shift))?, shift));
            }
            let chosen = trials.iter().min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((lower, shift)) = chosen.filter(|(trial, _)| *trial < best) {
                noise = moved(*shift);
                farthest = farthest.max(shift.abs());
                best = *lower;
            }
        }
        if farthest < 0.1 {
            break;
        }
        if farthest < stride {
            stride *= 0.5;
        } else if farthest > 1.5 * stride {
            stride = (2.0 * stride).min(LARGEST_STRIDE);
        }
    }
    Ok(noise)
}

/// Whether the model says what this sensor adds.
fn known(model: &Model, channel: Channel) -> bool {
    0.0 < match channel {
        Channel::Current => model.sensor.current_noise_a,
        Channel::Motor => model.sensor.motor_encoder_counts_per_rev,
        Channel::Output => model.sensor.output_encoder_counts_per_rev,
    }
}

fn get(noise: &Noise, which: usize) -> f64 {
    match which {
        0 => noise.drive,
        1 => noise.torque,
        k => noise.sensors[(k - 2).min(CHANNELS - 1)],
    }
}

fn set(noise: &mut Noise, which: usize, value: f64) {
    match which {
        0 => noise.drive = value,
        1 => noise.torque = value,
        k => noise.sensors[(k - 2).min(CHANNELS - 1)] = value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::actuator;
    use crate::log::Log;

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
