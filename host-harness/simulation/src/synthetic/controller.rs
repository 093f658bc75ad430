//! Position control as drives have it: what a measured joint's voltage mostly comes from.
//!
//! Under control the voltage follows from the angle, so that disturbances reach it; a log of an axis
//! at work is of this kind. Both laws see the motor's encoder in counts and a speed differentiated
//! from it through a first-order filter, and their output is limited. u in V, q in rad at the motor.
//!
//! ```text
//! P-PI  u = k_e v* + K_v (e_v + ω_i ∫ e_v dt),   e_v = v_ref + ω_p (q_ref − q) − v,  v* its reference
//! PD    u = K_p (q_ref − q) − K_v v
//! ```

use joint_core::per_unit::{Bases, reflected_inertia};

use crate::model::Model;

/// Which law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// A position loop around a speed loop with an integrator.
    PPi,
    /// Position and speed fed back at once.
    Pd,
}

/// A controller on its way.
#[derive(Clone, Debug)]
pub struct Controller {
    law: Law,
    /// Reference angle by sample, rad at the motor.
    pub reference_rad: Vec<f64>,
    speed_gain: f64,
    position_rate: f64,
    back_emf: f64,
    limit_v: f64,
    filter_s: f64,
    seen: Option<f64>,
    speed: f64,
    integral: f64,
}

impl Controller {
    /// A law of this bandwidth of its speed loop, rad/s, for a joint taken as rigid; the output
    /// stays within `limit_v`.
    pub fn new(
        law: Law,
        model: &Model,
        bandwidth: f64,
        limit_v: f64,
        reference_rad: Vec<f64>,
    ) -> Self {
        let bases = Bases::si(&model.motor, &model.stages);
        let inertia: f64 = (0..=model.stages.len())
            .map(|mass| reflected_inertia(&model.motor, &model.stages, &model.load, mass))
            .sum();
        let constant = model.motor.torque_constant_nm_per_a;
        let speed_gain = (bandwidth * inertia * bases.resistance / constant).max(0.5 * constant);
        Self {
            law,
            reference_rad,
            speed_gain,
            position_rate: bandwidth / 4.0,
            back_emf: constant,
            limit_v,
            filter_s: 0.2 / bandwidth,
            seen: None,
            speed: 0.0,
            integral: 0.0,
        }
    }

    /// The voltage from sample `k` on, V, when the encoder shows this angle, rad; `interval` is the
    /// time since the last call, s.
    pub fn voltage(&mut self, k: usize, angle: f64, interval: f64) -> f64 {
        let last = self.reference_rad.len().saturating_sub(1);
        let reference = |k: usize| self.reference_rad.get(k.min(last)).copied().unwrap_or(0.0);
        let raw = self.seen.map_or(0.0, |seen| (angle - seen) / interval);
        self.seen = Some(angle);
        self.speed += (raw - self.speed) * -(-interval / self.filter_s).exp_m1();
        let error = reference(k) - angle;
        let wanted = match self.law {
            Law::PPi => {
                let asked =
                    (reference(k + 1) - reference(k)) / interval + self.position_rate * error;
                let speed_error = asked - self.speed;
                self.integral += self.position_rate * speed_error * interval;
                self.back_emf * asked + self.speed_gain * (speed_error + self.integral)
            }
            Law::Pd => {
                let gain = (self.speed_gain + self.back_emf) * self.position_rate;
                gain * error - self.speed_gain * self.speed
            }
        };
        let limited = wanted.clamp(-self.limit_v, self.limit_v);
        // Anti-windup: what the limit took is taken from the integral.
        if self.law == Law::PPi {
            self.integral +=
                (limited - wanted) / self.speed_gain * (interval / self.filter_s).min(1.0);
        }
        limited
    }
}
