//! What is promised of the step, as relative RMS error of a state.
//!
//! At a drive's 50 µs every state stays within 1 %, angles within 0.1 %, within 0.3 % where the joint
//! chooses two micro-steps and 0.09 % where it chooses four and more. The other rows are what fourth
//! order leaves at a number of micro-steps. Bounds are for every scenario alike, and for the number that
//! the joint chooses.

use super::Quantity;

/// Largest distance of the two references from each other.
pub const BETWEEN_REFERENCES: f64 = 1e-4;

/// Step in µs, then the bound with one, two, and four or more micro-steps.
const STATES: [(f64, [f64; 3]); 4] = [
    (10.0, [0.0028, 0.0009, 0.0004]),
    (25.0, [0.0028, 0.0009, 0.0004]),
    (50.0, [0.01, 0.003, 0.0009]),
    (100.0, [0.069, 0.009, 0.0022]),
];

/// The bound for angles at a step of 50 µs or less.
const ANGLE: f64 = 0.001;

/// The bound for a state; `None` where nothing is promised for this step.
pub fn bound(step_us: f64, micro_steps: u32, quantity: Quantity) -> Option<f64> {
    let (_, states) = STATES.iter().find(|(step, _)| *step == step_us)?;
    let state = states[match micro_steps {
        0 | 1 => 0,
        2 | 3 => 1,
        _ => 2,
    }];
    let tight = quantity.is_angle() && step_us <= 50.0;
    Some(if tight { state.min(ANGLE) } else { state })
}

/// The bound for a state in fixed point.
pub fn fixed_bound(step_us: f64) -> Option<f64> {
    (step_us <= 50.0).then_some(0.02)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drive_step_is_bound_to_one_per_cent_and_angles_to_a_tenth_of_it() {
        assert_eq!(bound(50.0, 1, Quantity::StageSpeed(2)), Some(0.01));
        assert_eq!(bound(50.0, 1, Quantity::StageAngle(2)), Some(0.001));
        assert_eq!(bound(50.0, 2, Quantity::Current), Some(0.003));
        assert_eq!(bound(33.0, 1, Quantity::Current), None);
    }
}
