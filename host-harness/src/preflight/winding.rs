//! Voltage against current and speed: units and signs by the winding's own equation.
//!
//! In windows u = 2R i + 2k_e ω + 2L di/dt, in the log's own numbers. It needs no inertia and no friction,
//! so that it tells a wrong sign and a wrong unit from the log alone, and of which column.

use super::regression::Rows;
use super::unit::{angle_mistakes, nearest};
use super::windows::Windows;
use super::{Case, Check, Finding};

/// How well both constants have to be known, as a share of themselves.
const KNOWN: f64 = 0.05;
/// How far off a constant is before it is told: nominals are off by tens of per cent.
const FAR: f64 = 3.0;
/// How near a factor of a unit is, as a share of it.
const NEAR: f64 = 0.15;
/// Samples of a window: the voltage acts over a sample and the current is read at its start.
const WIDTH: usize = 20;

pub(super) const CHECK: Check =
    Check { name: "winding", compares: "voltage against current and speed", run };

fn run(case: &Case<'_>) -> Vec<Finding> {
    constants(case).map_or_else(Vec::new, |constants| judged(case, constants))
}

/// The winding's two constants by the log: 2R and 2k_e, where it tells both.
pub(super) fn constants(case: &Case<'_>) -> Option<[f64; 2]> {
    let log = case.log;
    let (voltage, current) = (log.voltage_v.as_ref()?, log.current_a.as_ref()?);
    let windows = Windows::of(&log.time_s, WIDTH);
    let (speeds, _) = windows.derivatives(&log.time_s, &log.motor_angle_rad);
    let voltages = windows.held_means(&log.time_s, voltage);
    let currents = windows.means(&log.time_s, current);
    let (slopes, _) = windows.derivatives(&log.time_s, current);
    let mut rows = Rows::new(3);
    for k in 0..windows.len() {
        rows.push(voltages[k], &[currents[k], speeds[k], slopes[k]]);
    }
    let fit = rows.fit()?;
    let known = |column: usize| {
        let (value, error) = fit.coefficient(column);
        (error < KNOWN * value.abs()).then_some(value)
    };
    Some([known(0)?, known(1)?])
}

fn judged(case: &Case<'_>, [resistance, back_emf]: [f64; 2]) -> Vec<Finding> {
    let motor = &case.model.motor;
    let sign = match (resistance < 0.0, back_emf < 0.0) {
        (true, true) => Some("u_v has the wrong sign: it works against i_a and motor_angle_rad"),
        (true, false) => Some("i_a has the wrong sign: it flows against u_v"),
        (false, true) => Some("motor_angle_rad has the wrong sign: it counts against u_v and i_a"),
        (false, false) => None,
    };
    if let Some(sign) = sign {
        return vec![Finding::error(sign).help("reverse that column's sign")];
    }
    let emf = back_emf / (2.0 * motor.back_emf_constant());
    let mut all = Vec::new();
    if !(1.0 / FAR..FAR).contains(&emf) {
        let mistakes = angle_mistakes(case.model);
        let told = format!(
            "u_v and motor_angle_rad make a back-EMF constant of {emf:.3} times the model's"
        );
        all.push(match nearest(&mistakes, 1.0 / emf, NEAR) {
            Some(mistake) => Finding::error(format!("{told}: it looks as if {}", mistake.what))
                .help("convert the column, or correct the model"),
            None => Finding::warning(told).help("is it that motor, and are these its units?"),
        });
    }
    let nominal = 2.0 * motor.phase_resistance_ohm;
    if nominal > 0.0 {
        let ohm = resistance / nominal;
        let told = format!("u_v and i_a make a resistance of {ohm:.3e} times the model's");
        if nearest(&[super::unit::Mistake { factor: 1e-3, what: String::new() }], ohm, FAR - 1.0)
            .is_some()
        {
            all.push(
                Finding::error(format!("{told}: it looks as if i_a is in mA"))
                    .help("divide i_a by 1000"),
            );
        } else if !(1.0 / FAR..FAR).contains(&ohm) {
            all.push(Finding::warning(told).help("is the resistance per phase, and is i_a in A?"));
        }
    }
    if all.is_empty() {
        all.push(Finding::note(format!(
            "resistance {:.3} and back-EMF constant {emf:.3} times the model's by u_v, i_a and the speed",
            if nominal > 0.0 { resistance / nominal } else { f64::NAN }
        )));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::super::Severity;
    use super::super::made::{actuator_and_log, of};
    use super::*;
    use std::f64::consts::TAU;

    /// What is found once angle, current and voltage of a good log are multiplied by this.
    fn found(angle: f64, current: f64, voltage: f64) -> Vec<Finding> {
        let (model, mut log) = actuator_and_log();
        log.motor_angle_rad.iter_mut().for_each(|value| *value *= angle);
        log.current_a.iter_mut().flatten().for_each(|value| *value *= current);
        log.voltage_v.iter_mut().flatten().for_each(|value| *value *= voltage);
        of(&CHECK, &model, &log)
    }

    #[test]
    fn each_wrong_sign_is_told_by_its_column() {
        for (column, scales) in [
            ("motor_angle_rad has", [-1.0, 1.0, 1.0]),
            ("i_a has", [1.0, -1.0, 1.0]),
            ("u_v has", [1.0, 1.0, -1.0]),
        ] {
            let [angle, current, voltage] = scales;
            let told = found(angle, current, voltage);
            assert!(told.len() == 1 && told[0].message.starts_with(column), "{column}: {told:?}");
            assert_eq!(told[0].severity, Severity::Error);
        }
    }

    #[test]
    fn each_wrong_unit_is_told_by_its_name() {
        let model = crate::demo::actuator();
        let reduction = model.stages[0].reduction;
        let pairs = f64::from(model.motor.pole_pairs);
        for (name, angle) in [
            ("degrees", 360.0 / TAU),
            ("turns", 1.0 / TAU),
            ("electrical", pairs),
            ("behind the gear", 1.0 / reduction),
        ] {
            let told = found(angle, 1.0, 1.0);
            assert!(told.len() == 1 && told[0].message.contains(name), "{name}: {told:?}");
        }
        assert!(found(1.0, 1e3, 1.0)[0].message.ends_with("mA"));
    }

    #[test]
    fn what_is_right_is_a_note() {
        let told = found(1.0, 1.0, 1.0);
        assert!(told.len() == 1 && told[0].severity == Severity::Note, "{told:?}");
    }
}
