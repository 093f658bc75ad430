//! Why there is no answer at all.

use crate::estimate::record::JoinError;
use crate::plant::BuildError;
use crate::preflight::LEAST_SAMPLES;

/// Why there is no answer.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DiscoverError {
    /// The model cannot be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The logs do not fit together.
    #[error(transparent)]
    Join(#[from] JoinError),
    /// Another record imposes something else.
    #[error(
        "a record for transfer is driven by another quantity than the logs: all need u_v, or none"
    )]
    Elsewhere,
    /// Too little to learn from.
    #[error("the logs have {0} samples; give at least {LEAST_SAMPLES}")]
    Short(usize),
}
