//! Elastoplastic friction after Dupont.
//!
//! ```text
//! ż = v (1 − α(z, v) sgn(v) z / z_ss),   z_ss = g(v)/σ0
//! α = 0                                              |z| ≤ z_ba, or sgn z ≠ sgn v
//!   = ½ sin(π (|z| − (z_ss + z_ba)/2) / (z_ss − z_ba)) + ½   z_ba < |z| < z_ss
//!   = 1                                              |z| ≥ z_ss
//! T = σ0 z + σ1 ż + σ2 v
//! ```
//!
//! with z a deflection, rad, and T in Nm. Up to the breakaway deflection z_ba it is a spring, so
//! that a torque below breakaway does not make the joint creep as LuGre's does. Source: Dupont,
//! Hayward, Armstrong, Altpeter, "Single state elastoplastic friction models", IEEE Trans. Autom.
//! Control 47 (2002).

use std::f64::consts::PI;

use super::Contact;

/// The rate of the deflection, rad/s; `breakaway` is z_ba over z_ss.
#[inline]
pub fn rate(contact: &Contact, deflection: f64, breakaway: f64) -> f64 {
    let Contact { speed, level, sigma0, .. } = *contact;
    let sliding = level / sigma0;
    speed - speed.abs() * share(speed, deflection, sliding, breakaway) * deflection / sliding
}

/// α, the share of the motion that slides.
fn share(speed: f64, deflection: f64, sliding: f64, breakaway: f64) -> f64 {
    let (size, from) = (deflection.abs(), breakaway * sliding);
    if deflection * speed <= 0.0 || size <= from {
        0.0
    } else if size < sliding {
        0.5 * (PI * (size - 0.5 * (sliding + from)) / (sliding - from)).sin() + 0.5
    } else {
        1.0
    }
}
