//! The gear ratio, measured from both encoders.
//!
//! With both angles in the log nobody has to believe a reduction: it is the slope of one over the other.
//! A ratio that is off biases every fit and is named as an encoder's error. Wind-up, a late encoder and
//! backlash follow torque, acceleration, speed and its sign; the slope is fitted with and without these
//! beside it, and what both fits agree on is the ratio. A load that itself follows the angle, as that of a coating or of
//! gravity, winds the gear in proportion to its travel, which looks the same: where the drive's torque has such a part, and
//! the gear's springs under it make as much as what is off, it is a warning.

use super::regression::Rows;
use super::torque_balance::{as_one_s, drive_torque};
use super::unit::figure;
use super::windows::{Windows, scatter};
use super::{Case, Check, Finding, Severity};
use crate::model::Model;
use joint_core::params::Stage;

/// How far off a ratio may be, as a share of it: half a per cent.
const ALLOWED: f64 = 0.005;
/// Standard errors beyond which a ratio is off.
const CERTAIN: f64 = 4.0;
/// Standard errors by which the torque that follows the angle may be larger than it is found.
const POSSIBLE: f64 = 2.0;
/// How near a factor of a mistake is, as a share of it.
const NEAR: f64 = 0.02;

pub(super) const CHECK: Check =
    Check { name: "gear-ratio", compares: "the output's angle against the motor's", run };

/// What both encoders tell.
struct Measured {
    /// Output angle over motor angle with its standard error, without and with what winds the gear beside it.
    slopes: [(f64, f64); 2],
    /// By how much the part of the drive's torque that follows the angle winds the gear at most, as a slope.
    windup: f64,
}

fn measured(case: &Case<'_>) -> Option<Measured> {
    let (model, log) = (case.model, case.log);
    let output = log.output_angle_rad.as_ref()?;
    let windows = Windows::clear(log, &log.motor_angle_rad, as_one_s(model));
    let (speeds, accelerations) = windows.derivatives(&log.time_s, &log.motor_angle_rad);
    let motor = windows.means(&log.time_s, &log.motor_angle_rad);
    let output = windows.means(&log.time_s, output);
    let torque = drive_torque(model, log, &windows, &speeds);
    let slowest = windows.noise().0 * scatter(&log.motor_angle_rad);
    let (mut plain, mut wound, mut driven) = (Rows::new(2), Rows::new(6), Rows::new(5));
    for k in 0..windows.len() {
        plain.push(output[k], &[motor[k], 1.0]);
        let torque = torque.as_ref().map_or(0.0, |torque| torque[k]);
        let sign = (speeds[k] / slowest).clamp(-1.0, 1.0);
        wound.push(output[k], &[motor[k], 1.0, torque, accelerations[k], speeds[k], sign]);
        driven.push(torque, &[motor[k], 1.0, accelerations[k], speeds[k], sign]);
    }
    let (follows, error) = driven.fit()?.coefficient(0);
    Some(Measured {
        slopes: [plain.fit()?.coefficient(0), wound.fit()?.coefficient(0)],
        windup: windup_rad(model, follows.abs() + POSSIBLE * error),
    })
}

/// By how much a torque at the motor winds the gear, rad at the output, by its linear stiffness.
fn windup_rad(model: &Model, torque_nm: f64) -> f64 {
    let wind = |(torque, wound): (f64, f64), stage: &Stage| {
        let torque = torque * stage.reduction.abs();
        (torque, wound / stage.reduction.abs() + torque / stage.stiffness_nm_per_rad)
    };
    model.stages.iter().fold((torque_nm, 0.0), wind).1
}

fn run(case: &Case<'_>) -> Vec<Finding> {
    let model = case.model;
    if model.stages.is_empty() {
        return Vec::new();
    }
    let Some(Measured { slopes, windup }) = measured(case) else { return Vec::new() };
    let nominal: f64 = model.stages.iter().map(|stage| stage.reduction).product();
    // Off the nominal as a share, for certain: at least this much, and to this side.
    let beyond = slopes.map(|(slope, error)| {
        let off = slope * nominal - 1.0;
        let sure = off.abs() - CERTAIN * error * nominal.abs();
        if sure > ALLOWED { off.signum() } else { 0.0 }
    });
    let (slope, error) = match slopes[0].1 < slopes[1].1 {
        true => slopes[0],
        false => slopes[1],
    };
    let apart = (slopes[0].0 - slopes[1].0).abs();
    let error = error.hypot(apart);
    let known = CERTAIN * error < slope.abs();
    let measured = figure(1.0 / slope, error / (slope * slope));
    let share = 100.0 * (nominal * slope - 1.0);
    if beyond[0] * beyond[1] > 0.0 && known && apart < 0.5 * (slope - 1.0 / nominal).abs() {
        let (what, help) = mistake(model, slope * nominal, &measured);
        let message = format!(
            "output_angle_rad and motor_angle_rad make a gear ratio of {measured}, the model's is {}{what}",
            figure(nominal, 0.0)
        );
        let winds = (slope - 1.0 / nominal).abs() < windup;
        return vec![match winds {
            true => {
                Finding::warning(format!("{message}; a load that follows the angle may do that"))
                    .help(format!("if nothing holds the output, {help}"))
            }
            false => Finding::error(message).help(help),
        }];
    }
    let severity = Severity::Note;
    if !known {
        return vec![Finding::new(
            severity,
            "the gear ratio cannot be measured: the output hardly moves",
        )];
    }
    vec![Finding::new(
        severity,
        format!(
            "gear ratio {measured} by both encoders, {share:.2} ± {:.2} % off the model's",
            100.0 * error * nominal.abs()
        ),
    )]
}

