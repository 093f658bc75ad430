//! Whether a log and its model speak of the same machine in the same units.
//!
//! An encoder that counts backwards, degrees, electrical angles or an angle behind the gear are the first
//! things that go wrong at a bench, and no effect explains them. The winding's own equation shows them
//! before any fit: averaged over a few samples, u = 2 R i + 2 k_e ω + 2 L di/dt in the log's own numbers.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};

use crate::log::Log;
use crate::model::Model;

/// Samples that are averaged.
const AVERAGED: usize = 20;
/// How well the back-EMF constant has to be known, as a share of itself.
const KNOWN: f64 = 0.05;
/// How far off a constant is before it is told.
const FAR: f64 = 3.0;
/// How near a known factor is, as a share of it.
const NEAR: f64 = 0.15;
/// Correlation of an input with the speed below which it works against the motion: an input that moves a
/// joint gives it work.
const TOGETHER: f64 = -0.05;

/// What a log and a model cannot both mean, a sentence each; nothing where they agree or the log does
/// not tell.
pub fn doubts(nominal: &Model, log: &Log) -> Vec<String> {
    if !moves(&log.motor_angle_rad) {
        return vec!["motor_angle_rad never changes: a joint at rest shows next to nothing".into()];
    }
    match (&log.voltage_v, &log.current_a) {
        (Some(voltage), Some(current)) => winding(nominal, log, voltage, current),
        (Some(input), None) => against("u_v", input, log),
        (None, Some(input)) => against("i_a", input, log),
        (None, None) => Vec::new(),
    }
}

/// Whether an angle changes at all.
fn moves(angle: &[f64]) -> bool {
    let mut there = angle.iter().filter(|angle| !angle.is_nan());
    let first = there.next();
    there.any(|angle| Some(angle) != first)
}

/// Whether an input works against the motion all the time.
fn against(name: &str, input: &[f64], log: &Log) -> Vec<String> {
    let pairs = stretches(log).map(|s| (s.mean(input), s.speed(log)));
    let sums = pairs
        .filter(|(u, w)| (u * w).is_finite())
        .fold([0.0; 3], |sums, (u, w)| [sums[0] + u * w, sums[1] + u * u, sums[2] + w * w]);
    let together = sums[0] / (sums[1] * sums[2]).sqrt();
    if together < TOGETHER {
        return vec![format!(
            "{name} and the speed have opposite signs most of the time: does motor_angle_rad count against \
             {name}?"
        )];
    }
    Vec::new()
}

/// What the winding's equation says in the log's own numbers.
fn winding(nominal: &Model, log: &Log, voltage: &[f64], current: &[f64]) -> Vec<String> {
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    let (mut squares, mut count) = (0.0, 0.0);
    for stretch in stretches(log) {
        let row = Vector3::new(
            stretch.mean(current),
            stretch.speed(log),
            stretch.change(current) / stretch.duration(log),
        );
        let u = stretch.mean(voltage);
        if (u + row.sum()).is_finite() {
            normal += row * row.transpose();
            right += row * u;
            squares += u * u;
            count += 1.0;
        }
    }
    let Some(inverse) = normal.try_inverse().filter(|_| count > 10.0) else { return Vec::new() };
    let fit = inverse * right;
    let noise = (squares - fit.dot(&right)).max(0.0) / (count - 3.0);
    let known = |k: usize| (noise * inverse[(k, k)]).sqrt() < KNOWN * fit[k].abs();
    if !known(0) || !known(1) {
        return Vec::new();
    }
    let [resistance, back_emf] = [fit[0], fit[1]];
    match (resistance < 0.0, back_emf < 0.0) {
        (true, true) => {
            return vec!["u_v has the wrong sign: it works against i_a and motor_angle_rad".into()];
        }
        (true, false) => return vec!["i_a has the wrong sign: it flows against u_v".into()],
        (false, true) => {
            return vec!["motor_angle_rad counts against u_v and i_a: reverse its sign".into()];
        }
        (false, false) => {}
    }
    let reduction: f64 = nominal.stages.iter().map(|stage| stage.reduction).product();
    let pairs = f64::from(nominal.motor.pole_pairs);
    let emf = back_emf / (2.0 * nominal.motor.back_emf_constant());
    let ohm = resistance / (2.0 * nominal.motor.phase_resistance_ohm);
    let slips = [
        ("the angle is in degrees, not in radians", TAU / 360.0),
        ("the angle is in turns, not in radians", TAU),
        ("the angle is electrical, not mechanical", 1.0 / pairs),
        ("the angle is that behind the gear, not the rotor's", reduction.abs()),
    ];
    let mut all = Vec::new();
    if !(1.0 / FAR..FAR).contains(&emf) {
        let slip = slips.iter().find(|(_, factor)| (emf / factor - 1.0).abs() < NEAR);
        let why = slip.map_or("is it that motor, and are these its units?".into(), |(what, _)| {
            format!("it looks as if {what}")
        });
        all.push(format!(
            "u_v and motor_angle_rad make a back-EMF constant of {emf:.3} times the nominal's: {why}"
        ));
    }
    if (ohm * 1e3 - 1.0).abs() < 3.0 * NEAR {
        all.push("u_v and i_a make a thousandth of the nominal's resistance: is i_a in mA?".into());
    }
    all
}

