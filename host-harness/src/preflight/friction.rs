//! Friction that the model does not have at all.
//!
//! A datasheet has no friction, and a model made from one has none. Plain Coulomb friction is then told as
//! whatever effect imitates it best. It shows as torque that changes with the sign of the speed.

use super::torque_balance::{CERTAIN, COULOMB, VISCOUS};
use super::unit::figure;
use super::{Case, Check, Finding};
use crate::model::Model;

pub(super) const CHECK: Check =
    Check { name: "friction", compares: "torque against the sign and size of the speed", run };

/// Coulomb level and viscous coefficient of all masses at the motor, by the model.
pub(super) fn of_model(model: &Model) -> [f64; 2] {
    let bases = joint_core::per_unit::Bases::si(&model.motor, &model.stages);
    let stages = model.stages.iter().map(|stage| &stage.friction);
    let frictions = std::iter::once(&model.motor.friction).chain(stages).enumerate();
    frictions.fold([0.0; 2], |[coulomb, viscous], (mass, friction)| {
        let shaft = bases.shaft(mass).abs();
        [
            coulomb + friction.coulomb_nm * shaft,
            viscous + friction.sigma2_nm_s_per_rad * shaft * shaft,
        ]
    })
}

fn run(case: &Case<'_>) -> Vec<Finding> {
    let Some(balance) = &case.balance else { return Vec::new() };
    let [coulomb, viscous] = of_model(case.model);
    let (level, level_error) = balance.coefficient(COULOMB);
    let (slope, slope_error) = balance.coefficient(VISCOUS);
    let rubs = balance.both_ways && level > CERTAIN * level_error;
    let drags = slope > CERTAIN * slope_error;
    let shown = format!(
        "Coulomb {} Nm and viscous {} Nm s/rad at the motor",
        figure(level, level_error),
        figure(slope, slope_error)
    );
    if coulomb > 0.0 {
        return match rubs {
            true => vec![Finding::note(format!("friction by the log: {shown}"))],
            false => Vec::new(),
        };
    }
    // Bristles that stretch by a thousandth of a radian, a rule of thumb for a start.
    let lines = format!(
        "give it a start, for example [motor.friction] coulomb_nm = {level:.2e}, sigma0_nm_per_rad = {:.1e}, \
         sigma1_nm_s_per_rad = {:.1e}, sigma2_nm_s_per_rad = {:.2e}",
        1e3 * level,
        level,
        slope.max(0.0)
    );
    match (rubs, drags, viscous > 0.0) {
        (true, _, false) => {
            vec![Finding::error(format!("the model has no friction, and the log shows some: {shown}")).help(lines)]
        }
        (true, _, true) => {
            vec![Finding::warning(format!("the model has no Coulomb friction, and the log shows some: {shown}")).help(lines)]
        }
        (false, true, false) => vec![
            Finding::warning(format!("the model has no friction, and the log shows some: {shown}"))
                .help("give [motor.friction] a sigma2_nm_s_per_rad, and log motion in both directions"),
        ],
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Severity;
    use super::super::made::{actuator_and_log, of};
    use super::*;
    use joint_core::params::Friction;

    #[test]
    fn a_model_without_friction_is_told_and_given_a_start() {
        let (mut model, log) = actuator_and_log();
        model.motor.friction = Friction::default();
        model.stages[0].friction = Friction::default();
        let told = of(&CHECK, &model, &log);
        assert!(told[0].message.starts_with("the model has no friction"), "{told:?}");
        assert_eq!(told[0].severity, Severity::Error);
        assert!(told[0].help.contains("coulomb_nm = "), "{told:?}");
        model.motor.friction.sigma2_nm_s_per_rad = 1e-4;
        assert_eq!(of(&CHECK, &model, &log)[0].severity, Severity::Warning);
    }

    #[test]
    fn friction_that_the_model_has_is_a_note() {
        let (model, log) = actuator_and_log();
        assert!(of(&CHECK, &model, &log).iter().all(|told| told.severity == Severity::Note));
    }
}
