//! The workflow: where a model and a log disagree, what is missing, and by how much the gap shrinks
//! when it is added.

pub mod candidates;
pub mod findings;
pub mod hypothesis;
pub mod score_test;
