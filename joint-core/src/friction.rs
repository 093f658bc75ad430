//! LuGre friction on one inertia, as a flow over half a step and a damping for the kicks.
//!
//! At a fixed speed the bristle relaxes exponentially towards its slip value, up to 10⁸ times a
//! second: far stiffer than the step, but a scalar with a closed solution, of which this takes the
//! Padé (0,2) approximant. It is exact in stick to second order, exact in the slip limit, and
//! stable at every step. Equations (2) and (3); symbols as there, with `ζ = σ0 z / α0` the bristle
//! torque in units of the Coulomb level and `ρ = α0 / g(v)`.

use crate::effect::Effects;
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

/// The bristle of one mass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bristle<S> {
    /// ζ = σ0 z / α0: bristle torque over Coulomb level.
    pub zeta: S,
    /// ρ = α0 / g(v) at the speed of the last flow.
    pub rho: S,
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
            beta: S::from_f64(beta),
            kappa: S::gain(kappa * speed),
            level: S::gain(alpha0 / torque),
            stiffness: S::gain(sigma0 * angle / torque),
            sigma1: S::from_f64(friction.sigma1_nm_s_per_rad * damping),
            sigma2: S::from_f64(friction.sigma2_nm_s_per_rad * damping),
        }
    }

    /// ρ(v) = 1 / (1 + β exp(−(v/v0)²)), equation (3).
    #[inline]
    pub(crate) fn rho(&self, speed: S) -> S {
        let relative = speed.times(self.per_stribeck_velocity).clamped(S::EIGHT);
        S::ONE.over(S::ONE + self.beta * (relative * relative).exp_minus())
    }

    /// Moves a mass's bristle over half a step at its speed; `inverse_levels` are one over the
    /// effects' factor on g(v) at the start and at the end.
    #[inline]
    pub(crate) fn advance<E: Effects<S>>(&self, mass: &mut Mass<S>, inverse_levels: [S; 2]) {
        if E::LEVELS {
            self.flow_along(&mut mass.bristle, mass.speed, inverse_levels);
        } else {
            self.flow(&mut mass.bristle, mass.speed);
        }
    }

    /// Moves the bristle over half a step at this speed.
    #[inline]
    fn flow(&self, bristle: &mut Bristle<S>, speed: S) {
        let rho = self.rho(speed);
        let reach = speed.times(self.kappa);
        let decay = reach.abs() * rho;
        let series = S::ONE + decay * S::HALF;
        bristle.zeta = (bristle.zeta + reach * series).over(S::ONE + decay * series);
        bristle.rho = rho;
    }

    /// Moves the bristle over half a step in which an effect's factor on g(v) changes; both
    /// `inverse_levels` are one over it, at the start and at the end.
    ///
    /// A level that follows a vibrating spring pumps or damps that vibration by the bristle's lag
    /// behind it, so the lag is part of the flow: for a level that changes evenly, the slip value
    /// that the bristle sees is the one at `w = 1/(1 − e^−x) − 1/x` of the way, here as a quotient
    /// of polynomials that is right at both ends.
    #[inline]
    fn flow_along(&self, bristle: &mut Bristle<S>, speed: S, inverse_levels: [S; 2]) {
        let [start, end] = inverse_levels;
        let plain = self.rho(speed);
        let reach = speed.times(self.kappa);
        let decay = reach.abs() * plain * (start + end) * S::HALF;
        let three = S::ONE + S::ONE + S::ONE;
        let square = decay * decay;
        let (above, below) = (
            three + three + three * decay + square,
            square + decay + three * (three + decay + S::ONE),
        );
        let way = above.over(below);
        let (first, last) = (S::ONE.over(start), S::ONE.over(end));
        let target = (first + (last - first) * way).over(plain);
        let target = if speed < S::ZERO { -target } else { target };
        let series = decay * (S::ONE + decay * S::HALF);
        bristle.zeta = (bristle.zeta + series * target).over(S::ONE + series);
        bristle.rho = plain * end;
    }

    /// χ = ż / v = 1 − sgn(v) ζ ρ: the share of the motion that bends the bristle.
    #[inline]
    pub(crate) fn bending(&self, bristle: &Bristle<S>, speed: S) -> S {
        let slip = bristle.zeta * bristle.rho;
        if speed < S::ZERO { S::ONE + slip } else { S::ONE - slip }
    }

    /// Bristle torque σ0 z.
    #[inline]
    pub(crate) fn torque(&self, bristle: &Bristle<S>) -> S {
        bristle.zeta.times(self.level)
    }

    /// Damping c = σ1 χ + σ2, the torque per speed beside the bristle torque.
    #[inline]
    pub(crate) fn damping(&self, bending: S, viscous: S) -> S {
        self.sigma1 * bending + self.sigma2 * viscous
    }

    /// Change of the bristle torque with the angle: σ0 χ.
    #[inline]
    pub(crate) fn slope(&self, bending: S) -> S {
        bending.times(self.stiffness)
    }
}
