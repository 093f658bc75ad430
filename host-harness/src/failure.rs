//! That a run has failed, with its exit code.

use crate::fault::InputError;

/// Why a verb could not be done.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Failure {
    /// Exit code: 1 a bound or check failed, 2 bad input or usage.
    pub code: u8,
    /// What is wrong, where, and what to do.
    pub message: String,
}

impl Failure {
    /// Bad input or usage.
    pub fn input(message: impl Into<String>) -> Self {
        Self { code: 2, message: message.into() }
    }

    /// A bound or check that failed.
    pub fn check(message: impl Into<String>) -> Self {
        Self { code: 1, message: message.into() }
    }
}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        Self::input(error.to_string())
    }
}
