//! Falling functions as straight lines between points: a third of the instructions of a polynomial of the
//! same use, and near enough for a format that is held to 2 %.

use super::UNIT;

/// Lines of a table.
const LINES: usize = 256;

/// The lines of a function, each as one word: its upper 16 bits are the start, its lower ones by how much
/// the line falls, in units of the word's 2¹². The start is chosen so that the whole word is nearest to it.
pub(super) struct Lines<const WIDTH: u32>([u32; LINES]);

/// exp(−s/2) in units of 2⁻³⁰, by lines of an eighth of `s`.
pub(super) static EXPONENTIAL: Lines<23> = Lines(exponential());
/// What a bristle relaxes of its way over its reach, (1 − exp(−x))/x, by lines of a 32nd, in units of 2⁻³¹.
pub(super) static RELAXATION: Lines<21> = Lines(relaxation());

impl<const WIDTH: u32> Lines<WIDTH> {
    /// The value at bits from zero to below 2^WIDTH times the number of lines.
    #[inline(always)]
    pub(super) fn at(&self, bits: i32) -> u32 {
        let bits = bits as u32;
        let line = (bits >> WIDTH) as usize & (LINES - 1);
        let start = self.0.get(line).copied().unwrap_or_default();
        let (fall, part) = (start << 16, bits << (32 - WIDTH));
        start - (((u64::from(fall) * u64::from(part)) >> 32) as u32 >> 4)
    }
}

/// A line from `start` to `end`, given in units of one, as a word in units of 2^−`places`.
const fn line(start: f64, end: f64, places: u32) -> u32 {
    let unit = (1_u64 << places) as f64;
    let fall = ((start - end) * unit / 4096.0 + 0.5) as u32;
    (((start * unit) as u32 + (1 << 15) - fall) & !0xffff) + fall
}

const fn exponential() -> [u32; LINES] {
    /// exp(−1/16).
    const RATIO: f64 = 0.939_413_062_813_475_8;
    let (mut lines, mut start) = ([0; LINES], 1.0);
    let mut left: &mut [u32] = &mut lines;
    while let [word, rest @ ..] = left {
        let end = start * RATIO;
        *word = line(start, end, 30);
        (start, left) = (end, rest);
    }
    lines
}

const fn relaxation() -> [u32; LINES] {
    const WIDTH: f64 = (1 << 21) as f64 / UNIT as f64;
    /// exp(−1/32).
    const RATIO: f64 = 0.969_233_234_476_344_1;
    let (mut lines, mut start, mut remaining, mut x) = ([0; LINES], 1.0, 1.0, 0.0);
    let mut left: &mut [u32] = &mut lines;
    while let [word, rest @ ..] = left {
        x += WIDTH;
        remaining *= RATIO;
        // From the last line's end on, the bristle has relaxed.
        let end = if rest.is_empty() { 1.0 / x } else { (1.0 - remaining) / x };
        *word = line(start, end, 31);
        (start, left) = (end, rest);
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixed::Fixed;
    use crate::number::Number;

    #[test]
    fn straight_lines_keep_their_stated_error() {
        for k in 0..=31_999 {
            let square = Fixed::from_f64(f64::from(k) * 1e-3);
            let exact = (-0.5 * square.to_f64()).exp();
            let found = f64::from(EXPONENTIAL.at(square.to_bits())) / f64::from(1 << 30);
            assert!((found - exact).abs() < 5e-4, "at {square}: {found}");
        }
        for k in 0..7_900 {
            let reach = Fixed::from_f64(f64::from(k) * 1e-3);
            let x = reach.to_f64().max(1e-9);
            let exact = -(-x).exp_m1() / x;
            let found = f64::from(RELAXATION.at(reach.to_bits())) / f64::from(1_u32 << 31);
            assert!((found - exact).abs() < 6e-5, "at {reach}: {found} {exact}");
        }
    }
}
