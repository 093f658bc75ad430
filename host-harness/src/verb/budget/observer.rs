//! The observer of the assumed joint as the emulated chip reads it.

use firmware::block;
use firmware::observing::{fixed_to_bytes, to_bytes};
use joint_core::fixed::Fixed;
use joint_core::scalar::Real;

use crate::observe::counted;
use crate::verb::Failure;

/// Room for a block.
const BLOCK_BYTES: usize = 8192;

/// The observer as a block, and the log that it is run over.
pub(super) fn files() -> Result<[Vec<u8>; 2], Failure> {
    let seen = counted::log().map_err(failed)?;
    let records = seen.iter().flat_map(|seen| to_bytes(&counted::sample(seen))).collect();
    Ok([parameters::<f32>()?, records])
}

/// The same for a chip without floats.
pub(super) fn fixed_files() -> Result<[Vec<u8>; 2], Failure> {
    let seen = counted::log().map_err(failed)?;
    let records = seen.iter().flat_map(|seen| fixed_to_bytes(&counted::sample(seen))).collect();
    Ok([parameters::<Fixed>()?, records])
}

fn parameters<S: Real>() -> Result<Vec<u8>, Failure> {
    let observer = counted::observer::<S>().map_err(failed)?;
    let mut parameters = vec![0; BLOCK_BYTES];
    let length = block::encode(&observer, 2, &mut parameters).map_err(failed)?;
    parameters.truncate(length);
    Ok(parameters)
}

fn failed(error: impl std::fmt::Display) -> Failure {
    Failure::check(error.to_string())
}
