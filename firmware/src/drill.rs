//! A run in whole numbers that a chip and its host go through alike: reversals, stick and a load.

use joint_core::fixed::Fixed;

/// Steps of the run.
pub const STEPS: u32 = 4000;
/// Steps between two changes of the voltage.
const REVERSAL: u32 = 500;
/// One in a fixed-point number.
const ONE: i32 = 1 << 26;

/// Voltage, V, and load, Nm, of a step.
pub fn input(step: u32) -> (Fixed, Fixed) {
    let volts = match step / REVERSAL % 4 {
        0 => 6 * ONE,
        1 => 0,
        2 => -6 * ONE,
        _ => ONE / 2,
    };
    (Fixed::from_bits(volts), Fixed::from_bits(ONE / 200))
}
