//! Host side of the joint: logs and model files, the f64 reference, refitting, discovery, reports.

pub mod cli;
pub mod cross_check;
pub mod datasheet;
pub mod demo;
pub mod discover;
pub mod encoders;
pub mod energy;
pub mod estimate;
pub mod export;
pub mod fault;
pub mod grid;
pub mod import;
pub mod inputs;
pub mod interrupt;
pub mod lanes;
pub mod layout;
pub mod log;
pub mod model;
pub mod observe;
pub mod output;
pub mod planetary;
pub mod plant;
pub mod plot;
pub mod preflight;
pub mod probe;
pub mod reference;
pub mod report;
pub mod reproduce;
pub mod scenario;
pub mod score;

pub mod simulated;
pub mod start;
pub mod synthetic;
pub mod transfer;
pub mod verb;
mod wide;
