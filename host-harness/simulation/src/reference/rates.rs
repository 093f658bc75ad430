//! How fast the equations relax, which is what bounds an explicit step.

use joint_core::effect::{Effects, Flow, MEMORIES};

use super::equations::{Equations, Mass};
use super::friction::Family;

impl Equations {
    /// The fastest rate in the equations near a state, per second: an explicit method's step times
    /// this must stay below one. Bristles are taken at one and a half times their speed and three
    /// times the Stribeck velocity more, since the state moves on.
    pub fn rate_near(&self, state: &[f64]) -> f64 {
        let layout = self.layout();
        let masses = self.rate(|k, mass| {
            let speed = state.get(layout.speed(k)).copied().unwrap_or(0.0);
            self.family.pace(1.5 * speed.abs() + 3.0 / mass.per_stribeck_velocity, mass)
        });
        masses.max(self.memory_rate(state)).max(self.corner_rate())
    }

    /// The fastest rate at which effects forget, per second.
    fn memory_rate(&self, state: &[f64]) -> f64 {
        let layout = self.layout();
        let speeds = state.get(layout.speed(0)..layout.bristle(0)).unwrap_or_default();
        let current = state.first().copied().unwrap_or(0.0);
        let mut all = [None; MEMORIES];
        if let Some(effects) = &self.effects {
            effects.relax(&Flow { current, drive: 0.0, speeds }, &mut all);
        }
        all.iter().flatten().fold(0.0, |fastest: f64, own| fastest.max(2.0 * own.reach))
    }

    /// The rate at which a friction law of the speed alone stops its mass.
    fn corner_rate(&self) -> f64 {
        let Family::Tanh { width } = self.family else { return 0.0 };
        self.masses.iter().fold(0.0, |fastest: f64, mass| {
            let slope = (mass.alpha0 + mass.alpha1) * mass.per_stribeck_velocity / width;
            fastest.max(slope * mass.per_inertia)
        })
    }

    /// The fastest rate in the equations where every mass runs at this speed, rad/s at the motor.
    pub fn rate_at(&self, speed: f64) -> f64 {
        self.rate(|_, _| speed.abs())
    }

    fn rate(&self, speed: impl Fn(usize, &Mass) -> f64) -> f64 {
        self.masses.iter().enumerate().fold(self.standing_rate, |fastest, (k, mass)| {
            let level = mass.alpha0.min(mass.alpha0 + mass.alpha1);
            fastest.max(if level > 0.0 { mass.sigma0 * speed(k, mass) / level } else { 0.0 })
        })
    }
}

impl Family {
    /// The speed at which a LuGre bristle relaxes as fast as this law where a mass moves at `speed`.
    fn pace(self, speed: f64, mass: &Mass) -> f64 {
        match self {
            Family::LuGre | Family::LimitedViscous { .. } => speed,
            // Between breakaway and sliding the bristle gives way along a ramp, on top of its lean.
            Family::ElastoPlastic { .. } => 2.0 * speed,
            // Elements that stick go along with the speed, but only from a reversal to their limits.
            Family::MaxwellSlip { attraction, .. } => {
                speed.min((6.0 + attraction) / mass.per_stribeck_velocity)
            }
            Family::Tanh { .. } => 0.0,
        }
    }
}
