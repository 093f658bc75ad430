//! The workflow: where a model and a log disagree, what is missing, and by how much the gap shrinks
//! when it is added.

mod annealed;
pub mod answer;
mod belief;
mod bootstrap;
mod borne_out;
pub mod candidates;
mod chance;
mod coloured;
pub mod comb;
mod confidence;
mod constant;
mod contradiction;
pub mod evidence;
pub mod experiment;
pub mod findings;
mod finer;
mod followed;
pub mod force;
mod fork;
pub mod gate;
mod gear_or_encoder;
pub mod hidden;
mod hope;
pub mod hypothesis;
pub mod lines;
mod measured;
mod named;
mod needless;
pub mod next_experiment;
mod order;
mod progress;
mod proportion;
pub mod protected;
mod reasons;
mod rival;
mod rows;
pub mod score_test;
pub mod search;
mod settle;
mod shaped;
mod timing;
#[cfg(test)]
mod trial;
mod undecided;
mod ways;
pub mod whereabouts;

pub use answer::{DiscoverError, discover, discover_beside, discover_without};
