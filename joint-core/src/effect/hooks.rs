//! Where effects enter the step.
//!
//! A law implements [`Effects`] and overrides the hooks it lives in; every hook has a default that
//! changes nothing, so a joint with the effects `()` compiles to the plain equations. Masses count
//! from 0 at the rotor, stages from 0 at the motor; all quantities are per-unit and reflected to
//! the motor shaft unless said otherwise.

use super::table::Tables;
use crate::angle::Angle;
use crate::friction::Creep;
use crate::scalar::Scalar;

pub use crate::state::{MEMORIES, Memory};

/// The motion of one mass.
#[derive(Clone, Copy, Debug)]
pub struct Motion<S: Scalar> {
    /// Angle of this mass as it is at the motor, with all its turns.
    pub angle: Angle<S>,
    /// Speed of this mass.
    pub speed: S,
}

/// A torque and what it changes by with the angle or deflection it depends on.
#[derive(Clone, Copy, Debug)]
pub struct Torque<S> {
    /// Torque, positive with motion on a mass and with a deflection in a stage.
    pub value: S,
    /// Derivative with respect to the angle or deflection.
    pub slope: S,
}

impl<S: Scalar> Torque<S> {
    /// None.
    pub const NONE: Self = Self { value: S::ZERO, slope: S::ZERO };

    #[inline(always)]
    pub(super) fn plus(self, other: Self) -> Self {
        Self { value: self.value + other.value, slope: self.slope + other.slope }
    }
}

/// What a stage's spring feels of the geometric deflection.
#[derive(Clone, Copy, Debug)]
pub struct Felt<S> {
    /// The deflection left for the spring.
    pub deflection: S,
    /// One where the spring is in contact, else zero.
    pub contact: S,
    /// Derivative of the deflection with the input angle: the input side feels the stage's torque
    /// times this.
    pub leverage: S,
}

impl<S: Scalar> Felt<S> {
    /// What another law leaves of it, felt through this one.
    #[inline(always)]
    pub(super) fn then(self, own: Self) -> Self {
        Self {
            deflection: own.deflection,
            contact: self.contact * own.contact,
            leverage: self.leverage * own.leverage,
        }
    }
}

/// Where a friction level is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Rubbing<S: Scalar> {
    /// Speed of the mass.
    pub speed: S,
    /// Torque that reaches the mass: its stage's, spring and damper; the motor torque for the
    /// rotor.
    pub transmitted: S,
    /// Torque of the stage behind the mass, spring and damper; zero for the last mass.
    pub passed_on: S,
    /// Angle of the mass as it is at the motor, with all its turns; that of another mass unless
    /// [`Effects::has_angled_levels`].
    pub angle: Angle<S>,
}

/// The winding over one kick. Voltages are shares of 2R, that is in units of current.
#[derive(Clone, Copy, Debug)]
pub struct Winding<S> {
    /// Current at the end of the kick if nothing is lost.
    pub current: S,
    /// How much of a drop held over the kick is missing from the current at its end; zero asks for
    /// the law at `current` itself.
    pub per_drop: S,
    /// The voltage that the drive holds.
    pub drive: S,
}

impl<S: Scalar> Winding<S> {
    /// The drop of a resistance, given as a share of 2R, that fits the current it leaves.
    #[inline(always)]
    pub fn drop_of(&self, resistance: S) -> S {
        (resistance * self.current).over(S::ONE + resistance * self.per_drop)
    }
}

/// What a limit takes off the current that voltage and back-EMF would settle at, in units of current.
#[derive(Clone, Copy, Debug)]
pub struct Excess<S> {
    /// How much.
    pub value: S,
    /// Derivative with respect to that current, from zero to one.
    pub slope: S,
}

impl<S: Scalar> Excess<S> {
    /// None.
    pub const NONE: Self = Self { value: S::ZERO, slope: S::ZERO };

    /// With what another limit takes off what this one leaves.
    #[inline(always)]
    pub(super) fn then(self, next: Self) -> Self {
        let slope = self.slope + next.slope - self.slope * next.slope;
        Self { value: self.value + next.value, slope }
    }
}

/// By how much the motor constants differ from their nominal values, relative.
#[derive(Clone, Copy, Debug)]
pub struct Constants<S> {
    /// The torque constant.
    pub torque: S,
    /// The back-EMF constant.
    pub back_emf: S,
}

impl<S: Scalar> Constants<S> {
    /// As they are.
    pub const NONE: Self = Self { torque: S::ZERO, back_emf: S::ZERO };

    /// Both: factors one after the other, which keep the constants' sign.
    #[inline(always)]
    pub(super) fn times(self, other: Self) -> Self {
        let both = |own: S, other: S| own + other + own * other;
        Self {
            torque: both(self.torque, other.torque),
            back_emf: both(self.back_emf, other.back_emf),
        }
    }
}

