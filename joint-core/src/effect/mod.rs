//! What a joint may have beside its plain equations: one law per file.
//!
//! Each file holds one effect: its equation, where it can sit, its parameters with unit and range,
//! and the per-unit law that both the drive's step and the host's reference call. How an effect is
//! spotted in a log stands in the host harness, not here. To add one: a file beside these, a
//! variant in [`Kind`] and in [`Effect`], and in `EffectSet` a line in `Uses` and one in
//! [`Effects`] where its law enters the equations.

pub mod asymmetric_friction;
pub mod backlash;
pub mod cogging;
pub mod current_offset;
pub mod dead_time;
pub mod gravity;
pub mod load_dependent_friction;
mod set;

pub(crate) use set::mass_at;
pub use set::{Effect, EffectSet, MAX_EFFECTS};

use crate::angle::Angle;
use crate::params::{Check, Location, ParameterError, Reason, Table};
use crate::scalar::Scalar;

/// Most values one effect has.
pub const MAX_VALUES: usize = 6;

/// One parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterSpec {
    /// Key in the model file, with its unit.
    pub key: &'static str,
    /// Taken where the key is left out; `None` makes the key required.
    pub default: Option<f64>,
    /// Smallest admissible value.
    pub low: f64,
    /// Largest admissible value.
    pub high: f64,
}

/// An effect's name, places and parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spec {
    /// Name in the model file.
    pub kind: &'static str,
    /// Places where it can sit; `Location::Stage(0)` stands for every stage.
    pub locations: &'static [Location],
    /// Its parameters, in the order of [`EffectParameters::values`].
    pub parameters: &'static [ParameterSpec],
}

/// The effects by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Kind {
    /// [`asymmetric_friction`].
    AsymmetricFriction,
    /// [`backlash`].
    Backlash,
    /// [`cogging`].
    Cogging,
    /// [`current_offset`].
    CurrentOffset,
    /// [`dead_time`].
    DeadTime,
    /// [`gravity`].
    Gravity,
    /// [`load_dependent_friction`].
    LoadDependentFriction,
}

impl Kind {
    /// Every kind, in the order of the names.
    pub const ALL: &'static [Kind] = &[
        Kind::AsymmetricFriction,
        Kind::Backlash,
        Kind::Cogging,
        Kind::CurrentOffset,
        Kind::DeadTime,
        Kind::Gravity,
        Kind::LoadDependentFriction,
    ];

    /// Name, places and parameters.
    pub const fn spec(self) -> &'static Spec {
        match self {
            Kind::AsymmetricFriction => &asymmetric_friction::SPEC,
            Kind::Backlash => &backlash::SPEC,
            Kind::Cogging => &cogging::SPEC,
            Kind::CurrentOffset => &current_offset::SPEC,
            Kind::DeadTime => &dead_time::SPEC,
            Kind::Gravity => &gravity::SPEC,
            Kind::LoadDependentFriction => &load_dependent_friction::SPEC,
        }
    }

    /// The kind with this name in the model file.
    pub fn from_name(name: &str) -> Option<Kind> {
        Kind::ALL.iter().copied().find(|kind| kind.spec().kind == name)
    }
}

/// An effect in SI units: what it is, where it sits, how large it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectParameters {
    /// What it is.
    pub kind: Kind,
    /// Where it sits.
    pub location: Location,
    /// Its values in the order of its [`Spec`]; those past the last parameter are zero.
    pub values: [f64; MAX_VALUES],
}

impl EffectParameters {
    /// An effect with the default of every parameter that has one, and zero for the others.
    pub fn new(kind: Kind, location: Location) -> Self {
        let mut values = [0.0; MAX_VALUES];
        for (value, spec) in values.iter_mut().zip(kind.spec().parameters) {
            *value = spec.default.unwrap_or(0.0);
        }
        Self { kind, location, values }
    }

    /// The same effect with the parameter of this key changed; an unknown key changes nothing.
    #[must_use]
    pub fn with(mut self, key: &str, value: f64) -> Self {
        for (slot, spec) in self.values.iter_mut().zip(self.kind.spec().parameters) {
            if spec.key == key {
                *slot = value;
            }
        }
        self
    }

    /// The parameter of this key.
    pub fn get(&self, key: &str) -> Option<f64> {
        let specs = self.kind.spec().parameters;
        self.values.iter().zip(specs).find(|(_, spec)| spec.key == key).map(|(value, _)| *value)
    }

