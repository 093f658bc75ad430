//! The motor: its back-EMF, how it is commutated, its three phases, the amplifier that feeds them,
//! and the DC equivalent that the joint's step runs.
//!
//! The step carries one current, equation (10); here is also what that stands for: three phases in
//! star, (4)–(9), trapezoidal back-EMF, (5), a six-step table that follows from it, and an inverter
//! with dead time and current feedback. [`SixStep`](crate::six_step::SixStep) puts them before a joint whose current
//! is imposed, so that commutation and its ripple act on the same gear and friction.

pub mod back_emf;
pub mod commutation;
mod dc_equivalent;
pub mod inverter;
pub mod three_phase;

pub(crate) use dc_equivalent::RotorKick;
