//! A running drive seen from the host: its frames as a log, its capture as a log, its flash page.
//!
//! What comes from a drive is a stream of bytes, whether a debug probe read it just now or a file
//! holds it from yesterday; so everything but the probe itself works on streams, and is tested on
//! those that the emulated drive has written.

#[cfg(feature = "probe")]
pub mod board;
pub mod chip;
pub mod recording;
pub mod wire;

pub use chip::Chip;
pub use recording::Recording;
pub use wire::Wire;
