//! LuGre friction on one inertia, as a flow over half a step and a damping for the kicks.
//!
//! At a fixed speed the bristle ([`Relaxation`]) relaxes towards the slip value of the Stribeck curve
//! ([`Stribeck`]). Equations (2) and (3); symbols as there, with `ζ = σ0 z / α0` the bristle torque in
//! units of the Coulomb level and `ρ = α0 / g(v)`.
//!
//! The speed moves in the kicks, though, and friction bends with it: by the Stribeck curve, which
//! can turn a gear's damping negative within one step, and by the corner at standstill. So the
//! kicks take the torque σ1 ż by its tangent ([`Damped`]), and the second half's flow starts with what
//! the two halves of constant speed miss of a speed that moved between them ([`Turn`]).

mod bristle;
mod creep;
mod damping;
mod flow;
mod passive;
mod stribeck;
mod turn;

pub use bristle::Relaxation;
pub use creep::Creep;
pub use damping::Damped;
pub use stribeck::Stribeck;
pub(crate) use turn::{Half, Turn};

use crate::batch::batch;
use crate::params;
use crate::state::{Bristle, Mass};
use stribeck::Curve;

/// A number in which LuGre friction can be computed.
pub trait LuGre: Stribeck + Relaxation {}
impl<T: Stribeck + Relaxation> LuGre for T {}

/// Constants of one mass, per-unit and reflected to the motor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct Friction<S: LuGre> {
    /// √2/v0.
    per_stribeck_velocity: S::Gain,
    /// β = α1/α0.
    beta: S,
    /// κ = σ0 h / (2 α0): slip over half a step in units of the bristle's reach, per speed.
    pub(crate) kappa: S::Gain,
    /// α0, torque per ζ.
    pub(crate) level: S,
    /// σ1/κ: torque of a bend over half a step.
    per_reach: S::Gain,
    /// σ0 h²/24 J, the force gradient's share of a force.
    stiffness: S::Gain,
    pub(crate) sigma1: S,
    pub(crate) sigma2: S,
    /// σ1 + σ2.
    standing: S,
    /// Share of ζ per speed that passes standstill.
    corner: S::Gain,
    /// Share of the speed behind standstill that the damping of a reversing bristle takes.
    reversal: S,
}

batch!(Friction<LuGre>: per_stribeck_velocity, beta, kappa, level, per_reach, stiffness, sigma1, sigma2, standing, corner, reversal);

/// A level g(v) of zero at standstill would leave ζ there undefined.
pub(crate) const LEAST_BETA: f64 = -1.0 + 1e-6;

/// A speed that crosses zero evenly between the two half drifts makes ∫|v| other than the halves do, by
/// ⅓ of the smaller of the two and less 1/72 of their sum: the least-squares line over all crossings.
const CORNER: f64 = 1.0 / 3.0;
/// Mean share of the step behind standstill that the tangent before it misses of |v|, twice.
const REVERSAL: f64 = 2.0 / 3.0;

/// What effects change of a mass's friction.
#[derive(Clone, Copy)]
pub(crate) struct Changed<S: LuGre> {
    /// One over the factor on its level.
    pub inverse_level: S,
    /// How it gives way below breakaway.
    pub creep: Option<Creep<S>>,
}

