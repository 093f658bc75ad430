//! The bristle's flow over half a step at constant speed.

use super::turn::{Half, Turn};
use super::{Changed, Creep, Friction, LuGre};
use crate::state::{Bristle, Mass};

impl<S: LuGre> Friction<S> {
    /// Finds what is kept beside ζ, after ζ or the speed was set from outside.
    #[inline(always)]
    pub(crate) fn settle(&self, mass: &mut Mass<S>, changed: Changed<S>) {
        let (curve, reach) = (self.curve(mass.speed), mass.speed.times(self.kappa));
        self.keep(mass, mass.bristle.zeta, &curve, reach, Some(changed));
    }

    /// Moves a mass's bristle over half a step at its speed ([`Relaxation`](super::Relaxation)).
    /// Answers with the slope there.
    #[inline(always)]
    pub(crate) fn flow(&self, mass: &mut Mass<S>, turn: Option<&Turn<S>>) -> Half<S> {
        let curve = self.curve(mass.speed);
        let y = mass.speed.times_nearest(self.kappa);
        let zeta =
            Turn::applied(turn, mass.bristle.zeta, Half { reach: y.abs(), slope: curve.slope() });
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

    /// Moves the bristle over half a step in which an effect's factor on g(v) changes, or none does; both
    /// `inverse_levels` are one over it, at the start and at the end.
    ///
    /// A level that follows a vibrating spring pumps or damps that vibration by the bristle's lag
    /// behind it, so the lag is part of the flow: for a level that changes evenly, the slip value
    /// that the bristle sees is the one at `w = 1/(1 − e^−x) − 1/x` of the way, here as a quotient
    /// of polynomials that is right at both ends.
    #[inline(always)]
    pub(crate) fn flow_along(
        &self,
        mass: &mut Mass<S>,
        turn: Option<&Turn<S>>,
        inverse_levels: Option<[S; 2]>,
        creep: Option<Creep<S>>,
    ) -> Half<S> {
        let Some([start, end]) = inverse_levels else { return self.flow(mass, turn) };
        let curve = self.curve(mass.speed);
        let reach = mass.speed.times(self.kappa);
        let (mut slip, mut level, mut slope) = (reach.abs(), curve.level, curve.slope());
        let mut turn = turn.copied();
        if let Some(creep) = creep {
            let (rate, bend) = creep.rate(mass.speed);
            slip = rate.times(self.kappa);
            level = level * mass.speed.abs().ratio(rate);
            slope = slope - curve.rho * (S::ONE - bend);
            turn = turn.map(|turn| turn.rounded(bend));
        }
        let decay = slip * S::PER_REACH * curve.rho * (start + end) * S::HALF;
        let three = S::ONE + S::ONE + S::ONE;
        let square = decay * decay;
        let (above, below) = (
            three + three + three * decay + square,
            square + decay + three * (three + decay + S::ONE),
        );
        let way = above.over(below);
        let (first, last) = (S::ONE.over(start), S::ONE.over(end));
        let target = (first + (last - first) * way) * level;
        let target = target.along(mass.speed);
        let series = decay * (S::ONE + decay * (S::HALF + decay * S::SIXTH));
        let Bristle { zeta, lost, .. } = mass.bristle;
        let zeta =
            Turn::applied(turn.as_ref(), zeta, Half { reach: reach.abs(), slope: slope * start });
        let (zeta, lost) = zeta.plus((series * (target - zeta)).over(S::ONE + series), lost);
        mass.bristle.lost = lost;
        self.keep(mass, zeta, &curve, reach, Some(Changed { inverse_level: end, creep }));
        Half { reach: reach.abs(), slope: slope * end }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params;

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
        Friction::new(&friction, 1.0, [0.1, 2.0 / 3.0], 1.0, [1.0; 2])
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
            friction(0.2).settle(&mut mass, Changed { inverse_level: 1.0, creep: None });
            let bristle = mass.bristle;
            let tangent = (rate(speed + 1e-5, 0.7) - rate(speed - 1e-5, 0.7)) / 2e-5;
            let bending = 1.0 - bristle.slipping;
            assert!((bending - tangent).abs() < 1e-8, "slope at {speed}");
            let held = SIGMA1 * (rate(speed, 0.7) - bending * speed) + 0.5 * 0.7;
            assert!((mass.force + held).abs() < 1e-9, "value at {speed}");
            mass.damping = SIGMA1 * bending;
            let felt = 0.5 * 0.7 + SIGMA1 * rate(speed, 0.7);
            let plain = Changed { inverse_level: 1.0, creep: None };
            assert!((friction(0.2).felt(&mass, plain) - felt).abs() < 1e-9, "torque at {speed}");
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

    type Flow = fn(&Friction<f64>, &mut Mass<f64>, Option<&Turn<f64>>) -> Half<f64>;

    /// What is missed of a bristle after `from` to `to` in even acceleration, without its turn and with.
    fn missed(from: f64, to: f64, start: f64, flow: Flow) -> [f64; 2] {
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
            let half = flow(&friction, &mut mass, None);
            mass.speed = late;
            let turn = turned.then(|| friction.turn(&mut mass, early, half));
            mass.speed = late;
            flow(&friction, &mut mass, turn.as_ref());
            mass.bristle.zeta - exact
        })
    }