/// What memories follow, held over half a micro-step.
#[derive(Clone, Copy, Debug)]
pub struct Flow<'a, S> {
    /// Current in the winding.
    pub current: S,
    /// The input that the drive holds, in units of current: its voltage as a share of 2R.
    pub drive: S,
    /// Speed of every mass, the rotor first.
    pub speeds: &'a [S],
}

impl<S: Scalar> Flow<'_, S> {
    pub(super) fn speed(&self, mass: usize) -> S {
        self.speeds.get(mass).copied().unwrap_or(S::ZERO)
    }
}

/// How a memory moves over half a micro-step: towards `target`, by `reach` time constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relaxation<S> {
    /// Half a micro-step over the time constant; per second in SI.
    pub reach: S,
    /// Where it tends to.
    pub target: S,
}

/// How every memory moves; one that belongs to no law stays.
pub type Relaxations<S> = [Option<Relaxation<S>>; MEMORIES];

/// Keeps how the memory in a slot moves.
#[inline(always)]
pub(super) fn keep<S>(all: &mut Relaxations<S>, slot: u8, relaxation: Relaxation<S>) {
    if let Some(own) = all.get_mut(usize::from(slot)) {
        *own = Some(relaxation);
    }
}

/// The hooks. One whose `has_` says no is not called.
pub trait Effects<S: Scalar> {
    /// Whether only a run says what it does: then what it may change is a function of its own, once in a
    /// flash, where it costs a call.
    const CHOSEN: bool = false;

    /// Whether [`Effects::torque`] is to be called for this mass: it needs the mass's angle.
    #[inline(always)]
    fn has_torque(&self, _mass: usize) -> bool {
        false
    }

    /// Whether [`Effects::inverse_level`] is to be called: it needs the transmitted torques.
    #[inline(always)]
    fn has_levels(&self) -> bool {
        false
    }

    /// Whether it changes the level of this mass.
    #[inline(always)]
    fn has_level(&self, _mass: usize) -> bool {
        false
    }

    /// Whether that also needs the angles of the masses.
    #[inline(always)]
    fn has_angled_levels(&self) -> bool {
        false
    }

    /// Whether [`Effects::voltage_drop`] is to be called: it needs the kick twice.
    #[inline(always)]
    fn has_drops(&self) -> bool {
        false
    }

    /// Whether [`Effects::excess`] is to be called: it needs the kick twice.
    #[inline(always)]
    fn has_limit(&self) -> bool {
        false
    }

    /// Whether [`Effects::constants`] is to be called.
    #[inline(always)]
    fn has_constants(&self) -> bool {
        false
    }

    /// Whether [`Effects::stage`] or [`Effects::stage_torque`] is to be called: it needs the angles
    /// of the masses.
    #[inline(always)]
    fn has_stages(&self) -> bool {
        false
    }

    /// Whether it acts in this stage.
    #[inline(always)]
    fn has_stage(&self, _stage: usize) -> bool {
        false
    }

    /// Whether [`Effects::viscous`] and [`Effects::drag`] are to be called for this mass.
    #[inline(always)]
    fn has_damping(&self, _mass: usize) -> bool {
        false
    }

    /// Whether there is anything to remember.
    #[inline(always)]
    fn has_memory(&self) -> bool {
        false
    }

    /// Voltage lost on the way to the winding, in units of current.
    #[inline(always)]
    fn voltage_drop(&self, _at: Winding<S>, _memory: &Memory<S>) -> S {
        S::ZERO
    }

    /// What a limit takes off the current that voltage and back-EMF would settle at.
    #[inline(always)]
    fn excess(&self, _settled: S) -> Excess<S> {
        Excess::NONE
    }

    /// The motor constants at a rotor angle and a current.
    #[inline(always)]
    fn constants(&self, _angle: Angle<S>, _current: S) -> Constants<S> {
        Constants::NONE
    }

    /// Current on the way to the winding where the current is the input, from the measured one.
    #[inline(always)]
    fn true_current(&self, measured: S) -> S {
        measured
    }

    /// What the sensor's filter leaves of a current.
    #[inline(always)]
    fn lagged_current(&self, current: S, _memory: &Memory<S>) -> S {
        current
    }

    /// What the sensor shows of a current that its filter has left.
    #[inline(always)]
    fn measured_current(&self, current: S) -> S {
        current
    }

    /// What the sensor shows of a current, its filter included.
    #[inline(always)]
    fn shown_current(&self, current: S, memory: &Memory<S>) -> S {
        self.measured_current(self.lagged_current(current, memory))
    }

    /// What an encoder shows beside the true angle, in its own turns: the motor's, or the output's
    /// where `output` says so. The speed is the shaft's, reflected to the motor.
    #[inline(always)]
    fn encoder_error(&self, _output: bool, _angle: Angle<S>, _speed: S, _: &Memory<S>) -> S {
        S::ZERO
    }

