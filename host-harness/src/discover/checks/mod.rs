//! What refuses an effect or keeps it: each check asks one question of a model that has been fitted.
//!
//! Some stand before an effect is added (whether a joint can have it, whether it gains more than chance and whether the
//! gain is its own), some behind (whether it is still needed, whether another stands in its place as well, whether
//! unseen samples confirm it), and one asks of the whole model whether what is left is noise.

pub(crate) mod admissibility;
pub(crate) mod alike;
pub(crate) mod base_refit;
pub(crate) mod bootstrap;
pub(crate) mod confirmed;
mod contradiction;
pub(crate) mod elimination;
pub(crate) mod finer_steps;
pub mod goodness_of_fit;
pub(crate) mod least_gain;
pub(crate) mod needless;
pub(crate) mod noise_ratio;
pub(crate) mod order;
pub(crate) mod own_gain;
pub(crate) mod rival;
