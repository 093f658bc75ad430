//! The winding of the reference: a current that lags, or one that follows at once.

use joint_core::effect::{Effects, MEMORIES, Memory, Winding};
use joint_core::joint::Drive;

use super::equations::{Equations, Held};
use crate::plant::Layout;

impl Equations {
    #[inline]
    pub(super) fn current_rate(
        &self,
        held: &Held,
        current: f64,
        speed: f64,
        back_emf: f64,
        memory: &Memory<f64>,
    ) -> f64 {
        let Some(per_inductance) = self.per_inductance else { return 0.0 };
        let back_emf = self.torque_constant * (1.0 + back_emf) * speed;
        let driving = self.limited(held.drive, back_emf);
        let driving = driving - self.drop(driving, current, memory);
        (driving - self.resistance * current - back_emf) * per_inductance
    }

    /// What a limit of the current leaves of a voltage against this back-EMF.
    fn limited(&self, volts: f64, back_emf: f64) -> f64 {
        self.effects.as_ref().map_or(volts, |effects| {
            let settled = (volts - back_emf) / self.resistance;
            volts - self.resistance * effects.excess(settled).value
        })
    }

    fn drop(&self, volts: f64, current: f64, memory: &Memory<f64>) -> f64 {
        let drive = volts / self.resistance;
        self.effects.as_ref().map_or(0.0, |effects| {
            let at = Winding { current, per_drop: 0.0, drive };
            self.resistance * effects.voltage_drop(at, memory)
        })
    }

    /// The current that flows: the state's, or the one that the inputs impose at once.
    #[inline]
    pub(super) fn current(&self, held: &Held, state: f64, speed: f64, memory: &Memory<f64>) -> f64 {
        match (self.drive, self.per_inductance) {
            (Drive::Voltage, Some(_)) => state,
            (Drive::Voltage, None) => {
                let back_emf = self.torque_constant * speed;
                let driving = self.limited(held.drive, back_emf);
                let free = (driving - back_emf) / self.resistance;
                self.without_lag(free, |current| self.drop(driving, current, memory))
            }
            (Drive::Current, _) => {
                self.effects.as_ref().map_or(held.drive, |effects| effects.true_current(held.drive))
            }
        }
    }

    /// Solves `i + drop(i)/2R = free`, whose left side rises with i and lies between 0 and free.
    fn without_lag(&self, free: f64, drop: impl Fn(f64) -> f64) -> f64 {
        if drop(free) == 0.0 {
            return free;
        }
        let (mut low, mut high) = (0.0, free);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let excess = middle + drop(middle) / self.resistance - free;
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
        let layout = self.layout();
        let mut memory = [0.0; MEMORIES];
        for (slot, value) in memory.iter_mut().zip(&state[layout.memory(0)..]) {
            *slot = *value;
        }
        let speed = state[layout.speed(0)];
        state[Layout::CURRENT] = self.current(held, state[Layout::CURRENT], speed, &memory);
    }
}
