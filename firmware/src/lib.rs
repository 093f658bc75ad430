//! What the boards share: the parameter block, the replay, and the board itself.
//!
//! [`block`], [`samples`] and [`replay`] compile on the host too, so whoever writes a block or
//! checks the states of a replay uses the very code that runs on the chip. `board` exists on the
//! chip alone and holds every `unsafe` line of the workspace.

#![cfg_attr(target_os = "none", no_std)]

pub mod block;
#[cfg(target_os = "none")]
pub mod board;
pub mod observing;
pub mod replay;
pub mod samples;
