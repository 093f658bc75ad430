//! LuGre friction on one inertia, as a flow over half a step and a damping for the kicks.
//!
//! At a fixed speed the bristle relaxes exponentially towards its slip value, up to 10⁸ times a
//! second: far stiffer than the step, but a scalar with a closed solution, of which this takes the
//! Padé (0,3) approximant. It is exact in stick to third order, exact in the slip limit, and
//! stable at every step. Equations (2) and (3); symbols as there, with `ζ = σ0 z / α0` the bristle
//! torque in units of the Coulomb level and `ρ = α0 / g(v)`.
//!
//! The speed moves in the kicks, though, and friction bends with it: by the Stribeck curve, which
//! can turn a gear's damping negative within one step, and by the corner at standstill. So the
//! kicks take the torque σ1 ż by its tangent, and the second half's flow starts with what the two
//! halves of constant speed miss of a speed that moved between them ([`Turn`]).

use crate::joint::{MIDDLE, Mass};
use crate::params;
use crate::scalar::Scalar;
use crate::work::{FlowAlong, Settle};

/// Constants of one mass, per-unit and reflected to the motor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct Friction<S: Scalar> {
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

/// A level g(v) of zero at standstill would leave ζ there undefined.
const LEAST_BETA: f64 = -1.0 + 1e-6;

/// The bristle of one mass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bristle<S> {
    /// ζ = σ0 z / α0: bristle torque over Coulomb level.
    pub zeta: S,
    /// 1 − ∂ż/∂v = sgn(v) ζ (ρ + v ρ') at the end of the last flow: what a faster motion slips, beside
    /// what it bends.
    pub(crate) slipping: S,
    /// What the rotor's ζ has lost by rounding.
    pub(crate) lost: S,
}

/// What a mass's speed did between the two half drifts, for the second one's flow.
#[derive(Clone, Copy)]
pub(crate) struct Turn<S> {
    /// Share of ζ that a passed standstill adds.
    share: S,
    /// The first half's.
    half: Half<S>,
}

/// What the second half of a drift asks of the first.
#[derive(Clone, Copy, Default)]
pub(crate) struct Half<S> {
    /// |κ v|.
    reach: S,
    /// Slope ρ + v ρ' of the bristle's slip over ζ.
    slope: S,
}

/// The Stribeck curve at one speed.
#[derive(Clone, Copy)]
pub(crate) struct Curve<S> {
    /// 1/ρ = g(v)/α0.
    level: S,
    /// ρ = α0/g(v).
    pub(crate) rho: S,
    /// v ρ' over the unit of the square.
    steepness: S,
}

impl<S: Scalar> Curve<S> {
    /// Slope of |v| ρ, the bristle's slip over ζ.
    #[inline(always)]
    pub(crate) fn slope(&self) -> S {
        self.rho + self.steepness.per_square()
    }
}

/// A speed that crosses zero evenly between the two half drifts makes ∫|v| other than the halves do, by
/// ⅓ of the smaller of the two and less 1/72 of their sum: the least-squares line over all crossings.
const CORNER: f64 = 1.0 / 3.0;
/// Mean share of the step behind standstill that the tangent before it misses of |v|, twice.
const REVERSAL: f64 = 2.0 / 3.0;

