//! A model for other programs: the drive's firmware, or another tool's simulator.
//!
//! What is found on the host is of use where the joint is. For the drive the model becomes the very
//! coefficients that the step runs with; for other simulators it becomes theirs, and what they
//! cannot express is said in the file and not left out in silence.

pub mod block;
pub mod fmu;
pub mod mjcf;
pub mod rust;
pub mod urdf;

use joint_core::joint::Drive;

use crate::model::Model;

/// What a drive's parameters need beside the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveOptions {
    /// Control period, s.
    pub period_s: f64,
    /// What the joint's model takes as its input.
    pub drive: Drive,
    /// Bus voltage, V: the largest that can be put on the motor.
    pub bus_v: f64,
    /// Largest current that its sensor can show, A.
    pub current_limit_a: f64,
}

/// Why a model cannot be exported.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ExportError {
    /// The joint has more stages than the firmware has room for.
    #[error("{0} stages: the firmware runs at most {most}", most = joint_core::telemetry::MAX_STAGES)]
    Stages(usize),
    /// A value that the equations cannot take with these options.
    #[error("{0}")]
    Parameter(String),
    /// The chip would refuse this coefficient.
    #[error(
        "the chip would refuse the coefficient {0}: it is no number in f32, or out of its range"
    )]
    Inadmissible(&'static str),
    /// The parameters do not fit into a flash page.
    #[error("the parameters do not fit into a flash page of {room} bytes: leave effects out", room = firmware::block::PAGE_BYTES)]
    Room,
    /// There is no shared library for an FMU.
    #[error("{0}")]
    Library(String),
}

/// The model's name as an identifier, for files that need one.
pub(crate) fn identifier(model: &Model) -> String {
    let mut name: String =
        model.name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if name.is_empty() || name.starts_with(|c: char| c.is_ascii_digit()) {
        name.insert(0, '_');
    }
    name
}
