//! LuGre friction on one inertia, as a flow over half a step and a damping for the kicks.
//!
//! At a fixed speed the bristle relaxes exponentially towards its slip value, up to 10⁸ times a
//! second: far stiffer than the step, but a scalar with a closed solution, of which this takes the
//! Padé (0,2) approximant. It is exact in stick to second order, exact in the slip limit, and
//! stable at every step. Equations (2) and (3); symbols as there, with `ζ = σ0 z / α0` the bristle
//! torque in units of the Coulomb level and `ρ = α0 / g(v)`.

use crate::joint::Mass;
use crate::params;
use crate::scalar::Scalar;

/// Constants of one mass, per-unit and reflected to the motor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct Friction<S: Scalar> {
    /// 1/v0.
    per_stribeck_velocity: S::Gain,
    /// β = α1/α0.
    beta: S,
    /// κ = σ0 h / (2 α0): slip over half a step in units of the bristle's reach, per speed.
    kappa: S::Gain,
    /// α0, torque per ζ.
    level: S::Gain,
    /// σ0, torque per angle.
    stiffness: S::Gain,
    sigma1: S,
    sigma2: S,
}

/// A level g(v) of zero at standstill would leave ζ there undefined.
const LEAST_BETA: f64 = -1.0 + 1e-6;

/// The bristle of one mass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bristle<S> {
    /// ζ = σ0 z / α0: bristle torque over Coulomb level.
    pub zeta: S,
    /// χ = ż / v = 1 − sgn(v) ζ ρ at the end of the last flow: the share of the motion that bends
    /// the bristle.
    pub(crate) bending: S,
}

impl<S: Scalar> Friction<S> {
    /// From SI: `shaft` is the mass's ratio to the motor, `half_step` in seconds; `torque`, `speed`
    /// and `angle` are the units at the motor.
    pub(crate) fn new(
        friction: &params::Friction,
        shaft: f64,
        half_step: f64,
        [torque, speed, angle]: [f64; 3],
    ) -> Self {
        let shaft = libm::fabs(shaft);
        let alpha0 = friction.coulomb_nm * shaft;
        let sigma0 = friction.sigma0_nm_per_rad * shaft * shaft;
        let (beta, kappa) = if alpha0 > 0.0 {
            (friction.stribeck_nm / friction.coulomb_nm, sigma0 * half_step / alpha0)
        } else {
            (0.0, 0.0)
        };
        let damping = shaft * shaft * speed / torque;
        Self {
            per_stribeck_velocity: S::gain(speed * shaft / friction.stribeck_velocity_rad_per_s),
            beta: S::from_f64(beta.max(LEAST_BETA)),
            kappa: S::gain(kappa * speed),
            level: S::gain(alpha0 / torque),
            stiffness: S::gain(sigma0 * angle / torque),
            sigma1: S::from_f64(friction.sigma1_nm_s_per_rad * damping),
            sigma2: S::from_f64(friction.sigma2_nm_s_per_rad * damping),
        }
    }

    /// 1/ρ = g(v)/α0 = 1 + β exp(−(v/v0)²), equation (3).
    #[inline(always)]
    fn slip_level(&self, speed: S) -> S {
        S::ONE + self.beta * speed.times(self.per_stribeck_velocity).bell()
    }

    /// Finds what is kept beside ζ, after ζ or the speed was set from outside.
    pub(crate) fn settle(&self, mass: &mut Mass<S>, inverse_level: S) {
        let slip = mass.bristle.zeta.over(self.slip_level(mass.speed)) * inverse_level;
        mass.bristle.bending = bending(mass.speed, slip);
    }

    /// Moves a mass's bristle over half a step at its speed: with y = κ v, x = |y| ρ and a = 1 + x/2,
    /// `ζ ← (ζ + y a) / (1 + x a)`. Numerator and denominator are multiplied by 1/ρ², so that one
    /// division gives the new ζ ρ.
    #[inline(always)]
    pub(crate) fn flow(&self, mass: &mut Mass<S>) {
        let level = self.slip_level(mass.speed);
        let y = mass.speed.times(self.kappa);
        let reach = y.abs();
        let series = level + reach * S::HALF;
        let slip = (mass.bristle.zeta * level + y * series).over(level * level + reach * series);
        mass.bristle.zeta = slip * level;
        mass.bristle.bending = bending(mass.speed, slip);
    }

