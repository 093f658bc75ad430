//! How much a finding explains, in proportion: what a user of the model loses without it.
//!
//! A likelihood says whether a difference is there, not whether it matters. Here the disturbance that
//! a model leaves on the equation that misses most is estimated with the same filter before and after
//! the effects were added, on samples that no fit has seen, and split into what the effects explain,
//! what a generic family of functions still predicts, what is correlated in time but follows nothing,
//! and what the sensors and white noise alone leave.

pub(crate) mod blocks;
pub(crate) mod budget;
pub(crate) mod disturbance;
pub(crate) mod elsewhere;
pub(crate) mod excitation;
mod family;
mod generic;
mod hats;
mod linear;
mod map;
pub(crate) mod rest;
mod shares;
pub(crate) mod slope;
pub(crate) mod unseen;

pub use blocks::{Blocks, Share};
pub use budget::{Budget, FreeRun};
pub use generic::Predicted;
pub use slope::Slope;
pub use unseen::Unseen;
