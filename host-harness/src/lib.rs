//! Host side of the joint: logs and model files, the f64 reference, refitting, discovery, reports.

pub mod log;
pub mod model;
