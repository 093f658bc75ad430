//! Six-step commutation: which phases conduct at a rotor angle, derived from the back-EMF.
//!
//! In each sixth of an electrical turn one phase's back-EMF is flat at +1 and another's at −1,
//! equations (4) to (7); current through these two makes torque `k_t i` whatever the angle, and the
//! third phase floats. The table is not typed in, it is read off the trapezoid.

/// What a half bridge does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leg {
    /// Both switches off.
    Float,
    /// Carries the current in.
    Source,
    /// Takes it out.
    Sink,
}

/// Sectors of an electrical turn.
pub const SECTORS: usize = 6;

/// Trapezoidal back-EMF f of a phase, in 24ths of a turn, times 2: flat for a third of a turn, with
/// ramps of a sixth in between. Phase A rises through zero at angle zero.
const fn trapezoid(at: i32) -> i32 {
    let at = at.rem_euclid(24);
    match at {
        0..=2 => at,
        3..=9 => 2,
        10..=14 => 12 - at,
        15..=21 => -2,
        _ => at - 24,
    }
}

/// Legs of the phases A, B and C in each sector, for torque in the positive direction. Sector k is
/// from 30° + 60° k on, electrical.
pub const TABLE: [[Leg; 3]; SECTORS] = {
    let mut table = [[Leg::Float; 3]; SECTORS];
    let mut sector = 0;
    while sector < SECTORS {
        // In the middle of the sector: 60° + 60° k is 4 + 4 k 24ths.
        let middle = 4 + 4 * sector as i32;
        let mut phase = 0;
        while phase < 3 {
            // B lags by a third of a turn and C by two.
            table[sector][phase] = match trapezoid(middle - 8 * phase as i32) {
                2 => Leg::Source,
                -2 => Leg::Sink,
                _ => Leg::Float,
            };
            phase += 1;
        }
        sector += 1;
    }
    table
};

/// The sector at an electrical angle in counts, of `per_turn` counts to an electrical turn that
/// starts where the back-EMF of phase A rises through zero.
#[inline]
pub fn sector(counts: u32, per_turn: u32) -> usize {
    let per_turn = per_turn.max(1);
    // The first boundary lies at a twelfth of a turn.
    let twelfths = (counts % per_turn).wrapping_mul(12) / per_turn;
    (((twelfths + 11) / 2) % SECTORS as u32) as usize
}

/// The sector of three Hall sensors that are high where their phase's back-EMF is positive; `None`
/// where they say what no rotor position gives.
pub fn sector_of_halls(halls: [bool; 3]) -> Option<usize> {
    // Between 30° and 90° only A's is sure to be flat: its neighbours change sign in the middle,
    // so a sector of the sensors, 60° wide from 0° on, is told by all three.
    (0..SECTORS).find(|sector| {
        let middle = 2 + 4 * *sector as i32;
        let mut phase = 0;
        halls.iter().all(|high| {
            let positive = trapezoid(middle - 8 * phase) > 0;
            phase += 1;
            *high == positive
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_sector_drives_one_phase_against_another_and_floats_the_third() {
        for legs in TABLE {
            for kind in [Leg::Source, Leg::Sink, Leg::Float] {
                assert_eq!(legs.iter().filter(|leg| **leg == kind).count(), 1, "{legs:?}");
            }
        }
    }

    #[test]
    fn neighbouring_sectors_change_two_legs_and_opposite_ones_swap_the_current() {
        for sector in 0..SECTORS {
            let (here, next) = (TABLE[sector], TABLE[(sector + 1) % SECTORS]);
            assert_eq!(here.iter().zip(next).filter(|(a, b)| **a != *b).count(), 2);
            let swapped = here.map(|leg| match leg {
                Leg::Source => Leg::Sink,
                Leg::Sink => Leg::Source,
                Leg::Float => Leg::Float,
            });
            assert_eq!(TABLE[(sector + 3) % SECTORS], swapped);
        }
    }

    #[test]
    fn torque_is_k_t_i_at_every_angle_of_its_sector() {
        for count in 0..2_400 {
            let angle = 24.0 * f64::from(count) / 2_400.0;
            // The trapezoid between its corners.
            let f = |at: f64| {
                let low = at.floor();
                let (a, b) = (trapezoid(low as i32), trapezoid(low as i32 + 1));
                0.5 * (f64::from(a) + (at - low) * f64::from(b - a))
            };
            let legs = TABLE[sector(count, 2_400)];
            let mut torque = 0.0;
            for (phase, leg) in legs.into_iter().enumerate() {
                let current = match leg {
                    Leg::Source => 1.0,
                    Leg::Sink => -1.0,
                    Leg::Float => 0.0,
                };
                torque += current * f(angle - 8.0 * phase as f64);
            }
            assert!((torque - 2.0).abs() < 1e-12, "at {angle}: {torque}");
        }
    }

    #[test]
    fn halls_tell_six_sectors_and_refuse_the_two_impossible_ones() {
        let all = (0..8).map(|k| [k & 1 != 0, k & 2 != 0, k & 4 != 0]);
        let mut found: Vec<Option<usize>> = all.map(sector_of_halls).collect();
        assert_eq!((found[0], found[7]), (None, None));
        found.sort_unstable();
        assert_eq!(found[2..], [0, 1, 2, 3, 4, 5].map(Some));
    }
}
