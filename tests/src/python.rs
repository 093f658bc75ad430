//! A Python that has the modules a test compares with, which `JOINT_PYTHON` names; else the system's.

use std::ffi::OsString;
use std::process::Command;

/// A command that runs Python; `None` where `test` is to be skipped for want of a module.
///
/// # Panics
/// It is not there and `CI` is set.
pub fn with(module: &str, test: &str) -> Option<Command> {
    let python = std::env::var_os("JOINT_PYTHON").unwrap_or_else(|| OsString::from("python3"));
    let found = Command::new(&python).args(["-c", &format!("import {module}")]).output();
    match found.is_ok_and(|output| output.status.success()) {
        true => Some(Command::new(python)),
        false => {
            let python = python.to_string_lossy();
            crate::skip(test, &format!("{python} has no module {module}; ./check installs it"));
            None
        }
    }
}
