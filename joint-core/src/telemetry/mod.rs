//! What leaves the drive while it runs, and what is kept until somebody asks.
//!
//! A control interrupt may not wait for a debugger, and what a debugger reads may have been
//! overwritten half way. So every message is a [`frame`] with a sequence number and a checksum: the
//! reader knows what it missed, and never believes a torn number. What is too much to send as it
//! happens is kept by [`capture`], at the full control rate, around the moment that matters.
//!
//! All of it works in place: no allocation, no panic, bounded by the constants below.

pub mod capture;
pub mod frame;
mod message;

pub use message::{
    CaptureHead, Command, Hello, MAX_SAMPLES, MAX_STAGES, Message, Mode, Quantities, Report,
    Sample, Status, Trigger,
};
