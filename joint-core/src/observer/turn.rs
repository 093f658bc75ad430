//! Angles from counts, without losing resolution over any number of turns.
//!
//! What an encoder shows only matters modulo a turn: the observer knows the rest. A turn is 2³²
//! parts of an unsigned integer, which wraps for free, and the angle behind a gear is found from the
//! rotor's whole turns by a product that is exact modulo a turn of the output.

/// An angle modulo a turn, in 2⁻³² turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Turn(pub u32);

impl Turn {
    /// From an angle in turns; not for the hot path.
    pub fn from_turns(turns: f64) -> Self {
        let part = turns - libm::floor(turns);
        // Rounding up to a whole turn is the turn's beginning.
        Self((part * 4_294_967_296.0) as u64 as u32)
    }

    /// By how much this angle is ahead of another, the short way round.
    #[inline(always)]
    pub fn ahead_of(self, other: Turn) -> i32 {
        self.0.wrapping_sub(other.0) as i32
    }
}

/// An encoder, hall sensors included: so many counts in a turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Encoder {
    per_turn: i32,
    /// A count in 2⁻⁶⁴ turns.
    count: u64,
}

impl Encoder {
    /// With `counts` in a turn; `None` for fewer than two.
    pub fn new(counts: i32) -> Option<Self> {
        if counts < 2 {
            return None;
        }
        Some(Self { per_turn: counts, count: u64::MAX / counts.unsigned_abs() as u64 + 1 })
    }

    /// The angle of a position counted over any number of turns.
    #[inline]
    pub fn turn(&self, count: i32) -> Turn {
        let part = count.checked_rem_euclid(self.per_turn).unwrap_or(0);
        Turn(((part as u64).wrapping_mul(self.count) >> 32) as u32)
    }
}

/// The angle of a shaft from the motor's whole turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Geared {
    /// Turns of the shaft in a turn of the rotor: whole ones,
    whole: i32,
    /// and the rest in 2⁻⁶⁴ turns.
    part: u64,
}

impl Geared {
    /// From the shaft's turns in a turn of the rotor, negative where it reverses.
    pub fn new(ratio: f64) -> Self {
        let whole = libm::floor(ratio);
        Self { whole: whole as i32, part: ((ratio - whole) * 18_446_744_073_709_551_616.0) as u64 }
    }

    /// The shaft's angle when the rotor has made that many whole turns.
    #[inline]
    pub fn turn(&self, rotor_turns: i32) -> Turn {
        Turn(((i64::from(rotor_turns) as u64).wrapping_mul(self.part) >> 32) as u32)
    }

    /// The same with the shaft's own whole turns; not for the hot path.
    pub fn turns(&self, rotor_turns: i32) -> (i32, Turn) {
        let product = i128::from(rotor_turns) * i128::from(self.part);
        let whole = i64::from(rotor_turns) * i64::from(self.whole) + (product >> 64) as i64;
        (whole as i32, self.turn(rotor_turns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_give_the_same_angle_in_every_turn() {
        let encoder = Encoder::new(3000).unwrap();
        for turn in [-700_000, -1, 0, 1, 12_345, 700_000] {
            for part in [0, 1, 750, 1499, 2999] {
                let exact = f64::from(part) / 3000.0;
                let found = f64::from(encoder.turn(turn * 3000 + part).0) / 4_294_967_296.0;
                assert!((found - exact).abs() < 3e-10, "{turn} {part}: {found} {exact}");
            }
        }
        assert_eq!(Encoder::new(1), None);
    }

    #[test]
    fn the_output_is_known_to_a_millionth_of_a_turn_after_two_billion_of_the_rotor() {
        for ratio in [1.0 / 1024.0, -1.0 / 125.0, 1.0 / 16.0, 1.0 / 3.0, 1.0] {
            let geared = Geared::new(ratio);
            for turns in [0, 1, -1, 999, -70_001, 2_000_000_003] {
                let exact = f64::from(turns) * ratio;
                let (whole, part) = geared.turns(turns);
                let found = f64::from(whole) + f64::from(part.0) / 4_294_967_296.0;
                assert!((found - exact).abs() < 1e-6, "{ratio} {turns}: {found} {exact}");
            }
        }
    }
}
