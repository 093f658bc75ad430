//! One control period: a measurement in, a report out.
//!
//! This is all that the control interrupt runs, on every board, in the emulator and on the host;
//! it asks no register and keeps no time. A measurement that its sensor cannot have shown is kept
//! from the observer and flagged; what the observer itself doubts stands in the report's health.

use joint_core::observer::{self, Encoder, Track};
use joint_core::telemetry::{Quantities, Report, Sample, Status};

use crate::admissible;
use crate::block::{self, Block, BlockError};
use crate::parameters::{DriveObserver, Sensing};

/// Most missed periods that the model makes good; after more the observer starts anew by itself.
const MOST_MISSED: u32 = 8;

/// The observer of a joint of `N` stages as it runs in the drive.
#[derive(Debug)]
pub struct Control<const N: usize> {
    observer: Option<DriveObserver<N>>,
    track: Option<Track<f32, N>>,
    sensing: Sensing,
    motor: Option<Encoder>,
    output: Option<Encoder>,
    standing: Status,
    tick: u32,
    last: Option<Sample>,
}

impl<const N: usize> Control<N> {
    /// A place for an observer: it reports nothing but zeros.
    #[inline(always)]
    pub fn empty() -> Self {
        // No constant: that would be a copy of the whole place in flash.
        Self {
            observer: None,
            track: None,
            sensing: Sensing::DEFAULT,
            motor: None,
            output: None,
            standing: Status(0),
            tick: 0,
            last: None,
        }
    }

    /// Reads the parameters of a block of any known version, in place, checks them, and starts;
    /// `standing` is set in every report.
    ///
    /// # Errors
    /// The payload does not fit, or holds a value that the equations cannot take.
    #[inline(never)]
    pub fn read(&mut self, block: &Block<'_>, standing: Status) -> Result<(), BlockError> {
        let read = self.parts(block);
        if read.is_err() {
            self.observer = None;
        }
        let Some(observer) = &self.observer else { return read };
        let encoder = |counts: u32| i32::try_from(counts).ok().and_then(Encoder::new);
        self.motor = encoder(self.sensing.motor_counts_per_turn);
        self.output = encoder(self.sensing.output_counts_per_turn);
        self.track = Some(observer.start(0));
        self.standing = standing;
        Ok(())
    }

    fn parts(&mut self, block: &Block<'_>) -> Result<(), BlockError> {
        if usize::from(block.stages) != N {
            return Err(BlockError::Stages(block.stages));
        }
        let rest = block.take_into(&mut self.observer)?;
        let has_effects = self.observer.as_ref().is_some_and(|it| !it.joint.effects().is_empty());
        if has_effects && block.version < block::EFFECTS_SINCE {
            return Err(BlockError::Effects(block.version));
        }
        self.sensing = match block.version {
            1 => Sensing::DEFAULT,
            _ => block::last(rest)?,
        };
        admissible::check(&self.observer)
            .and_then(|()| admissible::check(&self.sensing))
            .map_err(BlockError::Inadmissible)
    }

    /// The sensors.
    pub fn sensing(&self) -> &Sensing {
        &self.sensing
    }

    /// Advances by one control period; `missed` were lost before it.
    #[inline]
    pub fn tick(&mut self, sample: Sample, missed: u32) -> Report {
        let mut status = self.standing;
        if missed > 0 {
            status = status.with(Status::LATE);
            self.bridge(missed);
        }
        let seen = self.seen(sample, &mut status);
        let (Some(observer), Some(track)) = (&self.observer, &mut self.track) else {
            return Report::default();
        };
        let health = observer.update(track, &seen);
        let estimate = observer.estimate(track);
        self.last = Some(sample);
        self.tick = self.tick.wrapping_add(missed);
        let report = Report {
            tick: self.tick,
            status,
            health: health.bits(),
            stages: N as u8,
            sample,
            estimates: Quantities::of(&estimate),
            deviations: Quantities::deviations_of(&estimate),
        };
        self.tick = self.tick.wrapping_add(1);
        report
    }

    /// Periods without a measurement, the drive held.
    #[inline(never)]
    fn bridge(&mut self, missed: u32) {
        let drive = self.last.map_or(0.0, |last| self.drive(last));
        let (Some(observer), Some(track)) = (&self.observer, &mut self.track) else { return };
        for _ in 0..missed.min(MOST_MISSED) {
            let nothing = observer::Sample { drive, ..observer::Sample::default() };
            observer.update(track, &nothing);
        }
    }

    fn drive(&self, sample: Sample) -> f32 {
        match self.is_current_imposed() {
            // A sensor at its end says nothing of the current, so that the last one is held.
            true if !within(sample.current_a, self.sensing.largest_current_a) => f32::NAN,
            true => sample.current_a,
            false => sample.voltage_v,
        }
    }

    fn is_current_imposed(&self) -> bool {
        self.observer.as_ref().is_some_and(|observer| observer.joint.is_current_imposed())
    }

    /// The sample as the observer takes it, less what no sensor can have shown.
    fn seen(&self, sample: Sample, status: &mut Status) -> observer::Sample<f32> {
        let current = within(sample.current_a, self.sensing.largest_current_a);
        let voltage = within(sample.voltage_v, self.sensing.largest_voltage_v);
        // In torque mode nobody asks for the voltage.
        if !current || !voltage && !self.is_current_imposed() {
            *status = status.with(Status::MEASUREMENT);
        }
        if let Some(last) = self.last {
            let moved = sample.motor_counts.wrapping_sub(last.motor_counts).unsigned_abs();
            if moved > self.sensing.largest_move_counts {
                *status = status.with(Status::ENCODER_JUMP);
            }
        }
        observer::Sample {
            drive: self.drive(sample),
            current: current.then_some(sample.current_a),
            motor: self.motor.map(|encoder| encoder.turn(sample.motor_counts)),
            output: self.output.map(|encoder| encoder.turn(sample.output_counts)),
        }
    }
}

/// Whether a measurement is within its sensor's limit; what is no number is within none.
fn within(value: f32, limit: f32) -> bool {
    value.abs() <= limit
}
