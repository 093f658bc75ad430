//! Helpers for tests that cross crates.
//!
//! Each test needs something a desktop may lack: an emulator, or a folder of logs. There it is
//! skipped and says so by name; where `CI` is set it fails instead, so that a green build never
//! means that nothing was looked at.

pub mod data;
pub mod drive;
pub mod elf;
pub mod python;
pub mod qemu;
pub mod random;

use std::io::Write;

/// Whether `CI` is set to anything but `false`.
pub fn in_ci() -> bool {
    std::env::var_os("CI").is_some_and(|value| !value.is_empty() && value != "false")
}

/// Says that `test` is skipped and why; past the test runner's capture, so that it is seen.
///
/// # Panics
/// Where `CI` is set: there nothing may be skipped.
fn skip(test: &str, missing: &str) {
    assert!(!in_ci(), "{test} cannot be skipped in CI: {missing}");
    // A closed stderr is no reason to fail.
    let _ = writeln!(std::io::stderr(), "skipped {test}: {missing}");
}
