//! joint-core's observer in someone else's firmware.
//!
//! What the programs for RTIC and embassy share: the joint as `joint export --format rust` writes it
//! ([`joint`]), and the one call of the control period around it ([`estimator`]). joint-core is the
//! only thing of this project that they depend on.

#![cfg_attr(target_os = "none", no_std)]

pub mod estimator;
// Written by `joint export`; `host-harness/tests/drive.rs` says when it is out of date.
#[rustfmt::skip]
pub mod joint;
pub mod stand_in;

/// Control periods between two reports: 1 kHz at 20 kHz.
pub const REPORT_EVERY: u32 = 20;

/// What a product does instead is its own decision; these stop, with every output still off.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
