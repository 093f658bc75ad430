//! The workflow: where a model and a log disagree, what is missing, and by how much the gap shrinks
//! when it is added.

mod answer;
pub mod candidates;
pub mod findings;
mod force;
mod gate;
mod hypothesis;
mod next_experiment;
mod score_test;
mod search;
mod whereabouts;

pub use answer::discover;