impl<S: Scalar> Friction<S> {
    /// From SI: `shaft` is the mass's ratio to the motor, `half_step` in seconds, `inertia` reflected
    /// to the motor; `torque` and `speed` are the units there.
    pub(crate) fn new(
        friction: &params::Friction,
        shaft: f64,
        half_step: f64,
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
            reversal: S::from_f64(REVERSAL * sigma1 * MIDDLE * 2.0 * half_step / inertia),
        }
    }

    /// The Stribeck curve 1/ρ = g(v)/α0 = 1 + β exp(−(v/v0)²), equation (3), and how it bends.
    #[inline(always)]
    pub(crate) fn curve(&self, speed: S) -> Curve<S> {
        let relative = speed.times(self.per_stribeck_velocity);
        let square = relative.squared();
        let (excess, level) = square.stribeck(self.beta);
        let rho = S::ONE - excess;
        Curve { level, rho, steepness: rho * excess * square }
    }

    /// Finds what is kept beside ζ, after ζ or the speed was set from outside.
    pub(crate) fn settle(&self, mass: &mut Mass<S>, inverse_level: S) {
        S::widely(Settle { friction: self, mass, inverse_level });
    }

    #[inline(always)]
    pub(crate) fn settle_here(&self, mass: &mut Mass<S>, inverse_level: S) {
        let (curve, reach) = (self.curve(mass.speed), mass.speed.times(self.kappa));
        self.keep(mass, mass.bristle.zeta, &curve, reach, Some(inverse_level));
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
        inverse_level: Option<S>,
    ) {
        let levelled = |value: S| inverse_level.map_or(value, |level| value * level);
        let along = levelled(zeta.along(mass.speed));
        mass.bristle.zeta = zeta;
        mass.bristle.slipping = along * curve.slope();
        let climb = levelled(curve.steepness.nearest(reach.abs()));
        mass.force = -zeta.nearest(self.level + climb.times(self.per_reach));
    }

    /// Moves a mass's bristle over half a step at its speed: with y = κ v, x = |y| ρ and
    /// a = 1 + x/2 + x²/6, `ζ ← (ζ + y a) / (1 + x a)`. Answers with the slope there.
    #[inline(always)]
    pub(crate) fn flow(&self, mass: &mut Mass<S>, turn: Option<&Turn<S>>) -> Half<S> {
        let curve = self.curve(mass.speed);
        let y = mass.speed.times_nearest(self.kappa);
        let zeta =
            Self::turned(mass.bristle.zeta, turn, Half { reach: y.abs(), slope: curve.slope() });
        let zeta = zeta.relaxed(y, curve.rho, curve.level);
        self.keep(mass, zeta, &curve, y, None);
        Half { reach: y.abs(), slope: curve.slope() }
    }

    /// The same without forgetting what is too small for the sum: for the mass whose angle is summed
    /// as exactly. The others are held to it by their springs.
    #[inline(always)]
    pub(crate) fn flow_exactly(&self, mass: &mut Mass<S>, turn: Option<&Turn<S>>) -> Half<S> {
        let curve = self.curve(mass.speed);
        let Bristle { zeta, lost, .. } = mass.bristle;
        let (y, lost) = mass.speed.reached(self.kappa, lost);
        let zeta = match turn {
            Some(t) => zeta + zeta.nearest(t.share),
            None => zeta,
        };
        let (zeta, lost) = zeta.relaxed_exactly(lost, y, curve.rho, curve.level);
        mass.bristle.lost = lost;
        self.keep(mass, zeta, &curve, y, None);
        Half { reach: y.abs(), slope: curve.slope() }
    }

    /// ζ with what a speed that moved between the halves makes of it.
    #[inline(always)]
    fn turned(zeta: S, turn: Option<&Turn<S>>, now: Half<S>) -> S {
        match turn {
            Some(turn) => {
                let swung = (now.reach - turn.half.reach).nearest(now.slope - turn.half.slope);
                zeta + zeta.nearest(turn.share + swung.swing())
            }
            None => zeta,
        }
    }

    /// Moves the bristle over half a step in which an effect's factor on g(v) changes, or none does; both
    /// `inverse_levels` are one over it, at the start and at the end.
    ///
    /// A level that follows a vibrating spring pumps or damps that vibration by the bristle's lag
    /// behind it, so the lag is part of the flow: for a level that changes evenly, the slip value
    /// that the bristle sees is the one at `w = 1/(1 − e^−x) − 1/x` of the way, here as a quotient
    /// of polynomials that is right at both ends.
    #[inline(never)]
    pub(crate) fn flow_along(
        &self,
        mass: &mut Mass<S>,
        turn: Option<&Turn<S>>,
        inverse_levels: Option<[S; 2]>,
    ) -> Half<S> {
        S::widely(FlowAlong { friction: self, mass, turn, inverse_levels })
    }

    #[inline(always)]
    pub(crate) fn flow_along_here(
        &self,
        mass: &mut Mass<S>,
        turn: Option<&Turn<S>>,
        inverse_levels: Option<[S; 2]>,
    ) -> Half<S> {
        let Some([start, end]) = inverse_levels else { return self.flow(mass, turn) };
        let curve = self.curve(mass.speed);
        let reach = mass.speed.times(self.kappa);
        let decay = reach.abs() * S::PER_REACH * curve.rho * (start + end) * S::HALF;
        let three = S::ONE + S::ONE + S::ONE;
        let square = decay * decay;
        let (above, below) = (
            three + three + three * decay + square,
            square + decay + three * (three + decay + S::ONE),
        );
        let way = above.over(below);
        let (first, last) = (S::ONE.over(start), S::ONE.over(end));
        let target = (first + (last - first) * way) * curve.level;
        let target = target.along(mass.speed);
        let series = decay * (S::ONE + decay * (S::HALF + decay * S::SIXTH));
        let Bristle { zeta, lost, .. } = mass.bristle;
        let slope = curve.slope() * start;
        let zeta = Self::turned(zeta, turn, Half { reach: reach.abs(), slope });
        let (zeta, lost) = zeta.plus((series * (target - zeta)).over(S::ONE + series), lost);
        mass.bristle.lost = lost;
        self.keep(mass, zeta, &curve, reach, Some(end));
        Half { reach: reach.abs(), slope: curve.slope() * end }
    }

    /// What the middle kick made of a speed from `before`, where the bristle's slope was `slope`.
    ///
    /// A bristle whose rate bends with the speed, by τ'' = ∂²ż/∂v², misses a²τ'' h³/72 of an acceleration
    /// a between the two drifts: the last term of the splitting's double commutator, here by differences
    /// of speed and slope, so that it ends where the Stribeck curve does. At standstill the bend is a
    /// corner, and its part is what halves at constant speed miss of ∫|v|; the speed makes good the
    /// kick's tangent of the damping behind it.
    #[inline(always)]
    pub(crate) fn turn(&self, mass: &mut Mass<S>, before: S, half: Half<S>) -> Turn<S> {
        let after = mass.speed;
        // Twice the speeds' mean and their distance, which is the larger only across standstill.
        let (mean, apart) = ((after + before).abs(), (after - before).abs());
        let share = (apart * S::ELEVEN_TWELFTHS - mean).times(self.corner);
        let passed = mean.below(apart);
        let share = S::choose(passed, share, S::ZERO);
        let behind = S::choose(passed, after, S::ZERO);
        mass.speed = after - behind * (self.reversal * mass.bristle.slipping);
        Turn { share, half }
    }

    /// Friction torque σ0 z + σ1 ż + σ2 v as the mass was last found; not for the step.
    pub(crate) fn felt(&self, mass: &Mass<S>) -> S {
        let Bristle { zeta, slipping, .. } = mass.bristle;
        let rate = mass.speed - mass.speed.abs() * self.curve(mass.speed).rho * zeta;
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

    const SIGMA1: f64 = 0.3;

    fn friction(stribeck_nm: f64) -> Friction<f64> {
        let friction = params::Friction {
            sigma0_nm_per_rad: 3.0,
            sigma1_nm_s_per_rad: SIGMA1,
            coulomb_nm: 0.5,
            stribeck_nm,
            stribeck_velocity_rad_per_s: 2.0,
            ..params::Friction::default()
        };
        Friction::new(&friction, 1.0, 0.1, 1.0, [1.0; 2])
    }

    #[test]
    fn the_flow_is_the_pade_quotient() {
        for k in -40..=40 {
            let speed = 0.2 * f64::from(k);
            let bristle = Bristle { zeta: 0.3, ..Bristle::default() };
            let mut mass = Mass { speed, bristle, ..Mass::default() };
            friction(0.2).flow(&mut mass, None);
            let rho = 1.0 / (1.0 + 0.4 * (-speed * speed / 4.0).exp());
            let y = 3.0 * 0.1 / 0.5 * speed;
            let x = y.abs() * rho;
            let a = 1.0 + x / 2.0 + x * x / 6.0;
            let zeta = (0.3 + y * a) / (1.0 + x * a);
            // The exponential's error, 1e-10, times β and the slopes, all below one.
            assert!((mass.bristle.zeta - zeta).abs() < 1e-9, "at {speed}");
        }
    }

    #[test]
    fn what_is_kept_is_the_tangent_of_the_bristle_torque() {
        let rho = |speed: f64| 1.0 / (1.0 + 0.4 * (-speed * speed / 4.0).exp());
        let rate = |speed: f64, zeta: f64| speed - speed.abs() * rho(speed) * zeta;
        for speed in [-5.0_f64, -1.7, -0.3, 0.2, 1.0, 2.5, 6.0] {
            let bristle = Bristle { zeta: 0.7, ..Bristle::default() };
            let mut mass = Mass { speed, bristle, ..Mass::default() };
            friction(0.2).settle(&mut mass, 1.0);
            let bristle = mass.bristle;
            let tangent = (rate(speed + 1e-5, 0.7) - rate(speed - 1e-5, 0.7)) / 2e-5;
            let bending = 1.0 - bristle.slipping;
            assert!((bending - tangent).abs() < 1e-8, "slope at {speed}");
            let held = SIGMA1 * (rate(speed, 0.7) - bending * speed) + 0.5 * 0.7;
            assert!((mass.force + held).abs() < 1e-9, "value at {speed}");
            mass.damping = SIGMA1 * bending;
            let felt = 0.5 * 0.7 + SIGMA1 * rate(speed, 0.7);
            assert!((friction(0.2).felt(&mass) - felt).abs() < 1e-9, "torque at {speed}");
        }
    }

    #[test]
    fn only_a_speed_that_changes_its_sign_passes_standstill() {
        let bristle = Bristle { zeta: 0.7, slipping: 0.5, lost: 0.0 };
        let mut mass = Mass { speed: 1.3, bristle, ..Mass::default() };
        let half = Half::default();
        let turn = friction(0.2).turn(&mut mass, 0.2, half);
        assert_eq!((turn.share, mass.speed), (0.0, 1.3));
        let turn = friction(0.2).turn(&mut mass, -0.9, half);
        assert!(turn.share > 0.0 && mass.speed < 1.3);
    }

    /// What is missed of a bristle after `from` to `to` in even acceleration, without its turn and with.
    fn missed(from: f64, to: f64, start: f64) -> [f64; 2] {
        let friction = friction(0.4);
        let rho = |speed: f64| 1.0 / (1.0 + 0.8 * (-speed * speed / 4.0).exp());
        let (mut exact, steps) = (start, 20_000);
        for k in 0..steps {
            let speed = from + (to - from) * (f64::from(k) + 0.5) / f64::from(steps);
            let rate = |zeta: f64| 6.0 * (speed - speed.abs() * rho(speed) * zeta);
            let h = 0.2 / f64::from(steps);
            exact += h * rate(exact + 0.5 * h * rate(exact));
        }
        // The drifts of the splitting lie a third of the step before and after its middle.
        let [early, late] = [1.0, -1.0].map(|side| 0.5 * (from + to) - side * (to - from) / 3.0);
        [false, true].map(|turned| {
            let bristle = Bristle { zeta: start, ..Bristle::default() };
            let mut mass = Mass { speed: early, bristle, ..Mass::default() };
            let half = friction.flow(&mut mass, None);
            mass.speed = late;
            let turn = turned.then(|| friction.turn(&mut mass, early, half));
            mass.speed = late;
            friction.flow(&mut mass, turn.as_ref());
            mass.bristle.zeta - exact
        })
    }

    fn assert_turn_helps(ways: &[(f64, f64)], start: f64) {
        let sum = |which: usize| -> f64 {
            ways.iter().map(|(from, to)| missed(*from, *to, start)[which].powi(2)).sum()
        };
        assert!(sum(1) < 0.5 * sum(0), "{} {}", sum(1), sum(0));
    }

    #[test]
    fn a_turn_makes_good_what_constant_halves_miss_of_a_bend() {
        assert_turn_helps(&[(0.3, 2.3), (2.3, 0.3), (1.0, 3.0), (-0.5, -2.5)], 0.4);
    }

    #[test]
    fn a_turn_makes_good_what_constant_halves_miss_of_a_standstill() {
        let ways: Vec<_> =
            (-6..=6).map(|k| 0.02 * f64::from(k)).map(|m| (m - 0.2, m + 0.2)).collect();
        assert_turn_helps(&ways, 1.0);
    }

    #[test]
    fn a_changing_level_that_stays_the_same_is_the_plain_flow() {
        let start = Mass { speed: -1.3, ..Mass::default() };
        let (mut plain, mut along) = (start, start);
        friction(0.2).flow(&mut plain, None);
        friction(0.2).flow_along(&mut along, None, Some([1.0, 1.0]));
        assert!((plain.bristle.zeta - along.bristle.zeta).abs() < 1e-14);
        assert!((plain.bristle.slipping - along.bristle.slipping).abs() < 1e-14);
    }

    #[test]
    fn a_bristle_without_any_level_at_standstill_rests() {
        let mut mass = Mass::default();
        friction(-0.5).flow(&mut mass, None);
        assert_eq!(mass.bristle.zeta, 0.0);
    }
}
