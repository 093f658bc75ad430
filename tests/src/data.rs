//! The folder of logs that `JOINT_DATA` names.

use std::path::PathBuf;

/// The folder; `None` where `test` is to be skipped.
///
/// `JOINT_DATA=none` skips in CI too, for a runner that has no access to the logs.
///
/// # Panics
/// The folder does not exist, or `CI` is set and `JOINT_DATA` is not.
pub fn folder(test: &str) -> Option<PathBuf> {
    match std::env::var_os("JOINT_DATA") {
        None => {
            crate::skip(test, "JOINT_DATA is not set");
            None
        }
        Some(path) if path == "none" => None,
        Some(path) => {
            let path = PathBuf::from(path);
            assert!(path.is_dir(), "JOINT_DATA is no folder: {}", path.display());
            Some(path)
        }
    }
}
