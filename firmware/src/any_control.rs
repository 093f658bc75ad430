//! The control period of a joint whose number of stages its parameter block says.

use joint_core::telemetry::{Report, Sample, Status};

use crate::block::{Block, BlockError};
use crate::control::Control;
use crate::parameters::Sensing;

/// The joint in operation. The tag is its own, so that one that is not started is zero.
#[derive(Debug)]
#[repr(u8)]
#[expect(clippy::large_enum_variant, reason = "there is no heap to put it into")]
pub enum AnyControl {
    /// Not yet started: reports nothing but zeros.
    NotStarted,
    /// A direct drive.
    None(Control<0>),
    /// One stage.
    One(Control<1>),
    /// Two stages.
    Two(Control<2>),
    /// Three stages.
    #[cfg(feature = "three-stages")]
    Three(Control<3>),
}

impl AnyControl {
    /// Reads a block in place: an observer is too large for a small stack to hold it twice.
    /// `standing` is set in every report.
    ///
    /// # Errors
    /// Why the block is refused; there is no observer then.
    pub fn read(&mut self, block: &Block<'_>, standing: Status) -> Result<(), BlockError> {
        self.make_room(block.stages)?;
        match self {
            Self::NotStarted => Ok(()),
            Self::None(control) => control.read(block, standing),
            Self::One(control) => control.read(block, standing),
            Self::Two(control) => control.read(block, standing),
            #[cfg(feature = "three-stages")]
            Self::Three(control) => control.read(block, standing),
        }
    }

    #[inline(never)]
    fn make_room(&mut self, stages: u8) -> Result<(), BlockError> {
        match stages {
            0 => *self = Self::None(Control::empty()),
            1 => *self = Self::One(Control::empty()),
            2 => *self = Self::Two(Control::empty()),
            #[cfg(feature = "three-stages")]
            3 => *self = Self::Three(Control::empty()),
            more => return Err(BlockError::Stages(more)),
        }
        Ok(())
    }

    /// Advances by one control period; `missed` were lost before it.
    #[inline]
    pub fn tick(&mut self, sample: Sample, missed: u32) -> Report {
        match self {
            Self::NotStarted => Report::default(),
            Self::None(control) => control.tick(sample, missed),
            Self::One(control) => control.tick(sample, missed),
            Self::Two(control) => control.tick(sample, missed),
            #[cfg(feature = "three-stages")]
            Self::Three(control) => control.tick(sample, missed),
        }
    }

    /// The sensors.
    pub fn sensing(&self) -> Sensing {
        match self {
            Self::NotStarted => Sensing::default(),
            Self::None(control) => *control.sensing(),
            Self::One(control) => *control.sensing(),
            Self::Two(control) => *control.sensing(),
            #[cfg(feature = "three-stages")]
            Self::Three(control) => *control.sensing(),
        }
    }
}
