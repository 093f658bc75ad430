//! The kicks: speeds and current under forces that are held.

use super::constants::Joint;
use crate::angle::Angle;
use crate::effect::{Effects, Winding};
use crate::motor::RotorKick;
use crate::scalar::Scalar;
use crate::state::{Each, Input, Mass, State};

/// Weight of the first and the last kick of Chin's 4A.
pub(crate) const OUTER: f64 = 1.0 / 6.0;
/// Weight of the middle one, which carries the force gradient.
pub(crate) const MIDDLE: f64 = 2.0 / 3.0;

impl<S: Scalar, const N: usize, E: Effects<S>> Joint<S, N, E> {
    /// Speeds and current over one kick: `WHICH` is 0 for the first, 1 for the middle one, 2 for the
    /// last, each at the angle where its forces are.
    #[inline(always)]
    pub(super) fn kick<const WHICH: usize>(
        &self,
        state: &mut State<S, N>,
        input: Input<S>,
        angle: Angle<S>,
        began: &Each<S, N>,
    ) {
        let kick = if WHICH == 1 { &self.middle } else { &self.outer };
        let rotor = &mut state.rotor;
        let mut drive = input.drive;
        let (speed, current, damping) = (rotor.speed, state.current, rotor.damping);
        let (mut force, lagging) =
            self.driven::<WHICH>(kick, angle, rotor.force, [speed, current, drive]);
        if self.effects.has_drops() && !self.current_imposed {
            (force, drive) = self.dropped::<WHICH>(state, angle, drive);
        }
        let rotor = &mut state.rotor;
        let (speed, current) = kick.apply::<WHICH>(speed, current, force, damping, drive);
        rotor.speed = speed;
        state.current = if self.effects.has_constants() { current + lagging } else { current };
        let stages = state.stages.iter_mut().zip(&self.stages).zip(&began.masses);
        for ((stage, own), began) in stages {
            let mass = &mut stage.mass;
            let [outer, middle] = own.mobility;
            let mobility = if WHICH == 1 { middle } else { outer };
            let lost = mass.damping.times(mobility);
            let force = if WHICH == 1 { mass.force.risen(*began, lost) } else { mass.force };
            // Together to the nearest: a damping rounded on its own would leave small swings alone.
            let gained = (force - mass.damping.nearest(mass.speed)).times_nearest(mobility);
            mass.speed = match WHICH {
                1 => mass.speed.kicked::<true>(gained, lost),
                _ => mass.speed.kicked::<false>(gained, lost),
            };
        }
    }

    /// Force and drive of a kick under the voltage that is lost on the way to the winding.
    #[inline(never)]
    fn dropped<const WHICH: usize>(
        &self,
        state: &State<S, N>,
        angle: Angle<S>,
        drive: S,
    ) -> (S, S) {
        let kick = if WHICH == 1 { &self.middle } else { &self.outer };
        let (Mass { speed, damping, force, .. }, current) = (state.rotor, state.current);
        let driven = |drive| self.driven::<WHICH>(kick, angle, force, [speed, current, drive]);
        let (force, lagging) = driven(drive);
        let (_, ended) = kick.apply::<WHICH>(speed, current, force, damping, drive);
        let at = Winding { current: ended + lagging, per_drop: kick.approach(), drive };
        let left = drive - self.effects.voltage_drop(at, &state.memory);
        // Saturation is that of the current which the drop leaves.
        let force = match self.effects.has_constants() {
            true => driven(left).0,
            false => force,
        };
        (force, left)
    }

    /// A force on the rotor with what effects on the motor constants add at a speed, a current and a drive;
    /// and what they make of the current at the kick's end.
    #[inline(always)]
    fn driven<const WHICH: usize>(
        &self,
        kick: &RotorKick<S>,
        angle: Angle<S>,
        force: S,
        [speed, current, drive]: [S; 3],
    ) -> (S, S) {
        if !self.effects.has_constants() {
            return (force, S::ZERO);
        }
        // The winding follows an EMF that changes over the kick as it follows a speed that does.
        let turned = speed.times(self.kick_turn);
        let [from, to] = match WHICH {
            0 => [angle, angle.ahead(turned)],
            1 => [angle.ahead(-(turned + turned)), angle.ahead(turned + turned)],
            _ => [angle.ahead(-turned), angle],
        };
        let mean = kick.mean_current(speed, current, drive);
        let [from, to] = [from, to].map(|at| self.effects.constants(at, mean));
        let extra = kick.followed([from.back_emf * speed, to.back_emf * speed]);
        let share = (from.torque + to.torque) * S::HALF;
        (force + share * (mean + extra.mean) + extra.mean, extra.end)
    }
}
