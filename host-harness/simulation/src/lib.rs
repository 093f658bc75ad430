//! The joint on the host: its model files and logs, its step in lanes, the f64 reference, and logs of joints
//! whose truth is known.
//!
//! Everything that is compiled for every scalar and number of stages is here, so that what is built on it is
//! compiled without it.

pub mod acting;
pub mod demo;
pub mod encoders;
pub mod energy;
pub mod fault;
pub mod grid;
pub mod inputs;
pub mod lanes;
pub mod layout;
pub mod log;
pub mod model;
pub mod plant;
pub mod quantity;
pub mod reference;
pub mod scenario;
pub mod standard;
pub mod synthetic;
pub mod wide;