    /// Whether this kind can sit at this place of a joint with that many stages.
    pub fn admits(kind: Kind, location: Location, stages: usize) -> bool {
        kind.spec().locations.iter().any(|place| match (place, location) {
            (Location::Stage(_), Location::Stage(k)) => k >= 1 && usize::from(k) <= stages,
            (place, location) => *place == location,
        })
    }

    /// Checks the values; `number` is the effect's place in the model file, from 1.
    ///
    /// # Errors
    /// The first value that is not finite or out of its range.
    pub fn validate(&self, number: usize) -> Result<(), ParameterError> {
        let check = Check(Table::Effect(number));
        for (value, spec) in self.values.iter().zip(self.kind.spec().parameters) {
            check.finite(spec.key, *value)?;
            if *value < spec.low || *value > spec.high {
                let reason = Reason::OutOfRange { low: spec.low, high: spec.high };
                return Err(check.fail(spec.key, *value, reason));
            }
        }
        Ok(())
    }
}

/// Checks the effects of a joint with that many stages.
///
/// # Errors
/// The first value out of its range, or place that the joint does not have.
pub fn validate(effects: &[EffectParameters], stages: usize) -> Result<(), ParameterError> {
    for (k, effect) in effects.iter().enumerate() {
        effect.validate(k + 1)?;
        if !EffectParameters::admits(effect.kind, effect.location, stages) {
            let value = match effect.location {
                Location::Stage(number) => f64::from(number),
                _ => 0.0,
            };
            return Err(Check(Table::Effect(k + 1)).fail("location", value, Reason::NoSuchPlace));
        }
    }
    if effects.len() >= MAX_EFFECTS {
        let check = Check(Table::Effect(MAX_EFFECTS));
        return Err(check.fail(
            "kind",
            effects.len() as f64,
            Reason::TooMany { most: MAX_EFFECTS - 1 },
        ));
    }
    Ok(())
}

/// The motion of one mass, for a law that needs it. The speed is per-unit and reflected to the
/// motor; the angle is the mass's own.
#[derive(Clone, Copy, Debug)]
pub struct Motion<S> {
    /// Angle of this mass in its own turns.
    pub angle: Angle<S>,
    /// Speed of this mass.
    pub speed: S,
}

/// A torque and what it changes by with the angle it depends on.
#[derive(Clone, Copy, Debug)]
pub struct Torque<S> {
    /// Torque on the mass, positive with motion.
    pub value: S,
    /// Derivative with respect to the mass's angle.
    pub slope: S,
}

/// Where effects enter the step. Every method has a default that changes nothing, and a joint with
/// the effects `()` compiles to the plain equations. A law whose hook has a `has_` beside it is
/// called only where that says so.
///
/// Masses count from 0 at the rotor, stages from 0 at the motor. All quantities are per-unit and
/// reflected to the motor shaft.
pub trait Effects<S: Scalar> {
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

    /// Whether [`Effects::voltage_drop`] is to be called: it needs the kick twice.
    #[inline(always)]
    fn has_drops(&self) -> bool {
        false
    }

    /// Voltage lost on the way to the winding, as its share of 2R, that is in units of current:
    /// `current` is what flows at the end of the interval without this loss, and `per_drop` how much
    /// of a drop held over the interval is missing from it at the end. With `per_drop` zero the
    /// law is evaluated at `current` itself.
    fn voltage_drop(&self, _current: S, _per_drop: S) -> S {
        S::ZERO
    }

    /// Current on the way to the winding where the current is the input, from the measured one.
    fn true_current(&self, measured: S) -> S {
        measured
    }

    /// What the sensor shows of a current.
    fn measured_current(&self, current: S) -> S {
        current
    }

    /// Torque on a mass from its own motion.
    fn torque(&self, _mass: usize, _at: Motion<S>) -> Torque<S> {
        Torque { value: S::ZERO, slope: S::ZERO }
    }

    /// The deflection that a stage's spring feels, and its derivative with the geometric one.
    fn deflection(&self, _stage: usize, deflection: S) -> (S, S) {
        (deflection, S::ONE)
    }

    /// One over the factor on a mass's LuGre level g(v); `transmitted` is the torque that the mass
    /// passes on (its stage's torque, spring and damper; the motor torque for the rotor).
    fn inverse_level(&self, _mass: usize, _speed: S, _transmitted: S) -> S {
        S::ONE
    }

    /// Factor on a mass's viscous coefficient.
    fn viscous(&self, _mass: usize, _speed: S) -> S {
        S::ONE
    }
}

impl<S: Scalar> Effects<S> for () {}
