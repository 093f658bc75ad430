//! The drive's torque against acceleration and friction, where the winding's equation cannot be asked.
//!
//! A current in mA, a reversed sign or an angle in degrees changes the inertia that the log shows by a
//! known factor. Nominal inertias and torque constants are off by tens of per cent, loads by more; so
//! only a factor that is nearer to a unit's than to one is told as an error.

use super::torque_balance::{ACCELERATION, CERTAIN, TorqueBalance};
use super::unit::{Mistake, angle_mistakes, figure, nearest};
use super::{Case, Check, Finding, friction, winding};

/// How well the inertia has to be known for a factor to be told, as a share of itself.
const KNOWN: f64 = 0.2;
/// How far off it is before it is told.
const FAR: f64 = 10.0;
/// Factors that no nominal inertia is off by.
const UNLIKELY: f64 = 30.0;
/// How near a unit's factor is, in proportion.
const NEAR: f64 = 4.0;

pub(super) const CHECK: Check =
    Check { name: "torque", compares: "the drive's torque against acceleration and friction", run };

fn run(case: &Case<'_>) -> Vec<Finding> {
    let Some(balance) = &case.balance else { return Vec::new() };
    if winding::constants(case).is_some() {
        return Vec::new();
    }
    let input = if case.log.current_a.is_some() { "i_a" } else { "u_v" };
    if case.log.current_a.is_none()
        && let Some(finding) = back_emf(case, balance)
    {
        return vec![finding];
    }
    let (inertia, error) = balance.coefficient(ACCELERATION);
    let (dissipated, power_error) = balance.dissipated();
    if -inertia > CERTAIN * error && dissipated < CERTAIN * power_error {
        return vec![
            Finding::error(format!(
                "{input} works against the motion: by it the joint's inertia is {} kg m² and its friction \
                 takes {} W",
                figure(inertia, error),
                figure(dissipated, power_error)
            ))
            .help(format!("reverse the sign of {input} or of motor_angle_rad")),
        ];
    }
    if -dissipated > CERTAIN * power_error {
        return vec![
            Finding::warning(format!(
                "{input} brakes while the joint moves: friction would give {} W instead of taking some",
                figure(-dissipated, power_error)
            ))
            .help(format!(
                "is the sign of {input} or of motor_angle_rad reversed, or does a load drive the joint?"
            )),
        ];
    }
    // Below what else varies, an inertia is that of whatever goes along with the acceleration.
    let outstanding = inertia.abs() * balance.acceleration > balance.residual;
    if error > KNOWN * inertia.abs() || !outstanding {
        return size(case, balance, input);
    }
    let ratio = inertia / balance.inertia;
    if (1.0 / FAR..FAR).contains(&ratio) {
        return vec![Finding::note(format!(
            "inertia at the motor {ratio:.3} times the model's by {input} and the acceleration"
        ))];
    }
    let mut mistakes = angle_mistakes(case.model);
    mistakes.retain(|mistake| mistake.factor.ln().abs() > UNLIKELY.ln());
    // An angle that is multiplied by a factor shows an inertia that is divided by it.
    mistakes.iter_mut().for_each(|mistake| mistake.factor = 1.0 / mistake.factor);
    if input == "i_a" {
        mistakes.push(Mistake { factor: 1e3, what: "i_a is in mA, not in A".into() });
    }
    let told = format!(
        "{input} and the acceleration make an inertia of {} kg m² at the motor, {} times the model's",
        figure(inertia, error),
        figure(ratio, error / balance.inertia)
    );
    vec![match nearest(&mistakes, ratio, NEAR) {
        Some(mistake) => Finding::error(format!("{told}: it looks as if {}", mistake.what)).help(
            "convert the column, or correct rotor_inertia_kg_m2 and torque_constant_nm_per_a",
        ),
        None => Finding::warning(told).help(format!(
            "check the unit of {input}, rotor_inertia_kg_m2 and torque_constant_nm_per_a"
        )),
    }]
}

