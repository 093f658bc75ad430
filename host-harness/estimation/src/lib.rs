//! Prediction-error estimation: how well a model predicts a log, one sample ahead.
//!
//! A simulated trajectory drifts away from a measured one for reasons that are not the model's
//! fault: noise that the joint really felt, and stick-slip that amplifies it. A filter that is
//! corrected by every measurement does not, and what is left of its predictions, divided by what
//! they should scatter, is white with variance one when the model is right. Everything here, from
//! refitting to naming an effect, works on these whitened innovations.

pub mod abreast;
pub mod adjoint;
pub mod colour;
pub mod coordinates;
mod covariance;
mod descent;
mod encoders;
mod energy;
pub mod filter;
pub mod finer;
pub mod fit;
pub mod free_run;
pub mod gains;
pub mod gram;
pub mod interrupt;
mod keep;
pub mod late;
mod motion;
pub mod noise;
mod observer;
pub mod parameters;
mod pass;
mod reach;
pub mod record;
pub mod refit;
pub mod replicate;
mod reversal;
mod scales;
mod scatter;
mod scoring;
pub mod scout;
pub mod simulation;
pub mod slope;
mod slopes;
mod standard_errors;
mod stretches;
mod tape;
pub mod timing;
mod trials;
mod whole_registers;
