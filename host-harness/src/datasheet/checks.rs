//! Whether the numbers of a datasheet can belong to one motor.
//!
//! A number in the wrong unit, or one per phase where the terminals' is meant, is off by a factor that
//! shows against another number of the same sheet, or in a time constant.

use super::Datasheet;
use super::table::{digits, no_load_speed};

/// How far two statements of one thing may differ by the sheet's own rounding and tolerance.
const AGREES: f64 = 0.03;
/// How far a speed or a time constant computed from others may: several roundings together.
const ROUGHLY: f64 = 0.1;

/// What does not fit, a sentence each.
pub fn checks(sheet: &Datasheet) -> Vec<String> {
    let mut found = Vec::new();
    let (Some((torque_constant, _)), Some(resistance), Some(rotor)) =
        (sheet.torque_constant(), sheet.terminal_resistance_ohm, sheet.rotor_inertia_kg_m2)
    else {
        return found;
    };
    if let (Some(torque), Some(speed)) =
        (sheet.torque_constant_nm_per_a, sheet.speed_constant_rad_per_s_v)
    {
        let ratio = torque * speed;
        if (ratio - 1.0).abs() > AGREES {
            found.push(format!(
                "torque constant and speed constant disagree: their product is {} times what one motor has{}; the torque constant counts",
                digits(ratio),
                hint(ratio)
            ));
        }
    }
    if let Some(inductance) = sheet.terminal_inductance_h {
        let time = inductance / resistance;
        if !(1e-5..=2e-2).contains(&time) {
            found.push(format!(
                "the electrical time constant L/R is {} ms; motors have 0.01 to 20 ms: check the units of resistance and inductance",
                digits(1e3 * time)
            ));
        }
    }
    let time = rotor * resistance / torque_constant.powi(2);
    match sheet.mechanical_time_constant_s {
        Some(stated) if (time / stated - 1.0).abs() > ROUGHLY => found.push(format!(
            "the mechanical time constant that follows is {} ms, the sheet has {} ms: check rotor inertia, resistance and torque constant",
            digits(1e3 * time),
            digits(1e3 * stated)
        )),
        None if !(5e-4..=1.0).contains(&time) => found.push(format!(
            "the mechanical time constant J R/k_t² is {} ms; motors have 0.5 to 1000 ms: check the units of rotor inertia and torque constant",
            digits(1e3 * time)
        )),
        _ => {}
    }
    if let (Some(stated), Some(_)) = (sheet.no_load_speed_rad_per_s, sheet.nominal_voltage_v) {
        let derived = Datasheet { no_load_speed_rad_per_s: None, ..sheet.clone() };
        let derived = no_load_speed(&derived, torque_constant).unwrap_or(0.0);
        if (derived / stated - 1.0).abs() > ROUGHLY {
            found.push(format!(
                "the no-load speed that follows from voltage and torque constant is {} rpm, the sheet has {} rpm",
                digits(rpm(derived)),
                digits(rpm(stated))
            ));
        }
    }
    if let (Some(voltage), Some(current)) = (sheet.nominal_voltage_v, sheet.no_load_current_a)
        && current * resistance > 0.3 * voltage
    {
        found.push(format!(
            "the no-load current is {} of the stall current; motors have 0.5 to 10 %: check its unit",
            digits(current * resistance / voltage)
        ));
    }
    let ratio: f64 = sheet.gears.iter().product();
    if let Some(load) = sheet.load_inertia_kg_m2 {
        let share = load / (rotor * ratio * ratio);
        if !(1e-3..=1e3).contains(&share) {
            found.push(format!(
                "the load's inertia is {} times the rotor's behind the gear: check the units of both",
                digits(share)
            ));
        }
    }
    found
}

fn rpm(speed: f64) -> f64 {
    speed * 30.0 / std::f64::consts::PI
}

/// The mistake that a ratio of the constants is known for.
fn hint(ratio: f64) -> String {
    let known = [
        (
            0.75_f64.sqrt(),
            "a torque constant per peak ampere of a phase is 0.866 times the model's",
        ),
        (1.5_f64.sqrt(), "a torque constant per RMS ampere of a phase is 1.225 times the model's"),
        (3.0_f64.sqrt(), "a speed constant of one phase is 1.732 times that between terminals"),
        (1e-3, "is the torque constant in Nm/A? write its unit"),
        (1e3, "is the torque constant in mNm/A? write its unit"),
        (0.5, "a back-EMF constant of one phase is half the torque constant"),
    ];
    let near = known.iter().find(|(value, _)| (ratio / value - 1.0).abs() < AGREES);
    near.map_or(String::new(), |(_, why)| format!(" ({why})"))
}
