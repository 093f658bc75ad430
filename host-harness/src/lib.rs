//! Host side of the joint: logs and model files, the f64 reference, refitting, discovery, reports.

pub mod cli;
pub mod cross_check;
pub mod demo;
pub mod discover;
pub mod encoders;
pub mod energy;
pub mod estimate;
pub mod export;
pub mod fault;
pub mod inputs;
pub mod interrupt;
pub mod log;
pub mod model;
pub mod observe;
pub mod output;
pub mod planetary;
pub mod plant;
pub mod probe;
pub mod reference;
pub mod report;
pub mod reproduce;
pub mod scenario;
pub mod score;
pub mod simulated;
pub mod synthetic;
pub mod verb;
