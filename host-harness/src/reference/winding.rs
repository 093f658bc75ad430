//! The winding of the reference: a current that lags, or one that follows at once.

use joint_core::effect::Effects;
use joint_core::joint::Drive;

use super::equations::{Equations, Held};
use crate::plant::Layout;

impl Equations {
    #[inline]
    pub(super) fn current_rate(&self, held: &Held, current: f64, speed: f64) -> f64 {
        let Some(per_inductance) = self.per_inductance else { return 0.0 };
        let driving = held.drive - self.drop(current);
        (driving - self.resistance * current - self.torque_constant * speed) * per_inductance
    }

    fn drop(&self, current: f64) -> f64 {
        let effects = self.effects.as_ref();
        effects.map_or(0.0, |effects| self.resistance * effects.voltage_drop(current, 0.0))
    }

    /// The current that flows: the state's, or the one that the inputs impose at once.
    #[inline]
    pub(super) fn current(&self, held: &Held, state: f64, speed: f64) -> f64 {
        match (self.drive, self.per_inductance) {
            (Drive::Voltage, Some(_)) => state,
            (Drive::Voltage, None) => {
                self.without_lag((held.drive - self.torque_constant * speed) / self.resistance)
            }
            (Drive::Current, _) => {
                self.effects.as_ref().map_or(held.drive, |effects| effects.true_current(held.drive))
            }
        }
    }

    /// Solves `i + drop(i)/2R = free`, whose left side rises with i and lies between 0 and free.
    fn without_lag(&self, free: f64) -> f64 {
        if self.drop(free) == 0.0 {
            return free;
        }
        let (mut low, mut high) = (0.0, free);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let excess = middle + self.drop(middle) / self.resistance - free;
            // Where free is negative, so are low and high, and both sides change sign.
            if excess * free.signum() > 0.0 {
                high = middle;
            } else {
                low = middle;
            }
        }
        0.5 * (low + high)
    }

    /// Puts a current that follows at once into the state.
    pub fn settle(&self, held: &Held, state: &mut [f64]) {
        let speed = state[self.layout().speed(0)];
        state[Layout::CURRENT] = self.current(held, state[Layout::CURRENT], speed);
    }
}
