//! What the boards share: the parameter block, the control period, and the replay.
//!
//! All but the boards themselves compiles on the host too, so whoever writes a block, reads a frame
//! or checks what a drive computed uses the very code that runs on the chip. `unsafe` is for
//! registers, and stands with the board that has them.

#![cfg_attr(target_os = "none", no_std)]

pub mod admissible;
pub mod any_control;
pub mod assumed;
pub mod block;
#[cfg(all(target_os = "none", feature = "qemu"))]
pub mod board;
pub mod control;
pub mod drill;
pub mod link;
pub mod observing;
pub mod parameters;
mod payload;
pub mod replay;
pub mod rtt;
pub mod samples;
pub mod session;
pub mod six_step;
#[cfg(any(feature = "stm32g431", feature = "stm32f405"))]
pub mod stm32;
