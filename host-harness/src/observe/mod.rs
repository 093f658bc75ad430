//! Designing an observer, and running it over a log.
//!
//! The drive only multiplies and adds; everything that takes thought is done here, from the model,
//! its effects and its sensors: how much of an innovation belongs to which state, how uncertain
//! the result is, from when on a load has changed.

pub mod baseline;
pub mod bench;
pub mod bound;
pub mod counted;
pub mod design;
pub mod drive;
pub mod judge;
pub mod linear;
pub mod noise;
pub mod over;
pub mod plot;
pub mod rating;
pub mod riccati;
pub mod run;
pub mod score;
pub mod sensing;
pub mod set;
pub mod table;
pub mod truth;
pub mod twin;