impl<S: LuGre> Friction<S> {
    /// From SI: `shaft` is the mass's ratio to the motor, `half_step` in seconds, `middle` the middle
    /// kick's share of the step, `inertia` reflected to the motor; `torque` and `speed` are the units
    /// there.
    pub(crate) fn new(
        friction: &params::Friction,
        shaft: f64,
        [half_step, middle]: [f64; 2],
        inertia: f64,
        [torque, speed]: [f64; 2],
    ) -> Self {
        let shaft = libm::fabs(shaft);
        let alpha0 = friction.coulomb_nm * shaft;
        let sigma0 = friction.sigma0_nm_per_rad * shaft * shaft;
        let (beta, kappa) = if alpha0 > 0.0 {
            (friction.stribeck_nm / friction.coulomb_nm, S::REACH * sigma0 * half_step / alpha0)
        } else {
            (0.0, 0.0)
        };
        let damping = shaft * shaft * speed / torque;
        let sigma1 = friction.sigma1_nm_s_per_rad * shaft * shaft;
        Self {
            per_stribeck_velocity: S::gain(
                libm::sqrt(2.0 * S::SQUARE) * speed * shaft / friction.stribeck_velocity_rad_per_s,
            ),
            beta: S::from_f64(beta.max(LEAST_BETA)),
            kappa: S::gain(kappa * speed),
            level: S::from_f64(alpha0 / torque),
            per_reach: S::gain(if kappa > 0.0 {
                sigma1 / (kappa * torque * S::SQUARE)
            } else {
                0.0
            }),
            stiffness: S::gain(sigma0 * half_step * half_step / (6.0 * inertia)),
            sigma1: S::from_f64(friction.sigma1_nm_s_per_rad * damping),
            sigma2: S::from_f64(friction.sigma2_nm_s_per_rad * damping),
            standing: S::from_f64(
                (friction.sigma1_nm_s_per_rad + friction.sigma2_nm_s_per_rad) * damping,
            ),
            corner: S::gain(CORNER * kappa / S::REACH * speed / (1.0 + beta.max(0.0))),
            reversal: S::from_f64(REVERSAL * sigma1 * middle * 2.0 * half_step / inertia),
        }
    }

    /// The Stribeck curve 1/ρ = g(v)/α0 = 1 + β exp(−(v/v0)²), equation (3), and how it bends.
    #[inline(always)]
    pub(crate) fn curve(&self, speed: S) -> Curve<S> {
        Curve::at(speed.times(self.per_stribeck_velocity), &self.beta)
    }

    /// Puts the bristle at ζ. Its torque σ0 z + σ1 ż is kept as a tangent in the speed: what there is
    /// of it at standstill is the mass's force to begin with.
    #[inline(always)]
    fn keep(
        &self,
        mass: &mut Mass<S>,
        zeta: S,
        curve: &Curve<S>,
        reach: S,
        changed: Option<Changed<S>>,
    ) {
        let levelled = |value: S| changed.map_or(value, |it| value * it.inverse_level);
        let along = levelled(zeta.along(mass.speed));
        let (mut slope, mut climb) = (curve.slope(), curve.steepness * reach.abs());
        if let Some(creep) = changed.and_then(|it| it.creep) {
            let (rate, bend) = creep.rate(mass.speed);
            slope = slope - curve.rho * (S::ONE - bend);
            let short = reach.abs() * bend - rate.times(self.kappa);
            climb = climb + short * curve.rho * S::from_f64(S::SQUARE);
        }
        let climb = levelled(climb);
        mass.bristle.zeta = zeta;
        mass.bristle.slipping = along * slope;
        mass.force = -zeta.nearest(self.level + climb.times(self.per_reach));
    }

    /// What the middle kick made of a speed from `before`, where the first half drift was `half`.
    #[inline(always)]
    pub(crate) fn turn(&self, mass: &mut Mass<S>, before: S, half: Half<S>) -> Turn<S> {
        Turn::of(mass, before, half, &self.corner, &self.reversal)
    }

    /// Friction torque σ0 z + σ1 ż + σ2 v as the mass was last found; not for the step.
    #[inline(never)]
    pub(crate) fn felt(&self, mass: &Mass<S>, changed: Changed<S>) -> S {
        let Bristle { zeta, slipping, .. } = mass.bristle;
        let Changed { inverse_level, creep } = changed;
        let slip = creep.map_or(mass.speed.abs(), |creep| creep.rate(mass.speed).0);
        let rate = mass.speed - slip * self.curve(mass.speed).rho * zeta * inverse_level;
        zeta * self.level
            + self.sigma1 * rate
            + (mass.damping - self.sigma1 * (S::ONE - slipping)) * mass.speed
    }

    /// How much of the Coulomb level is bending instead of slipping, as where a speed turns round; not
    /// for the step.
    pub(crate) fn turning(&self, mass: &Mass<S>) -> S {
        (S::ONE - mass.bristle.slipping).abs() * self.level
    }

