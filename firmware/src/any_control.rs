//! The control period of a joint whose number of stages its parameter block says.

use joint_core::telemetry::{Report, Sample, Status};

use crate::block::{Block, BlockError};
use crate::control::Control;
use crate::parameters::{Parameters, Sensing};

/// The joint in operation. The tag is its own, so that one that is not started is zero.
#[derive(Debug)]
#[repr(u8)]
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
    Three(Control<3>),
}

impl AnyControl {
    /// Reads a block in place: a joint is too large for a small stack to hold it twice. `standing`
    /// is set in every report.
    ///
    /// # Errors
    /// Why the block is refused; what stood here before goes on.
    pub fn read(&mut self, block: &Block<'_>, standing: Status) -> Result<(), BlockError> {
        match block.stages {
            0 => self.put(block, standing, Self::None),
            1 => self.put(block, standing, Self::One),
            2 => self.put(block, standing, Self::Two),
            3 => self.put(block, standing, Self::Three),
            more => Err(BlockError::Stages(more)),
        }
    }

    #[inline(never)]
    fn put<const N: usize>(
        &mut self,
        block: &Block<'_>,
        standing: Status,
        variant: fn(Control<N>) -> Self,
    ) -> Result<(), BlockError> {
        *self = variant(Control::new(Parameters::read(block)?, standing));
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
            Self::Three(control) => *control.sensing(),
        }
    }
}
