//! Values of the model that no joint has, though the equations take them.
//!
//! An inertia in g cm², a stiffness with a mistake of the exponent or a reduction upside down: each turns into a
//! time that no machine of this kind has. The bounds are wide; they are there to catch the powers of ten.

use super::{Case, Check, Finding};
use crate::plant::{inertias, output_shaft};

/// Mechanical time constants, s: a micromotor's is a millisecond, a large drive's a few seconds.
const MECHANICAL_S: [f64; 2] = [1e-5, 1e3];
/// Electrical time constants, s.
const ELECTRICAL_S: [f64; 2] = [1e-8, 10.0];
/// Natural frequencies of a stage's spring between the masses beside it, Hz.
const SPRING_HZ: [f64; 2] = [1e-2, 1e6];

pub(super) const CHECK: Check =
    Check { name: "plausible", compares: "the model's values with each other", run };

fn run(case: &Case<'_>) -> Vec<Finding> {
    let model = case.model;
    let motor = &model.motor;
    let mut all = Vec::new();
    let inertias = inertias(model);
    let whole: f64 = inertias.iter().sum();
    let resistance = 2.0 * motor.phase_resistance_ohm;
    let outside = |value: f64, [low, high]: [f64; 2]| !(low..=high).contains(&value);
    if resistance > 0.0 {
        let squared = 2.0 * motor.back_emf_constant() * motor.torque_constant_nm_per_a;
        let mechanical = whole * resistance / squared;
        if outside(mechanical, MECHANICAL_S) {
            all.push(
                Finding::warning(format!(
                    "[motor] rotor_inertia_kg_m2 = {} with the load makes a mechanical time constant of \
                     {mechanical:.1e} s",
                    motor.rotor_inertia_kg_m2
                ))
                .help("check the units of inertia, resistance and torque constant (1 g cm² is 1e-7 kg m²)"),
            );
        }
        let electrical = 2.0 * motor.phase_inductance_h / resistance;
        if electrical > 0.0 && outside(electrical, ELECTRICAL_S) {
            all.push(
                Finding::warning(format!(
                    "[motor] phase_inductance_h = {} makes an electrical time constant of {electrical:.1e} s",
                    motor.phase_inductance_h
                ))
                .help("check the units of inductance and resistance"),
            );
        }
    }
    let mut shaft = 1.0;
    for (k, stage) in model.stages.iter().enumerate() {
        shaft /= stage.reduction;
        let stiffness = stage.stiffness_nm_per_rad * shaft * shaft;
        let reduced = 1.0 / (1.0 / inertias[k] + 1.0 / inertias[k + 1]);
        let natural = (stiffness / reduced).sqrt() / std::f64::consts::TAU;
        if outside(natural, SPRING_HZ) {
            all.push(
                Finding::warning(format!(
                    "[[stage]] number {} stiffness_nm_per_rad = {} makes a natural frequency of {natural:.1e} Hz",
                    k + 1,
                    stage.stiffness_nm_per_rad
                ))
                .help("check the units of stiffness and inertias"),
            );
        }
    }
    if output_shaft(model).abs() > 1.0 {
        all.push(
            Finding::warning(format!(
                "the model's gear speeds up by {:.3}: is a reduction upside down?",
                output_shaft(model).abs()
            ))
            .help("a reduction is input over output turns: 16 for 16:1"),
        );
    }
    all.into_iter().map(Finding::of_model).collect()
}

#[cfg(test)]
mod tests {
    use super::super::made::{actuator_and_log, of};
    use super::*;
    use crate::model::Model;

    fn found(change: impl Fn(&mut Model)) -> Vec<Finding> {
        let (mut model, log) = actuator_and_log();
        change(&mut model);
        of(&CHECK, &model, &log)
    }

    #[test]
    fn powers_of_ten_are_told_by_their_key() {
        assert_eq!(found(|_| {}), []);
        assert!(
            found(|m| m.motor.rotor_inertia_kg_m2 = 442.0)[0]
                .message
                .contains("rotor_inertia_kg_m2")
        );
        assert!(
            found(|m| m.stages[0].stiffness_nm_per_rad = 1e20)[0].message.contains("stiffness")
        );
        assert!(found(|m| m.motor.phase_inductance_h = 150.0)[0].message.contains("inductance"));
        assert!(found(|m| m.stages[0].reduction = 1.0 / 9.0)[0].message.contains("upside down"));
    }
}
