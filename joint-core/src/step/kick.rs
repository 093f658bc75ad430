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
        let Mass { speed, damping, force: held, .. } = state.rotor;
        let current = state.current;
        let (mut force, mut drive, mut lagging) = (held, input.drive, S::ZERO);
        if self.effects.has_limit() && !self.current_imposed {
            (force, drive, lagging) = self.limited(WHICH, state, angle, drive);
        } else {
            if self.effects.has_constants() {
                let at = [speed, current, drive];
                Driven { force, lagging, .. } = self.driven((WHICH, kick), angle, held, at);
            }
            if self.effects.has_drops() && !self.current_imposed {
                (force, drive) = self.dropped(WHICH, state, angle, drive);
            }
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

    /// Force, drive and lagging current of a kick under a limit of the current. What acts beside the limit follows
    /// from what it leaves, and it from that, so this goes round twice.
    #[cfg_attr(target_os = "none", inline(never))]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    fn limited(&self, which: usize, state: &State<S, N>, angle: Angle<S>, asked: S) -> (S, S, S) {
        let kick = if which == 1 { &self.middle } else { &self.outer };
        let (Mass { speed, force: held, .. }, current) = (state.rotor, state.current);
        let mut beside = Beside { force: held, drop: S::ZERO, emf: S::ZERO };
        let mut lagging = S::ZERO;
        let further = self.effects.has_constants() || self.effects.has_drops();
        for _ in 0..if further { 2 } else { 0 } {
            let drive = self.left(kick, &state.rotor, [current, asked], &beside);
            let driven = self.driven((which, kick), angle, held, [speed, current, drive]);
            Driven { force: beside.force, lagging, emf: beside.emf } = driven;
            if self.effects.has_drops() {
                let left;
                (beside.force, left) = self.dropped(which, state, angle, drive);
                beside.drop = drive - left;
            }
        }
        let drive = self.left(kick, &state.rotor, [current, asked], &beside) - beside.drop;
        (beside.force, drive, lagging)
    }

    /// What a limit of the current leaves of the drive's voltage over a kick: the settled current is taken
    /// at the speed in its middle, under this force and what `beside` the limit takes off the voltage or
    /// adds to the back-EMF.
    #[cfg_attr(target_os = "none", inline(never))]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    fn left(&self, kick: &RotorKick<S>, rotor: &Mass<S>, drive: [S; 2], beside: &Beside<S>) -> S {
        let [current, drive] = drive;
        let Beside { force, drop, emf } = *beside;
        let (ended, _) = kick.apply::<0>(rotor.speed, current, force, rotor.damping, drive - drop);
        let middle = (rotor.speed + ended) * S::HALF;
        let excess = self.effects.excess(drive - kick.induced_current(middle + emf));
        // Without the torque that is taken the rotor falls short of that speed.
        let short = kick.induced_current(kick.lost_speed(excess.value) * S::HALF);
        drive - excess.value - excess.slope * short
    }

    /// Force and drive of a kick under the voltage that is lost on the way to the winding.
    #[cfg_attr(target_os = "none", inline(never))]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    fn dropped(&self, which: usize, state: &State<S, N>, angle: Angle<S>, drive: S) -> (S, S) {
        let kick = if which == 1 { &self.middle } else { &self.outer };
        let (Mass { speed, damping, force, .. }, current) = (state.rotor, state.current);
        let driven = |drive| self.driven((which, kick), angle, force, [speed, current, drive]);
        let Driven { force, lagging, .. } = driven(drive);
        let (_, ended) = kick.apply::<0>(speed, current, force, damping, drive);
        let at = Winding { current: ended + lagging, per_drop: kick.approach(), drive };
        let left = drive - self.effects.voltage_drop(at, &state.memory);
        // Saturation is that of the current which the drop leaves.
        let force = match self.effects.has_constants() {
            true => driven(left).force,
            false => force,
        };
        (force, left)
    }

    /// A force on the rotor with what effects on the motor constants add at a speed, a current and a drive.
    #[inline(always)]
    fn driven(
        &self,
        kick: (usize, &RotorKick<S>),
        angle: Angle<S>,
        force: S,
        at: [S; 3],
    ) -> Driven<S> {
        match self.effects.has_constants() {
            true => self.with_constants(kick, angle, force, at),
            false => Driven { force, lagging: S::ZERO, emf: S::ZERO },
        }
    }

    /// The same where there are such effects. On a chip there is one copy, since flash is short; a host's lanes need it
    /// in place.
    #[cfg_attr(target_os = "none", inline(never))]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    fn with_constants(
        &self,
        (which, kick): (usize, &RotorKick<S>),
        angle: Angle<S>,
        force: S,
        [speed, current, drive]: [S; 3],
    ) -> Driven<S> {
        // The winding follows an EMF that changes over the kick as it follows a speed that does.
        let turned = speed.times(self.kick_turn);
        let [from, to] = match which {
            0 => [angle, angle.ahead(turned)],
            1 => [angle.ahead(-(turned + turned)), angle.ahead(turned + turned)],
            _ => [angle.ahead(-turned), angle],
        };
        let mean = kick.mean_current(speed, current, drive);
        let [from, to] = [from, to].map(|at| self.effects.constants(at, mean));
        let emf = [from.back_emf * speed, to.back_emf * speed];
        let extra = kick.followed(emf);
        let share = (from.torque + to.torque) * S::HALF;
        Driven {
            force: force + share * (mean + extra.mean) + extra.mean,
            lagging: extra.end,
            emf: (emf[0] + emf[1]) * S::HALF,
        }
    }
}

/// What acts on the rotor beside a limit of the current.
struct Beside<S> {
    force: S,
    /// Taken off the voltage, as a settled current.
    drop: S,
    /// Added to the back-EMF, as a speed.
    emf: S,
}

/// What effects on the motor constants make of a kick.
struct Driven<S> {
    /// Force on the rotor with theirs.
    force: S,
    /// Part of the current at the kick's end.
    lagging: S,
    /// Mean of the back-EMF beside the plain one, given as a speed.
    emf: S,
}
