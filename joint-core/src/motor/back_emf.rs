//! The trapezoidal shape of a phase's back-EMF, equation (5).
//!
//! `e = k_e ω f(θe)`, with f +1 for a third of a turn, −1 for a third, and ramps of a sixth between
//! them. Angles are electrical and in turns, so that wrapping is free. Phase a stands at θe, b at
//! θe − ⅓ and c at θe + ⅓.

use crate::scalar::Real;

/// How far phases b and c are displaced, turns.
pub const THIRD: f64 = 1.0 / 3.0;

/// f at any electrical angle in turns, exact; for tables that are made when the code is compiled.
pub const fn shape(turns: f64) -> f64 {
    // f is even about the middle of its positive flat at a sixth of a turn.
    let mut from_middle = turns - 1.0 / 6.0;
    let nearest = if from_middle < 0.0 { from_middle - 0.5 } else { from_middle + 0.5 };
    from_middle -= nearest as i64 as f64;
    let value = 3.0 - 12.0 * from_middle.abs();
    value.clamp(-1.0, 1.0)
}

/// f of the phases a, b and c at an electrical angle in turns, −½ to ½.
#[inline]
pub fn of_phases<S: Real>(turns: S) -> [S; 3] {
    let third = S::from_f64(THIRD);
    let [(_, b), (_, c)] = [(turns - third).split_turns(), (turns + third).split_turns()];
    [of_phase(turns), of_phase(b), of_phase(c)]
}

/// f at an electrical angle in turns, −½ to ½.
#[inline]
pub fn of_phase<S: Real>(turns: S) -> S {
    let quarter = S::HALF * S::HALF;
    let (_, from_middle) = (turns - S::from_f64(1.0 / 6.0)).split_turns();
    let ramp = quarter - from_middle.abs();
    let edge = S::from_f64(1.0 / 12.0);
    if ramp > edge {
        S::ONE
    } else if ramp < -edge {
        -S::ONE
    } else {
        ramp.times(S::gain(12.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's four branches, with the angle in radians and not wrapped.
    fn printed(angle: f64) -> f64 {
        use core::f64::consts::{PI, TAU};
        let angle = angle.rem_euclid(TAU);
        if angle <= 2.0 * PI / 3.0 {
            1.0
        } else if angle <= PI {
            1.0 - 6.0 * (angle - 2.0 * PI / 3.0) / PI
        } else if angle <= 5.0 * PI / 3.0 {
            -1.0
        } else {
            -1.0 + 6.0 * (angle - 5.0 * PI / 3.0) / PI
        }
    }

    #[test]
    fn the_shape_is_the_printed_one_at_any_angle() {
        for k in -5000..5000 {
            let turns = f64::from(k) / 997.0;
            assert!((shape(turns) - printed(turns * core::f64::consts::TAU)).abs() < 1e-12);
        }
    }

    #[test]
    fn the_step_s_shape_is_the_exact_one() {
        for k in -1000..=1000 {
            let turns = f64::from(k) / 2000.0;
            for (phase, shift) in of_phases(turns).into_iter().zip([0.0, -THIRD, THIRD]) {
                assert!((phase - shape(turns + shift)).abs() < 1e-12, "at {turns}");
            }
            for (narrow, wide) in of_phases(turns as f32).into_iter().zip(of_phases(turns)) {
                assert!((f64::from(narrow) - wide).abs() < 3e-6, "at {turns}");
            }
        }
    }
}