/// What a ratio of slopes looks like, and what to do.
fn mistake(model: &Model, ratio: f64, measured: &str) -> (String, String) {
    let nominal: f64 = model.stages.iter().map(|stage| stage.reduction).product();
    let near = |factor: f64| (ratio / factor - 1.0).abs() < NEAR;
    let told = |what: &str| format!(": it looks as if {what}");
    let tau = std::f64::consts::TAU;
    let columns = [
        (360.0 / tau, "output_angle_rad is in degrees"),
        (1.0 / tau, "output_angle_rad is in turns"),
        (tau / 360.0, "motor_angle_rad is in degrees"),
        (tau, "motor_angle_rad is in turns"),
        (nominal, "both angles are counted on one side of the gear"),
    ];
    if let Some((_, what)) = columns.iter().find(|(factor, _)| near(*factor)) {
        return (told(what), "convert the column".into());
    }
    if near(-1.0) {
        let what = told("one encoder counts against the other");
        return (what, "reverse a column's sign, or make the reduction negative".into());
    }
    if near(nominal * nominal) {
        let help = format!("a reduction is input over output turns: {measured}");
        return (told("the reduction is inverted"), help);
    }
    for (k, stage) in model.stages.iter().enumerate() {
        if model.stages.len() > 1 && near(stage.reduction) {
            let what = format!("stage {} is missing between the encoders", k + 1);
            return (told(&what), "correct the model's stages, or the column".into());
        }
    }
    let share = 100.0 * (1.0 / ratio - 1.0);
    let help = match model.stages.len() {
        1 => format!("set reduction = {measured}"),
        _ => format!("make the stages' reductions multiply to {measured}"),
    };
    (format!(" ({share:+.2} %)"), help)
}

#[cfg(test)]
mod tests {
    use super::super::made::{actuator_and_log, of};
    use super::*;

    /// What is found where the model's reduction and the log's output angle are multiplied.
    fn found(reduction: f64, output: f64) -> Finding {
        let (mut model, mut log) = actuator_and_log();
        model.stages[0].reduction *= reduction;
        log.output_angle_rad.iter_mut().flatten().for_each(|value| *value *= output);
        let mut told = of(&CHECK, &model, &log);
        assert_eq!(told.len(), 1, "{told:?}");
        told.remove(0)
    }

    #[test]
    fn the_right_ratio_is_a_note_with_its_measure() {
        let told = found(1.0, 1.0);
        assert_eq!(told.severity, Severity::Note);
        assert!(told.message.contains("gear ratio 9.0"), "{told:?}");
    }

    #[test]
    fn a_ratio_more_than_half_a_per_cent_off_is_an_error_that_names_the_measured_one() {
        // This log of 1.5 s tells the ratio to 0.4 %: what is less than four such errors beyond half a per cent
        // stays a note.
        for off in [0.95, 0.98, 1.02, 1.05] {
            let told = found(off, 1.0);
            assert_eq!(told.severity, Severity::Error, "{off} {told:?}");
            let named = told.help.strip_prefix("set reduction = ").unwrap();
            let named: f64 = named.parse().unwrap();
            // A fifth of what is allowed: the gear's wind-up follows the travel a little.
            assert!((named / 9.0 - 1.0).abs() < 0.2 * ALLOWED, "{named}");
        }
        assert_eq!(found(1.002, 1.0).severity, Severity::Note);
    }

    #[test]
    fn a_load_that_follows_the_angle_winds_the_gear_in_proportion_to_its_travel() {
        let windup = |skin: f64| {
            let (model, mut log) = actuator_and_log();
            let stiffness = model.stages[0].stiffness_nm_per_rad;
            let constant = model.motor.torque_constant_nm_per_a;
            let output = log.output_angle_rad.clone().unwrap();
            for (value, current) in output.iter().zip(log.current_a.as_mut().unwrap()) {
                *current += skin * stiffness * value / (9.0 * constant);
            }
            measured(&Case::new(&model, &log)).unwrap().windup
        };
        // A skin that pushes back by a fifth of the gear's stiffness winds it by a fifth of its travel, a ninth of the motor's.
        let [none, skin] = [0.0, 0.2].map(windup);
        assert!((skin * 9.0 / 0.2 - 1.0).abs() < 0.3 && none < 0.1 * skin, "{none} {skin}");
        let (model, _) = actuator_and_log();
        let wound = windup_rad(&model, 2.0) * model.stages[0].stiffness_nm_per_rad;
        assert!((wound - 18.0).abs() < 1e-9, "{wound}");
    }

    #[test]
    fn mistakes_of_sign_unit_and_sense_are_told_by_name() {
        assert!(found(1.0, -1.0).message.contains("counts against"));
        assert!(found(1.0, 57.29578).message.contains("output_angle_rad is in degrees"));
        assert!(found(1.0 / 81.0, 1.0).message.contains("inverted"));
        assert!(found(1.0, 9.0).message.contains("one side of the gear"));
    }
}
