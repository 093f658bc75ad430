//! What may look like a missing effect and is none: how the log was stamped, another shape of friction, and a
//! disturbance that is correlated in time.
//!
//! Each of these runs the search, or goes on with what it found, on other terms; what explains the log better stays.

pub(crate) mod coloured;
mod coloured_effects;
pub(crate) mod friction_shape;
pub(crate) mod late_current;
pub(crate) mod timing;