    /// Damping σ1 ∂ż/∂v + σ2, the torque per speed beside the bristle torque.
    #[inline(always)]
    pub(crate) fn damping(&self, bristle: &Bristle<S>) -> S {
        self.standing - self.sigma1 * bristle.slipping
    }

    /// The same with a factor on the viscous part.
    #[inline(always)]
    pub(crate) fn damping_with(&self, bristle: &Bristle<S>, viscous: S) -> S {
        self.damping(bristle) + self.sigma2 * (viscous - S::ONE)
    }

    /// Change of the bristle torque, over the force gradient's h²/24 J, under a force on the mass:
    /// σ0 ∂ż/∂v of the angle that the force moves.
    #[inline(always)]
    pub(crate) fn shift(&self, bristle: &Bristle<S>, force: S) -> S {
        let moved = force.times(self.stiffness);
        moved - bristle.slipping.nearest(moved)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OWN: params::Friction = params::Friction {
        sigma0_nm_per_rad: 3.0,
        sigma1_nm_s_per_rad: 0.3,
        sigma2_nm_s_per_rad: 0.07,
        coulomb_nm: 0.5,
        stribeck_nm: 0.2,
        stribeck_velocity_rad_per_s: 2.0,
    };
    const HALF_STEP_S: f64 = 0.1;
    const INERTIA: f64 = 0.8;

    fn friction(own: &params::Friction, shaft: f64, units: [f64; 2]) -> Friction<f64> {
        Friction::new(own, shaft, [HALF_STEP_S, 0.5], INERTIA, units)
    }

    /// Ratio and units are powers of two: nothing is rounded.
    #[test]
    fn behind_a_gear_and_in_other_units_it_is_the_same_friction() {
        let (shaft, torque, speed) = (0.25, 8.0, 4.0);
        let square = shaft * shaft;
        let reflected = params::Friction {
            sigma0_nm_per_rad: OWN.sigma0_nm_per_rad * square,
            sigma1_nm_s_per_rad: OWN.sigma1_nm_s_per_rad * square,
            sigma2_nm_s_per_rad: OWN.sigma2_nm_s_per_rad * square,
            coulomb_nm: OWN.coulomb_nm * shaft,
            stribeck_nm: OWN.stribeck_nm * shaft,
            stribeck_velocity_rad_per_s: OWN.stribeck_velocity_rad_per_s / shaft,
        };
        let one = friction(&reflected, 1.0, [1.0; 2]);
        let scaled = Friction {
            per_stribeck_velocity: one.per_stribeck_velocity * speed,
            kappa: one.kappa * speed,
            level: one.level / torque,
            per_reach: one.per_reach / torque,
            sigma1: one.sigma1 * speed / torque,
            sigma2: one.sigma2 * speed / torque,
            standing: one.standing * speed / torque,
            corner: one.corner * speed,
            ..one
        };
        assert_eq!(friction(&OWN, -shaft, [torque, speed]), scaled);
    }

    #[test]
    fn constants_and_what_is_read_from_them_are_as_stated() {
        let own = friction(&OWN, 1.0, [1.0; 2]);
        let bristle = Bristle { slipping: 0.25, ..Bristle::default() };
        let mass = Mass { bristle, ..Mass::default() };
        let step = 2.0 * HALF_STEP_S;
        for (found, stated) in [
            (own.kappa, <f64 as Relaxation>::REACH * 3.0 * HALF_STEP_S / 0.5),
            (own.per_reach, 0.3 / own.kappa),
            (own.corner, 3.0 * HALF_STEP_S / 0.5 / 3.0 / 1.4),
            (own.reversal, 2.0 / 3.0 * 0.3 * 0.5 * step / INERTIA),
            (own.shift(&bristle, 2.0), 3.0 * step * step / (24.0 * INERTIA) * 0.75 * 2.0),
            (own.damping(&bristle), 0.3 * 0.75 + 0.07),
            (own.damping_with(&bristle, 3.0), 0.3 * 0.75 + 0.07 * 3.0),
            (own.turning(&mass), 0.75 * 0.5),
        ] {
            assert!((found - stated).abs() < 1e-15, "{found} {stated}");
        }
    }
}
