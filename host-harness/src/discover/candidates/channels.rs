//! What the channels of a record show beside what is fitted to: how far they move, and what they follow.

use joint_core::joint::Drive;

use crate::estimate::record::{Channel, Record};
use crate::model::Model;

/// Samples over which a speed is taken.
const SPAN: usize = 5;
/// Share of the samples on either side that a channel's span leaves out.
const TAIL: f64 = 0.02;

/// The largest current that a record shows, A; zero where it shows none.
pub(crate) fn largest_current(record: &Record) -> f64 {
    let finite =
        |most: f64, value: f64| if value.is_finite() { most.max(value.abs()) } else { most };
    match record.drive {
        Drive::Current => record.drive_values.iter().copied().fold(0.0, finite),
        Drive::Voltage => {
            record.measured.iter().map(|row| row[Channel::Current as usize]).fold(0.0, finite)
        }
    }
}

/// Current by sample, A: measured, imposed, or what voltage and speed leave for the resistance.
pub(super) fn currents<'a>(model: &'a Model, record: &'a Record) -> impl Iterator<Item = f64> + 'a {
    let motor = &model.motor;
    let resistance = 2.0 * motor.phase_resistance_ohm;
    let samples = record.len();
    (0..samples).map(move |k| {
        let measured = record.measured[k][Channel::Current as usize];
        if record.drive == Drive::Current {
            return record.drive_values[k];
        }
        if measured.is_finite() {
            return measured;
        }
        let (from, to) = (k.saturating_sub(SPAN), (k + SPAN).min(samples - 1));
        let [a, b] = [from, to].map(|at| record.measured[at][Channel::Motor as usize]);
        let speed = (b - a) / (record.time_s[to] - record.time_s[from]);
        let emf = motor.torque_constant_nm_per_a * speed;
        (record.drive_values[k] - if emf.is_finite() { emf } else { 0.0 }) / resistance
    })
}

/// How much a bus falls for every volt that it is to drop, by least squares: what moves it for other
/// reasons does not count.
pub(super) fn followed(drops: &[f64], bus: &[f64]) -> f64 {
    let pairs = || drops.iter().zip(bus).filter(|(drop, bus)| drop.is_finite() && bus.is_finite());
    let count = pairs().count().max(1) as f64;
    let (drops, levels) = pairs().fold((0.0, 0.0), |(d, b), (drop, bus)| (d + drop, b + bus));
    let (drops, levels) = (drops / count, levels / count);
    let (mut along, mut square) = (0.0, 0.0);
    for (drop, bus) in pairs() {
        along -= (drop - drops) * (bus - levels);
        square += (drop - drops).powi(2);
    }
    if square > 0.0 { along / square } else { 0.0 }
}

/// How far most of the values lie apart.
pub(super) fn span(values: &[f64]) -> Option<f64> {
    Some(quantile(values, 1.0 - TAIL)? - quantile(values, TAIL)?)
}

/// Smallest change that a channel shows; zero where it never moves.
pub(super) fn digit(values: &[f64]) -> f64 {
    let steps = values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let smallest = steps.filter(|step| *step > 1e-12).fold(f64::INFINITY, f64::min);
    if smallest.is_finite() { smallest } else { 0.0 }
}

/// The value below which this share of the finite ones lies.
pub(super) fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let place = (share * sorted.len().saturating_sub(1) as f64).round() as usize;
    sorted.get(place).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bus_that_moves_for_another_reason_follows_nothing() {
        let drops: Vec<f64> = (0..1000).map(|k| f64::from(k / 50 % 2) * 2.0).collect();
        let battery: Vec<f64> = (0..1000).map(|k| 12.0 - 2e-3 * f64::from(k)).collect();
        assert!(followed(&drops, &battery).abs() < 0.1);
        let sagging: Vec<f64> = drops.iter().map(|drop| 12.0 - 0.8 * drop).collect();
        assert!((followed(&drops, &sagging) - 0.8).abs() < 1e-9);
    }
}
