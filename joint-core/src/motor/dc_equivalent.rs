//! The DC-equivalent motor, equation (10), solved together with the rotor over one kick.
//!
//! On the flat parts of the back-EMF the two conducting phases in series obey
//! `u = 2R i + 2L di/dt + 2 k_e ω`, and power balance makes `k_t = 2 k_e`. The current relaxes up
//! to 10⁶ times a second, so it is carried exactly at constant voltage and linearly changing speed;
//! the rotor takes the impulse of that current, implicitly in its own new speed.

use crate::batch::batch;
use crate::params::Motor;
use crate::scalar::Scalar;
use crate::settings::Drive;

/// Constants of one kick of the rotor and its winding, per-unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub(crate) struct RotorKick<S: Scalar> {
    /// τ/D: speed per torque.
    per_torque: S::Gain,
    /// k_t I/D: speed per current above its final value.
    per_excess: S::Gain,
    /// k_t τ/D: speed per final current.
    per_drive: S::Gain,
    /// K/D: share of the speed that the induced current takes.
    induced: S::Gain,
    /// E = exp(−τ R/L).
    decay: S::Gain,
    /// 1 − E.
    approach: S,
    after: S::Gain,
    before: S::Gain,
    /// Share of the starting current in its mean over the kick.
    mean: S::Gain,
    /// Current that a speed's back-EMF drives, at rest of the current.
    back_emf: S::Gain,
}

batch!(RotorKick<Scalar>: per_torque, per_excess, per_drive, induced, decay, approach, after, before, mean, back_emf);

/// A change of the current over a kick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Followed<S> {
    /// Its mean.
    pub(crate) mean: S,
    /// At the end.
    pub(crate) end: S,
}

impl<S: Scalar> RotorKick<S> {
    /// A kick of `duration` seconds on a rotor of `inertia` kg m²; units are those at the motor.
    pub(crate) fn new(
        motor: &Motor,
        drive: Drive,
        inertia: f64,
        duration: f64,
        [torque, speed, current]: [f64; 3],
    ) -> Self {
        let constant = motor.torque_constant_nm_per_a;
        let resistance = 2.0 * motor.phase_resistance_ohm;
        let (decay, integral, braking, after, before) = match drive {
            Drive::Current => (0.0, 0.0, 0.0, 0.0, 0.0),
            Drive::Voltage => {
                let lag = motor.phase_inductance_h / motor.phase_resistance_ohm;
                let decay = if lag > 0.0 { libm::exp(-duration / lag) } else { 0.0 };
                let mean = (1.0 - decay) * lag / duration;
                let integral = (1.0 - decay) * lag;
                let braking = constant * constant * (duration - integral) / resistance;
                let induced = constant / resistance;
                (decay, integral, braking, induced * (1.0 - mean), induced * (decay - mean))
            }
        };
        let effective = inertia + braking / 2.0;
        let [per_torque, per_excess, per_drive, induced] = S::gains([
            duration / effective * torque / speed,
            constant * integral / effective * current / speed,
            constant * duration / effective * current / speed,
            braking / effective,
        ]);
        // A voltage that is missing leaves speed missing, whose back-EMF gives back a part of it.
        let regained = after * constant * (duration - integral) / effective;
        let approach = 1.0 - decay - regained;
        let [after, before] = [after, before].map(|share| share * speed / current);
        let [decay, after, before] = S::gains([decay, after, before]);
        Self {
            per_torque,
            per_excess,
            per_drive,
            induced,
            decay,
            approach: S::from_f64(approach),
            after,
            before,
            mean: S::gain(integral / duration),
            back_emf: S::gain(match drive {
                Drive::Voltage => constant / resistance * speed / current,
                Drive::Current => 0.0,
            }),
        }
    }

    /// Share of a voltage held over the kick that the current has followed at its end, the back-EMF included.
    #[inline(always)]
    pub(crate) fn approach(&self) -> S {
        self.approach
    }

    /// Current that the back-EMF takes from the one that the voltage drives.
    #[inline(always)]
    pub(crate) fn induced_current(&self, speed: S) -> S {
        speed.times(self.back_emf)
    }

    /// Speed that the rotor does not gain over the kick where this current is taken off the final one.
    #[inline(always)]
    pub(crate) fn lost_speed(&self, taken: S) -> S {
        taken.times(self.per_drive) - taken.times(self.per_excess)
    }

    /// What an EMF beside the plain one does to the current, from its value at either end of the
    /// kick, given as a speed.
    #[inline(always)]
    pub(crate) fn followed(&self, [from, to]: [S; 2]) -> Followed<S> {
        let settled = -self.induced_current((from + to) * S::HALF);
        Followed {
            mean: settled - settled.times(self.mean),
            end: from.weighed(self.before) - to.weighed(self.after),
        }
    }

    /// Mean current over the kick, at constant speed.
    #[inline(always)]
    pub(crate) fn mean_current(&self, speed: S, current: S, drive: S) -> S {
        let settled = drive - self.induced_current(speed);
        settled + (current - settled).times(self.mean)
    }

    /// New speed and current after the kick, `WHICH` being 1 for the middle one: `force` is the torque on
    /// the rotor beside the motor's, `damping` its torque per speed, `drive` the final current of the held
    /// voltage.
    #[inline(always)]
    pub(crate) fn apply<const WHICH: usize>(
        &self,
        speed: S,
        current: S,
        force: S,
        damping: S,
        drive: S,
    ) -> (S, S) {
        let excess = current - drive;
        let gained = S::gained(
            [
                (force - damping.nearest(speed), &self.per_torque),
                (excess, &self.per_excess),
                (drive, &self.per_drive),
            ],
            (speed, &self.induced),
        );
        let (gained, lost) = (gained.settled(), damping.weighed(self.per_torque));
        let new = match WHICH {
            1 => speed.kicked::<true>(gained, lost),
            _ => speed.kicked::<false>(gained, lost),
        };
        let current =
            drive.ended([(excess, &self.decay), (speed, &self.before)], (new, &self.after));
        (new, current)
    }
}