/// The size of the input alone, where the motion does not tell the inertia: in mA it would make a thousand
/// times the torque that inertia, friction and weight need, and an angle in degrees a back-EMF beyond the
/// voltage.
fn size(case: &Case<'_>, balance: &TorqueBalance, input: &str) -> Vec<Finding> {
    let model = case.model;
    let weight = balance.weight.map_or(0.0, |weight| weight.amplitude().0);
    let needed = balance.inertia * balance.acceleration + friction::of_model(model)[0] + weight;
    let ratio = balance.torque / needed;
    if input == "i_a" && ratio > 1e3 / (1.0 + NEAR) {
        return vec![
            Finding::error(format!(
                "i_a makes {ratio:.0} times the torque that acceleration and friction need: it looks as if \
                 i_a is in mA, not in A"
            ))
            .help("convert the column, or correct torque_constant_nm_per_a"),
        ];
    }
    Vec::new()
}

/// Back-EMF of the logged speed against the voltage that drives the joint: it can hardly be larger.
fn back_emf(case: &Case<'_>, balance: &TorqueBalance) -> Option<Finding> {
    let voltage = case.log.voltage_v.as_ref()?;
    let largest =
        voltage.iter().filter(|u| u.is_finite()).fold(0.0_f64, |most, u| most.max(u.abs()));
    let emf = 2.0 * case.model.motor.back_emf_constant() * balance.fastest;
    let ratio = emf / largest;
    if ratio < FAR {
        return None;
    }
    let told = format!(
        "the logged speed makes a back-EMF of {emf:.1} V, {ratio:.0} times the largest u_v"
    );
    let degrees = format!("{told}: it looks as if motor_angle_rad is in degrees, not in radians");
    Some(Finding::error(degrees).help("convert the column, or correct the back-EMF constant"))
}

#[cfg(test)]
mod tests {
    use super::super::Severity;
    use super::super::made::{actuator_and_log, of};
    use super::*;

    /// What is found in torque mode once angle and current are multiplied by this.
    fn found(angle: f64, current: f64) -> Finding {
        let (model, mut log) = actuator_and_log();
        log.voltage_v = None;
        log.output_angle_rad = None;
        log.motor_angle_rad.iter_mut().for_each(|value| *value *= angle);
        log.current_a.iter_mut().flatten().for_each(|value| *value *= current);
        let mut told = of(&CHECK, &model, &log);
        assert_eq!(told.len(), 1, "{told:?}");
        told.remove(0)
    }

    #[test]
    fn milliamperes_and_degrees_are_told_without_a_voltage() {
        for (name, angle, current) in [("in mA", 1.0, 1e3), ("degrees", 57.29578, 1.0)] {
            let told = found(angle, current);
            assert!(told.message.contains(name), "{told:?}");
            assert_eq!(told.severity, Severity::Error);
        }
    }

    #[test]
    fn a_reversed_sign_is_told_by_the_column_it_may_be() {
        for (angle, current) in [(-1.0, 1.0), (1.0, -1.0)] {
            let told = found(angle, current);
            assert!(told.message.starts_with("i_a works against the motion"), "{told:?}");
        }
        let (model, mut log) = actuator_and_log();
        log.current_a = None;
        log.voltage_v.iter_mut().flatten().for_each(|value| *value = -*value);
        let told = of(&CHECK, &model, &log);
        assert!(told[0].message.starts_with("u_v works against the motion"), "{told:?}");
        log.voltage_v.iter_mut().flatten().for_each(|value| *value = -*value);
        log.motor_angle_rad.iter_mut().for_each(|value| *value *= 57.29578);
        assert!(of(&CHECK, &model, &log)[0].message.contains("degrees"));
    }

    #[test]
    fn what_is_right_is_a_note() {
        assert_eq!(found(1.0, 1.0).severity, Severity::Note);
    }
}
