//! What a recording shows of its own mistakes.
//!
//! An angle that wraps or a sample that no joint can reach is no effect of the joint. Told when the log is
//! read, it is not looked for in physics.

use super::{Case, Check, Finding};
use crate::log::{Log, MOTOR_ANGLE, OUTPUT_ANGLE};
use std::f64::consts::{PI, TAU};

/// How near to a whole turn a jump has to be, as a share of a turn.
const NEAR: f64 = 0.1;
/// How many times further than its neighbourhood moves in a sample a leap goes, and comes back.
const LEAP: f64 = 20.0;
/// How many samples on either side are a neighbourhood.
const AROUND: usize = 10;

pub(super) const CHECK: Check =
    Check { name: "angle-jumps", compares: "each angle against its neighbours", run };

fn run(case: &Case<'_>) -> Vec<Finding> {
    of(case.log)
}

/// What is wrong with a log's angles.
pub(super) fn of(log: &Log) -> Vec<Finding> {
    let mut all = Vec::new();
    let angles =
        [(MOTOR_ANGLE, Some(&log.motor_angle_rad)), (OUTPUT_ANGLE, log.output_angle_rad.as_ref())];
    for (name, angle) in angles.into_iter().filter_map(|(name, angle)| Some((name, angle?))) {
        let told = |found: &[usize], what: &str| {
            let (count, first) = (found.len(), log.time_s[found[0]]);
            format!("{name} {what} {count} times, first at t_s = {first}")
        };
        let wraps = wraps(angle);
        let leaps = leaps(angle);
        if let Some(first) = wraps.first() {
            all.push(
                Finding::error(told(&wraps, "jumps by a turn between two samples"))
                    .help(format!("an angle counts on over whole turns: unwrap {name}"))
                    .at(*first),
            );
        } else if let Some(first) = leaps.first() {
            all.push(
                Finding::warning(told(&leaps, "leaps for one sample and comes back"))
                    .help("leave these fields empty")
                    .at(*first),
            );
        }
    }
    all
}

/// Samples before which an angle that moves little jumps by a turn.
pub(crate) fn wraps(angle: &[f64]) -> Vec<usize> {
    let step = |k: usize| angle[k] - angle[k - 1];
    let small = |k: usize| step(k).abs() < 0.25 * PI;
    (2..angle.len().saturating_sub(1))
        .filter(|k| (step(*k).abs() - TAU).abs() < NEAR * TAU && small(k - 1) && small(k + 1))
        .collect()
}

/// Samples at which an angle leaves its way and is back at the next one.
fn leaps(angle: &[f64]) -> Vec<usize> {
    let step = |k: usize| (angle[k] - angle[k - 1]).abs();
    (1..angle.len().saturating_sub(1))
        .filter(|k| {
            let [before, own, after] = [angle[k - 1], angle[*k], angle[k + 1]];
            let off = (own - 0.5 * (before + after)).abs();
            // Most samples are no suspects; a neighbourhood is looked at where one is.
            let suspect = off > LEAP * (after - before).abs();
            suspect && {
                let near = k.saturating_sub(AROUND).max(1)..(k + AROUND).min(angle.len());
                let others = near.filter(|other| other != k && *other != k + 1).map(step);
                let most = others.fold(0.0, f64::max);
                most > 0.0 && off > LEAP * most
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::made::{actuator_and_log, of};
    use super::*;

    #[test]
    fn a_good_log_raises_no_doubt() {
        let (model, log) = actuator_and_log();
        assert_eq!(of(&CHECK, &model, &log), []);
    }

    #[test]
    fn an_angle_that_wraps_is_told_with_its_first_jump() {
        let (model, mut log) = actuator_and_log();
        let before = log.motor_angle_rad.clone();
        for angle in &mut log.motor_angle_rad {
            *angle = (*angle + PI).rem_euclid(TAU) - PI;
        }
        let off = |k: &usize| (log.motor_angle_rad[*k] - before[*k]).abs() > 1.0;
        let first = (0..log.len()).find(off);
        let told = of(&CHECK, &model, &log);
        assert_eq!(told[0].row, first, "{told:?}");
        assert!(told[0].help.ends_with("unwrap motor_angle_rad"), "{told:?}");
    }

    #[test]
    fn samples_that_no_joint_can_reach_are_counted() {
        let (model, mut log) = actuator_and_log();
        let angle = log.output_angle_rad.as_mut().unwrap();
        angle[4000] += 0.3;
        angle[4500] -= 0.3;
        let told = format!(
            "output_angle_rad leaps for one sample and comes back 2 times, first at t_s = {}",
            log.time_s[4000]
        );
        assert_eq!(of(&CHECK, &model, &log)[0].message, told);
    }
}