    /// Moves the bristle over half a step in which an effect's factor on g(v) changes; both
    /// `inverse_levels` are one over it, at the start and at the end.
    ///
    /// A level that follows a vibrating spring pumps or damps that vibration by the bristle's lag
    /// behind it, so the lag is part of the flow: for a level that changes evenly, the slip value
    /// that the bristle sees is the one at `w = 1/(1 − e^−x) − 1/x` of the way, here as a quotient
    /// of polynomials that is right at both ends.
    #[inline]
    pub(crate) fn flow_along(&self, mass: &mut Mass<S>, inverse_levels: [S; 2]) {
        let [start, end] = inverse_levels;
        let plain = self.slip_level(mass.speed);
        let rho = S::ONE.over(plain);
        let reach = mass.speed.times(self.kappa);
        let decay = reach.abs() * rho * (start + end) * S::HALF;
        let three = S::ONE + S::ONE + S::ONE;
        let square = decay * decay;
        let (above, below) = (
            three + three + three * decay + square,
            square + decay + three * (three + decay + S::ONE),
        );
        let way = above.over(below);
        let (first, last) = (S::ONE.over(start), S::ONE.over(end));
        let target = (first + (last - first) * way) * plain;
        let target = if mass.speed < S::ZERO { -target } else { target };
        let series = decay * (S::ONE + decay * S::HALF);
        let zeta = (mass.bristle.zeta + series * target).over(S::ONE + series);
        mass.bristle.zeta = zeta;
        mass.bristle.bending = bending(mass.speed, zeta * rho * end);
    }

    /// Bristle torque σ0 z.
    #[inline(always)]
    pub(crate) fn torque(&self, bristle: &Bristle<S>) -> S {
        bristle.zeta.times(self.level)
    }

    /// Damping c = σ1 χ + σ2, the torque per speed beside the bristle torque.
    #[inline(always)]
    pub(crate) fn damping(&self, bristle: &Bristle<S>, viscous: S) -> S {
        self.sigma1 * bristle.bending + self.sigma2 * viscous
    }

    /// Change of the bristle torque with the angle: σ0 χ.
    #[inline(always)]
    pub(crate) fn slope(&self, bristle: &Bristle<S>) -> S {
        bristle.bending.times(self.stiffness)
    }
}

/// χ = 1 − sgn(v) ζ ρ, from ζ ρ.
#[inline(always)]
fn bending<S: Scalar>(speed: S, slip: S) -> S {
    if speed < S::ZERO { S::ONE + slip } else { S::ONE - slip }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn friction(stribeck_nm: f64) -> Friction<f64> {
        let friction = params::Friction {
            sigma0_nm_per_rad: 3.0,
            coulomb_nm: 0.5,
            stribeck_nm,
            stribeck_velocity_rad_per_s: 2.0,
            ..params::Friction::default()
        };
        Friction::new(&friction, 1.0, 0.1, [1.0; 3])
    }

    #[test]
    fn the_flow_is_the_pade_quotient() {
        for k in -40..=40 {
            let speed = 0.2 * f64::from(k);
            let bristle = Bristle { zeta: 0.3, bending: 0.0 };
            let mut mass = Mass { speed, bristle, ..Mass::default() };
            friction(0.2).flow(&mut mass);
            let rho = 1.0 / (1.0 + 0.4 * (-speed * speed / 4.0).exp());
            let y = 3.0 * 0.1 / 0.5 * speed;
            let a = 1.0 + y.abs() * rho / 2.0;
            let zeta = (0.3 + y * a) / (1.0 + y.abs() * rho * a);
            // The exponential's error, 1e-10, times β and the slopes, all below one.
            assert!((mass.bristle.zeta - zeta).abs() < 1e-9, "at {speed}");
            let bending = 1.0 - if speed < 0.0 { -1.0 } else { 1.0 } * zeta * rho;
            assert!((mass.bristle.bending - bending).abs() < 1e-9, "at {speed}");
        }
    }

    #[test]
    fn a_changing_level_that_stays_the_same_is_the_plain_flow() {
        let start = Mass { speed: -1.3, ..Mass::default() };
        let (mut plain, mut along) = (start, start);
        friction(0.2).flow(&mut plain);
        friction(0.2).flow_along(&mut along, [1.0, 1.0]);
        assert!((plain.bristle.zeta - along.bristle.zeta).abs() < 1e-14);
        assert!((plain.bristle.bending - along.bristle.bending).abs() < 1e-14);
    }

    #[test]
    fn a_bristle_without_any_level_at_standstill_rests() {
        let mut mass = Mass::default();
        friction(-0.5).flow(&mut mass);
        assert_eq!(mass.bristle.zeta, 0.0);
    }
}
