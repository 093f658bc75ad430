//! The observer over a log, on the host and on the chip alike.
//!
//! A record is five little-endian words: applied voltage and current (f32, NaN where missing), rotor
//! and output angle in 2⁻³² turns, and flags that say which of the two are there. A row of
//! estimates is f32 throughout.

use joint_core::fixed::Fixed;
use joint_core::observer::{Estimate, Observer, Sample, Turn};

/// Bytes of one record.
pub const RECORD_BYTES: usize = 20;
/// Flag of a rotor angle.
const MOTOR: u32 = 1;
/// Flag of an output angle.
const OUTPUT: u32 = 2;

/// Numbers in a row of estimates of a joint with that many stages.
pub const fn row_numbers(stages: usize) -> usize {
    8 + 2 * stages
}

/// As it stands in the file.
pub fn to_bytes(sample: &Sample<f32>) -> [u8; RECORD_BYTES] {
    let flags = if sample.motor.is_some() { MOTOR } else { 0 }
        | if sample.output.is_some() { OUTPUT } else { 0 };
    let words = [
        sample.drive.to_bits(),
        sample.current.unwrap_or(f32::NAN).to_bits(),
        sample.motor.unwrap_or_default().0,
        sample.output.unwrap_or_default().0,
        flags,
    ];
    let mut bytes = [0; RECORD_BYTES];
    for (slot, word) in bytes.as_chunks_mut::<4>().0.iter_mut().zip(words) {
        *slot = word.to_le_bytes();
    }
    bytes
}

/// From the file.
pub fn from_bytes(bytes: &[u8; RECORD_BYTES]) -> Sample<f32> {
    let mut words = [0; 5];
    for (word, slot) in words.iter_mut().zip(bytes.as_chunks::<4>().0) {
        *word = u32::from_le_bytes(*slot);
    }
    let [drive, current, motor, output, flags] = words;
    let current = f32::from_bits(current);
    Sample {
        drive: f32::from_bits(drive),
        current: (!current.is_nan()).then_some(current),
        motor: (flags & MOTOR != 0).then_some(Turn(motor)),
        output: (flags & OUTPUT != 0).then_some(Turn(output)),
    }
}

/// Hands over a row: motor speed, friction, output turns, part of a turn and speed, load, its
/// deviation, status; then friction and wind-up of every stage.
///
/// # Errors
/// The first that `put` returns.
pub fn row<const N: usize, Error>(
    estimate: &Estimate<f32, N>,
    mut put: impl FnMut(f32) -> Result<(), Error>,
) -> Result<(), Error> {
    put(estimate.motor_velocity)?;
    put(estimate.total_friction)?;
    put(estimate.output_turns as f32)?;
    put(estimate.output_part)?;
    put(estimate.output_velocity)?;
    put(estimate.load)?;
    put(estimate.spread.load)?;
    put(f32::from(estimate.status.bits()))?;
    for (friction, windup) in estimate.stage_friction.iter().zip(&estimate.windup) {
        put(*friction)?;
        put(*windup)?;
    }
    Ok(())
}

/// The observer that is run: a joint without effects.
pub type Observing<const N: usize> = Observer<f32, N>;

/// Flag of a current, in a record of fixed point.
const CURRENT: u32 = 4;

/// As it stands in a file for a chip without floats: voltage and current as their bits.
pub fn fixed_to_bytes(sample: &Sample<Fixed>) -> [u8; RECORD_BYTES] {
    let flag = |there: bool, flag: u32| if there { flag } else { 0 };
    let words = [
        sample.drive.to_bits() as u32,
        sample.current.unwrap_or_default().to_bits() as u32,
        sample.motor.unwrap_or_default().0,
        sample.output.unwrap_or_default().0,
        flag(sample.motor.is_some(), MOTOR)
            | flag(sample.output.is_some(), OUTPUT)
            | flag(sample.current.is_some(), CURRENT),
    ];
    let mut bytes = [0; RECORD_BYTES];
    for (slot, word) in bytes.as_chunks_mut::<4>().0.iter_mut().zip(words) {
        *slot = word.to_le_bytes();
    }
    bytes
}

/// From that file.
pub fn fixed_from_bytes(bytes: &[u8; RECORD_BYTES]) -> Sample<Fixed> {
    let mut words = [0; 5];
    for (word, slot) in words.iter_mut().zip(bytes.as_chunks::<4>().0) {
        *word = u32::from_le_bytes(*slot);
    }
    let [drive, current, motor, output, flags] = words;
    Sample {
        drive: Fixed::from_bits(drive as i32),
        current: (flags & CURRENT != 0).then_some(Fixed::from_bits(current as i32)),
        motor: (flags & MOTOR != 0).then_some(Turn(motor)),
        output: (flags & OUTPUT != 0).then_some(Turn(output)),
    }
}

/// The bits of a reading in the joint's units: motor speed, friction, output turns, part of a turn
/// and speed, load, its deviation, status; then friction and wind-up of every stage.
pub fn fixed_row<const N: usize>(reading: &Estimate<Fixed, N>, mut put: impl FnMut(i32)) {
    put(reading.motor_velocity.to_bits());
    put(reading.total_friction.to_bits());
    put(reading.output_turns);
    put(reading.output_part.to_bits());
    put(reading.output_velocity.to_bits());
    put(reading.load.to_bits());
    put(reading.spread.load.to_bits());
    put(i32::from(reading.status.bits()));
    for (friction, windup) in reading.stage_friction.iter().zip(&reading.windup) {
        put(friction.to_bits());
        put(windup.to_bits());
    }
}