/// Samples that are averaged, from the first to the one behind the last.
struct Stretch(usize, usize);

impl Stretch {
    fn mean(&self, values: &[f64]) -> f64 {
        values[self.0..self.1].iter().sum::<f64>() / (self.1 - self.0) as f64
    }

    fn change(&self, values: &[f64]) -> f64 {
        values[self.1] - values[self.0]
    }

    fn duration(&self, log: &Log) -> f64 {
        self.change(&log.time_s)
    }

    fn speed(&self, log: &Log) -> f64 {
        self.change(&log.motor_angle_rad) / self.duration(log)
    }
}

fn stretches(log: &Log) -> impl Iterator<Item = Stretch> {
    let starts = (0..log.len().saturating_sub(AVERAGED)).step_by(AVERAGED);
    starts.map(|start| Stretch(start, start + AVERAGED))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::actuator;
    use crate::synthetic::{Experiment, record};

    /// What is doubted in a good log once its angle, current and voltage are multiplied by this.
    fn doubted(angle: f64, current: f64, voltage: f64) -> Vec<String> {
        let model = actuator();
        let mut log = record(&model, &Experiment::default(), 3).unwrap();
        log.motor_angle_rad.iter_mut().for_each(|value| *value *= angle);
        log.current_a.iter_mut().flatten().for_each(|value| *value *= current);
        log.voltage_v.iter_mut().flatten().for_each(|value| *value *= voltage);
        doubts(&model, &log)
    }

    #[test]
    fn what_is_right_is_not_doubted() {
        assert_eq!(doubted(1.0, 1.0, 1.0), Vec::<String>::new());
    }

    #[test]
    fn each_wrong_sign_is_told_by_its_column() {
        for (column, scales) in [
            ("motor_angle_rad counts", [-1.0, 1.0, 1.0]),
            ("i_a has", [1.0, -1.0, 1.0]),
            ("u_v has", [1.0, 1.0, -1.0]),
        ] {
            let [angle, current, voltage] = scales;
            let told = doubted(angle, current, voltage);
            assert!(told.len() == 1 && told[0].starts_with(column), "{column}: {told:?}");
        }
    }

    #[test]
    fn each_wrong_unit_is_told_by_its_name() {
        let reduction = actuator().stages[0].reduction;
        let pairs = f64::from(actuator().motor.pole_pairs);
        for (name, angle) in [
            ("degrees", 360.0 / TAU),
            ("turns", 1.0 / TAU),
            ("electrical", pairs),
            ("behind the gear", 1.0 / reduction),
        ] {
            let told = doubted(angle, 1.0, 1.0);
            assert!(told.len() == 1 && told[0].contains(name), "{name}: {told:?}");
        }
        assert!(doubted(1.0, 1e3, 1.0)[0].ends_with("mA?"));
    }

    #[test]
    fn a_joint_that_never_moves_is_told() {
        let told = doubted(0.0, 1.0, 1.0);
        assert!(told.len() == 1 && told[0].contains("never changes"), "{told:?}");
    }

    #[test]
    fn an_input_alone_tells_a_reversed_angle() {
        let model = actuator();
        let mut log = record(&model, &Experiment::default(), 3).unwrap();
        log.voltage_v = None;
        assert_eq!(doubts(&model, &log), Vec::<String>::new());
        log.motor_angle_rad.iter_mut().for_each(|value| *value = -*value);
        assert!(doubts(&model, &log)[0].contains("opposite signs"));
    }
}