    fn assert_turn_helps(ways: &[(f64, f64)], start: f64, flow: Flow) {
        let sum = |which: usize| -> f64 {
            ways.iter().map(|(from, to)| missed(*from, *to, start, flow)[which].powi(2)).sum()
        };
        assert!(sum(1) < 0.5 * sum(0), "{} {}", sum(1), sum(0));
    }

    #[test]
    fn a_turn_makes_good_what_constant_halves_miss_of_a_bend() {
        assert_turn_helps(&[(0.3, 2.3), (2.3, 0.3), (1.0, 3.0), (-0.5, -2.5)], 0.4, Friction::flow);
    }

    #[test]
    fn a_turn_makes_good_what_constant_halves_miss_of_a_standstill() {
        let ways: Vec<_> =
            (-6..=6).map(|k| 0.02 * f64::from(k)).map(|m| (m - 0.2, m + 0.2)).collect();
        for flow in [Friction::flow, Friction::flow_exactly] {
            assert_turn_helps(&ways, 1.0, flow);
        }
    }

    #[test]
    fn a_changing_level_that_stays_the_same_is_the_plain_flow() {
        let start = Mass { speed: -1.3, ..Mass::default() };
        let (mut plain, mut along) = (start, start);
        friction(0.2).flow(&mut plain, None);
        friction(0.2).flow_along(&mut along, None, Some([1.0, 1.0]), None);
        assert!((plain.bristle.zeta - along.bristle.zeta).abs() < 1e-14);
        assert!((plain.bristle.slipping - along.bristle.slipping).abs() < 1e-14);
    }

    /// ζ after half a step of a level that changes evenly, by the flow and by many small steps.
    fn along(speed: f64, [start, end]: [f64; 2]) -> [f64; 2] {
        let bristle = Bristle { zeta: 0.3, ..Bristle::default() };
        let mut mass = Mass { speed, bristle, ..Mass::default() };
        friction(0.2).flow_along(&mut mass, None, Some([start, end]), None);
        let rho = 1.0 / (1.0 + 0.4 * (-speed * speed / 4.0).exp());
        let (mut zeta, slip, steps) = (0.3, 0.6 * speed, 2000);
        for k in 0..steps {
            let share = (f64::from(k) + 0.5) / f64::from(steps);
            let level = (1.0 / start + (1.0 / end - 1.0 / start) * share) / rho;
            let slips = speed.signum() * level;
            zeta = slips + (zeta - slips) * (-slip.abs() / level / f64::from(steps)).exp();
        }
        [mass.bristle.zeta, zeta]
    }

    #[test]
    fn a_bristle_lags_behind_a_level_that_changes() {
        for speed in [0.1, -0.8, 2.5, -40.0] {
            let [falling, rising] = [[0.96, 1.0], [1.0, 0.96]].map(|levels| along(speed, levels));
            let [found, exact] = [0, 1].map(|k| rising[k] - falling[k]);
            // The quotient is off the way by 6 % at most, at some three reaches.
            assert!((found - exact).abs() < 0.08 * exact.abs(), "{speed}: {found} {exact}");
            // Of means for the level's course: 0.04²/12 of the slip; and the flow's own error at x = 1.5.
            assert!((rising[0] - rising[1]).abs() < 0.012, "{speed}: {rising:?}");
        }
    }

    #[test]
    fn a_bristle_without_any_level_at_standstill_rests() {
        let mut mass = Mass::default();
        friction(-0.5).flow(&mut mass, None);
        assert_eq!(mass.bristle.zeta, 0.0);
    }
}
