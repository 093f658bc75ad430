//! The reference's state at the motor as quantities at their own sides.

use joint_core::effect::{Effects, MEMORIES};

use super::equations::Equations;
use crate::plant::{Layout, Snapshot, StageSnapshot};

impl Equations {
    /// The state as it is reported.
    pub fn snapshot(&self, state: &[f64]) -> Snapshot {
        let layout = self.layout();
        let current_a = state[Layout::CURRENT];
        let effects = self.effects.as_ref();
        let bristle = |k: usize| self.masses[k].zeta(state[layout.bristle(k)]);
        let mut angle = state[Layout::ANGLE];
        let mut memory = [0.0; MEMORIES];
        for (slot, value) in memory.iter_mut().zip(&state[layout.memory(0)..layout.len()]) {
            *slot = *value;
        }
        let stages = (0..layout.stages).map(|k| {
            let shaft = self.masses[k + 1].shaft;
            angle -= state[layout.deflection(k)];
            StageSnapshot {
                angle_rad: angle * shaft,
                speed_rad_per_s: state[layout.speed(k + 1)] * shaft,
                windup_rad: state[layout.deflection(k)] * shaft,
                bristle: bristle(k + 1) * shaft.signum(),
            }
        });
        Snapshot {
            current_a,
            measured_current_a: effects
                .map_or(current_a, |effects| effects.shown_current(current_a, &memory)),
            motor_angle_rad: state[Layout::ANGLE],
            motor_speed_rad_per_s: state[layout.speed(0)],
            motor_bristle: bristle(0),
            stages: stages.collect(),
        }
    }
}
