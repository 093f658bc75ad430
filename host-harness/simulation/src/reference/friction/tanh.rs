//! Static friction with a Stribeck curve: T = g(v) tanh(v / (w v0)) + σ2 v.
//!
//! No state and no stiffness: what is left of Coulomb's sign once it is made smooth, in Nm over
//! rad/s. A torque below breakaway lets the joint creep at a speed below w v0. It is what most
//! simulators run. Source: Armstrong-Hélouvry, Dupont, Canudas de Wit, "A survey of models,
//! analysis tools and compensation methods for the control of machines with friction",
//! Automatica 30 (1994), with the sign smoothed; as in Makkar et al., "A new continuously
//! differentiable friction model", Proc. IEEE/ASME AIM (2005).

use super::Contact;

/// The torque without the viscous part, Nm; `width` is w.
#[inline]
pub fn torque(contact: &Contact, width: f64) -> f64 {
    contact.level * (contact.speed / (width * contact.stribeck_velocity)).tanh()
}
