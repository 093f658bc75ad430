//! Six-step commutation: the table that follows from the back-EMF, and the hall sensors.
//!
//! In each sixth of an electrical turn one phase has its back-EMF at +1 and one at −1 all the way;
//! current through these two gives torque `k_t i` without ripple, and the third phase, on its ramp,
//! is left open. The table is derived from [`super::back_emf::shape`] when the code is compiled;
//! against motion, the same two phases carry current the other way.

use super::back_emf::{THIRD, shape};
use crate::scalar::Real;

/// A phase by its place in every array of three: a, b, c.
pub type Phase = usize;

/// What conducts in one sector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Conduction {
    /// The phase at f = +1: current flows in where the torque is positive.
    pub high: Phase,
    /// The phase at f = −1: current flows out.
    pub low: Phase,
    /// The phase on its ramp, left open.
    pub open: Phase,
    /// Hall sensors in this sector: bits 0, 1 and 2 are set where f of a is above that of b, b above
    /// c, c above a. Their edges are the zeros of the line-to-line EMF, which bound the sectors.
    pub hall: u8,
}

impl Conduction {
    /// The same phases with the torque turned round.
    #[must_use]
    pub const fn reversed(self) -> Self {
        Self { high: self.low, low: self.high, ..self }
    }
}

/// The six sectors of an electrical turn, from angle zero on.
pub const SECTORS: [Conduction; 6] = derive();

const fn derive() -> [Conduction; 6] {
    let mut table = [Conduction { high: 0, low: 0, open: 0, hall: 0 }; 6];
    let mut rest: &mut [Conduction] = &mut table;
    let mut middle = 1.0 / 12.0;
    while let [first, others @ ..] = rest {
        *first = conduction(middle);
        middle += 1.0 / 6.0;
        rest = others;
    }
    table
}

/// What conducts where f of the phases is +1, −1 and between, at an angle inside a sector.
const fn conduction(turns: f64) -> Conduction {
    let [a, b, c] = [shape(turns), shape(turns - THIRD), shape(turns + THIRD)];
    let high = if a >= 1.0 {
        0
    } else if b >= 1.0 {
        1
    } else {
        2
    };
    let low = if a <= -1.0 {
        0
    } else if b <= -1.0 {
        1
    } else {
        2
    };
    let hall = (a > b) as u8 | ((b > c) as u8) << 1 | ((c > a) as u8) << 2;
    Conduction { high, low, open: 3 - high - low, hall }
}

/// What the hall sensors show at an electrical angle in turns, −½ to ½.
#[inline]
pub fn hall<S: Real>(turns: S) -> u8 {
    let [sixth, third] = [S::from_f64(1.0 / 6.0), S::from_f64(THIRD)];
    let sector = if turns < S::ZERO {
        if turns < -third {
            3
        } else if turns < -sixth {
            4
        } else {
            5
        }
    } else if turns < sixth {
        0
    } else if turns < third {
        1
    } else {
        2
    };
    SECTORS.get(sector).map_or(0, |conduction| conduction.hall)
}

/// What conducts at this state of the hall sensors; `None` for the two states that no angle gives,
/// a broken sensor or wire.
#[inline]
pub fn from_hall(hall: u8) -> Option<Conduction> {
    SECTORS.iter().copied().find(|conduction| conduction.hall == hall)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_sector_differs_from_the_next_in_one_hall_bit_and_one_phase() {
        for (k, now) in SECTORS.iter().enumerate() {
            let next = &SECTORS[(k + 1) % 6];
            assert_eq!((now.hall ^ next.hall).count_ones(), 1);
            assert_eq!(
                u8::from(now.high != next.high) + u8::from(now.low != next.low),
                1,
                "sector {k}"
            );
            assert_eq!(from_hall(now.hall), Some(*now));
        }
        assert_eq!((from_hall(0), from_hall(7)), (None, None));
    }
}
