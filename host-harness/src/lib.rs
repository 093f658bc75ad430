//! Host side of the joint: logs and model files, the f64 reference, refitting, discovery, reports.

pub mod cli;
pub mod cross_check;
pub mod datasheet;
pub mod demo;
pub mod discover;
pub mod export;
pub mod failure;
pub mod identify;

pub mod import;
pub mod machines;
pub mod observe;
pub mod output;
pub mod planetary;
pub mod plot;
pub mod preflight;
pub mod probe;
pub mod report;
pub mod reproduce;
pub mod score;
pub mod simulated;
pub mod start;
mod terminal;
pub mod transfer;
pub mod verb;

pub use joint_estimation as estimate;
pub use joint_estimation::interrupt;
pub use joint_simulation::{
    acting, encoders, energy, fault, grid, inputs, lanes, layout, log, model, plant, reference,
    scenario, standard, synthetic,
};
