//! Generalised Maxwell slip: several elements in parallel, each of which sticks or slides.
//!
//! ```text
//! sticks:  dF_i/dt = k_i v                          until |F_i| = α_i g(v)
//! slides:  dF_i/dt = sgn(v) C (α_i − F_i/s(v)),   s(v) = sgn(v) g(v),   until v changes its sign
//! T = Σ F_i + (σ1/σ0) Σ dF_i/dt + σ2 v
//! ```
//!
//! with F_i in Nm. Elements that give way one after the other leave hysteresis with nonlocal memory
//! before sliding, and C, Nm/s, the lag of friction behind the speed in sliding. Shares
//! α_i = 1/n; stiffnesses k_i fall linearly and sum to σ0, so that the joint is as stiff from rest
//! as LuGre's. Source: Al-Bender, Lampaert, Swevers, "The generalized Maxwell-slip model: a novel
//! model for friction simulation and compensation", IEEE Trans. Autom. Control 50 (2005), with one
//! coefficient for the damping of all elements, as LuGre has it.
//!
//! States of a mass: F_i; one that is 1 where element i slides; and the integral of g, whose rate is
//! how [`change`] knows the level.

use super::Contact;

/// Share of σ0 that element `i` of `elements` has.
fn stiffness(i: usize, elements: usize) -> f64 {
    let n = elements as f64;
    2.0 * (n - i as f64) / (n * (n + 1.0))
}

/// Rates of the states of `own`, and the torque without the viscous part, Nm.
#[inline]
pub fn rate(
    contact: &Contact,
    elements: usize,
    attraction: f64,
    own: &[f64],
    rates: &mut [f64],
) -> f64 {
    let Contact { speed, level, sigma0, sigma1, stribeck_velocity } = *contact;
    let attraction = attraction * sigma0 * stribeck_velocity;
    let share = 1.0 / elements as f64;
    let (torques, modes) = own.split_at(elements.min(own.len()));
    let (mut sum, mut change) = (0.0, 0.0);
    for (i, (torque, mode)) in torques.iter().zip(modes).enumerate() {
        let slides = *mode > 0.5 && torque * speed > 0.0;
        let rate = if slides {
            attraction * (speed.signum() * share - torque / level)
        } else {
            stiffness(i, elements) * sigma0 * speed
        };
        rates[i] = rate;
        sum += torque;
        change += rate;
    }
    if let Some(last) = rates.last_mut() {
        *last = level;
    }
    sum + sigma1 / sigma0 * change
}

/// Between two steps: elements at their limits begin to slide, those whose motion has reversed
/// stick. Whether any did.
pub fn change(elements: usize, speed: f64, level: f64, own: &mut [f64]) -> bool {
    let limit = level / elements as f64;
    let (torques, modes) = own.split_at_mut(elements.min(own.len()));
    let mut any = false;
    for (torque, mode) in torques.iter_mut().zip(modes) {
        let pushed = *torque * speed > 0.0;
        if *mode > 0.5 {
            if !pushed {
                *mode = 0.0;
                any = true;
            }
        } else if pushed && torque.abs() >= limit {
            *torque = torque.signum() * limit;
            *mode = 1.0;
            any = true;
        }
    }
    any
}