    /// Torque on a mass from its own motion.
    #[inline(always)]
    fn torque(&self, _mass: usize, _at: Motion<S>, _memory: &Memory<S>) -> Torque<S> {
        Torque::NONE
    }

    /// The same of a law with a table, from those of the joint.
    #[inline(always)]
    fn torque_from(
        &self,
        _tables: &Tables<S>,
        mass: usize,
        at: Motion<S>,
        memory: &Memory<S>,
    ) -> Torque<S> {
        self.torque(mass, at, memory)
    }

    /// What a stage's spring feels of its deflection; `input` is the angle of the mass before it,
    /// modulo that mass's own turns.
    #[inline(always)]
    fn stage(&self, _stage: usize, deflection: S, _input: Angle<S>) -> Felt<S> {
        Felt { deflection, contact: S::ONE, leverage: S::ONE }
    }

    /// Torque beside a stage's spring, from the deflection that it feels.
    #[inline(always)]
    fn stage_torque(&self, _stage: usize, _felt: S, _memory: &Memory<S>) -> Torque<S> {
        Torque::NONE
    }

    /// One over the factor on a mass's LuGre level g(v).
    #[inline(always)]
    fn inverse_level(&self, _mass: usize, _at: Rubbing<S>) -> S {
        S::ONE
    }

    /// The same of a law with a table, from those of the joint.
    #[inline(always)]
    fn inverse_level_from(&self, _tables: &Tables<S>, mass: usize, at: Rubbing<S>) -> S {
        self.inverse_level(mass, at)
    }

    /// How a mass's friction gives way below breakaway; only of one whose level it changes.
    #[inline(always)]
    fn creep(&self, _mass: usize) -> Option<Creep<S>> {
        None
    }

    /// Factor on a mass's viscous coefficient.
    #[inline(always)]
    fn viscous(&self, _mass: usize, _speed: S, _memory: &Memory<S>) -> S {
        S::ONE
    }

    /// Damping beside a mass's viscous coefficient, torque per speed.
    #[inline(always)]
    fn drag(&self, _mass: usize, _speed: S) -> S {
        S::ZERO
    }

    /// Says how its memories move.
    #[inline(always)]
    fn relax(&self, _flow: &Flow<'_, S>, _all: &mut Relaxations<S>) {}
}

impl<S: Scalar> Effects<S> for () {}

#[cfg(test)]
mod tests {
    use super::*;

    /// What `E` asks for, and what it leaves of what it is shown.
    fn asked_and_left<E: Effects<f64>>(own: &E) -> ([bool; 11], [f64; 8]) {
        let (memory, angle) = ([0.3; MEMORIES], Angle::default());
        let asked = [
            own.has_torque(0),
            own.has_levels(),
            own.has_level(0),
            own.has_angled_levels(),
            own.has_drops(),
            own.has_limit(),
            own.has_constants(),
            own.has_stages(),
            own.has_stage(0),
            own.has_damping(0),
            own.has_memory(),
        ];
        let winding = Winding { current: 3.0, per_drop: 0.5, drive: 4.0 };
        let rubbing = Rubbing { speed: 2.0, transmitted: 3.0, passed_on: 4.0, angle };
        let left = [
            own.voltage_drop(winding, &memory),
            own.excess(5.0).value,
            own.encoder_error(true, angle, 2.0, &memory),
            own.drag(0, 2.0),
            own.inverse_level(0, rubbing),
            own.viscous(0, 2.0, &memory),
            own.true_current(3.0),
            own.shown_current(3.0, &memory),
        ];
        (asked, left)
    }

    #[test]
    fn without_effects_nothing_is_asked_for_and_nothing_changes() {
        let plain = ([false; 11], [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 3.0, 3.0]);
        assert_eq!(asked_and_left(&()), plain);
    }

    #[test]
    fn laws_of_one_kind_follow_one_another() {
        let felt = |deflection, contact, leverage| Felt { deflection, contact, leverage };
        let both = felt(3.0, 0.5, 3.0).then(felt(2.0, 0.5, 7.0));
        assert_eq!((both.deflection, both.contact, both.leverage), (2.0, 0.25, 21.0));
        // What two limits leave of a change are factors: (1 − 0.5) (1 − 0.25).
        let both = Excess { value: 1.0, slope: 0.5 }.then(Excess { value: 2.0, slope: 0.25 });
        assert_eq!((both.value, both.slope), (3.0, 1.0 - 0.5 * 0.75));
        let winding = Winding { current: 3.0, per_drop: 0.5, drive: 4.0 };
        // The drop of r i is that of the current which it leaves: r (3 − 0.5 d) = d.
        assert_eq!(winding.drop_of(2.0), 3.0);
    }
}
