//! Friction that gives way below breakaway: a torque that passes standstill smoothly.
//!
//! The bristle relaxes at `r(v) = v coth(v/w)` in the place of |v|, so that friction in slip is
//! `g(v) tanh(v/w)`: a torque below g lets the mass creep at a speed below w. Source: Armstrong-Hélouvry, Dupont,
//! Canudas de Wit, Automatica 30 (1994), with the sign made smooth as in Makkar et al., Proc. IEEE/ASME AIM (2005).

use crate::batch::batch;
use crate::number::Number;

/// The speed below which friction creeps, in units of the speed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct Creep<S: Number> {
    /// One over w.
    per_speed: S::Gain,
    /// w.
    speed: S,
    /// Where the law ends.
    end: S,
}

batch!(Creep<Number>: per_speed, speed, end);

/// Least w: fixed point has to tell it from zero.
const LEAST: f64 = 1e-6;
/// Where the law ends, in w: there tanh is within 0.9 % of one, and r keeps its distance from |v|.
const END: f64 = 2.75;
/// Of x⁴, with what the series goes on by: tanh is within 1 %.
const LAST: f64 = 0.22;

impl<S: Number> Creep<S> {
    /// Of w in units of the speed.
    pub fn new(speed: f64) -> Self {
        let speed = libm::fabs(speed).max(LEAST);
        Self {
            per_speed: S::gain(1.0 / speed),
            speed: S::from_f64(speed),
            end: S::from_f64(END * speed),
        }
    }

    /// r at a speed, and its slope over |v|. Of x coth x − x = 2x/(exp(2x) − 1) the series below is taken.
    #[inline(always)]
    pub fn rate(&self, speed: S) -> (S, S) {
        let magnitude = speed.abs();
        let inside = magnitude.below(self.end);
        let x = S::choose(inside, magnitude, self.end).times(self.per_speed);
        let (third, last) = (S::from_f64(1.0 / 3.0), S::from_f64(LAST));
        let series = S::ONE + x * (S::ONE + x * (third + third + x * (third + x * last)));
        let cubic = S::ONE + x * S::from_f64(4.0 * LAST);
        let rise = S::ONE + x * (S::ONE + third + x * cubic);
        let left = S::ONE.over(series);
        let slope = S::ONE - left * (left * rise);
        (magnitude + self.speed * left, S::choose(inside, slope, S::ONE))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixed::Fixed;

    #[test]
    fn friction_in_slip_is_the_hyperbolic_tangent() {
        let creep = Creep::<f64>::new(0.2);
        for k in 1..200 {
            let speed = 0.01 * f64::from(k);
            let (rate, slope) = creep.rate(-speed);
            let error = speed / rate - (speed / 0.2).tanh();
            assert!(error.abs() < 1e-2, "{speed}: {error}");
            let [fast, slow] = [1e-6, -1e-6].map(|more| creep.rate(speed + more).0);
            assert!((slope - (fast - slow) / 2e-6).abs() < 1e-6 || (speed - 0.55).abs() < 1e-5);
        }
        assert_eq!(creep.rate(0.0), (0.2, 0.0));
    }

    #[test]
    fn fixed_point_finds_the_same_at_every_speed() {
        for width in [0.0, 1e-3, 0.7, 5.0] {
            let (exact, fixed) = (Creep::<f64>::new(width), Creep::<Fixed>::new(width));
            for speed in [0.0, 1e-4, 0.03, -0.4, 2.0, -15.0] {
                let (rate, slope) = exact.rate(speed);
                let found = fixed.rate(Fixed::from_f64(speed));
                let [one, other] = [found.0.to_f64() - rate, found.1.to_f64() - slope];
                // A dozen roundings of 2⁻²⁶, and the constants' of 2⁻¹⁶.
                let bound = 2e-5 * (1.0 + width);
                assert!(one.abs() < bound && other.abs() < bound, "{width} {speed}: {one} {other}");
            }
        }
    }
}
