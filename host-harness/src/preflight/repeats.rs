//! Samples that repeat the one before: a channel that is read more often than it is measured.
//!
//! A joint that turns by several counts between two samples does not show the same angle twice. Held values
//! are late by half their time and look like an encoder's error.

use super::windows::scatter;
use super::{Case, Check, Finding};
use crate::log::{MOTOR_ANGLE, OUTPUT_ANGLE};

/// Samples around one that tell how fast it should move.
const AROUND: usize = 10;
/// Counts that a sample must be expected to move for a repetition to tell.
const MOVES: f64 = 3.0;
/// Share of the fast samples that may repeat.
const ALLOWED: f64 = 0.01;
/// Samples that repeat from which on they are told.
const SEVERAL: usize = 20;

pub(super) const CHECK: Check = Check {
    name: "repeats",
    compares: "each sample against the one before while the joint moves",
    run,
};

fn run(case: &Case<'_>) -> Vec<Finding> {
    let output = case.log.output_angle_rad.as_deref().map(|angle| (OUTPUT_ANGLE, angle));
    let angles = [Some((MOTOR_ANGLE, case.log.motor_angle_rad.as_slice())), output];
    angles.into_iter().flatten().filter_map(|(name, angle)| repeated(case, name, angle)).collect()
}

fn repeated(case: &Case<'_>, name: &str, angle: &[f64]) -> Option<Finding> {
    let mut changing = angle.to_vec();
    changing.dedup();
    // Without its repetitions a held channel is smooth, so that this is the encoder alone: a count, or what
    // would scatter like it.
    let count = 12.0_f64.sqrt() * scatter(&changing).max(1e-12);
    let (mut asked, mut repeating, mut first) = (0, 0, None);
    let mut run = 0;
    for k in AROUND..angle.len().saturating_sub(AROUND) {
        let change = (angle[k] - angle[k - 1]).abs();
        if change == 0.0 {
            run += 1;
            continue;
        }
        let (from, to) = (k.saturating_sub(AROUND + run), k + AROUND);
        let pace = (angle[to] - angle[from]).abs() / (to - from) as f64;
        if pace > MOVES * count {
            asked += run + 1;
            // A joint that stood still for a while goes on at its pace; a held value leaps to catch up.
            if run > 0 && change > 0.5 * (run + 1) as f64 * pace {
                repeating += run;
                first = first.or(Some(k - run));
            }
        }
        run = 0;
    }
    let share = repeating as f64 / f64::from(asked.max(1) as u32);
    let first = first?;
    (repeating >= SEVERAL && share > ALLOWED).then(|| {
        Finding::warning(format!(
            "{name} repeats {:.0} % of its samples while the joint moves, first at t_s = {}",
            100.0 * share,
            case.log.time_s[first]
        ))
        .help("log it no faster than it is measured, or leave the repeated fields empty")
        .at(first)
    })
}

#[cfg(test)]
mod tests {
    use super::super::made::{actuator_and_log, of};
    use super::*;

    #[test]
    fn an_encoder_read_twice_is_told() {
        let (model, mut log) = actuator_and_log();
        assert_eq!(of(&CHECK, &model, &log), []);
        for k in (1..log.len()).step_by(2) {
            log.motor_angle_rad[k] = log.motor_angle_rad[k - 1];
        }
        let told = of(&CHECK, &model, &log);
        assert!(told[0].message.starts_with("motor_angle_rad repeats 50 %"), "{told:?}");
    }
}
