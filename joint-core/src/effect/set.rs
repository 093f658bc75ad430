//! A handful of effects chosen at run time, for the host and for firmware that takes them from its
//! parameter block. A joint with a fixed set names its types instead and pays for no dispatch.

use super::asymmetric_friction::AsymmetricFriction;
use super::backlash::Backlash;
use super::cogging::Cogging;
use super::current_offset::CurrentOffset;
use super::dead_time::DeadTime;
use super::gravity::Gravity;
use super::load_dependent_friction::LoadDependentFriction;
use super::{EffectParameters, Effects, Kind, Motion, Torque};
use crate::params::{Load, Location};
use crate::per_unit::Bases;
use crate::scalar::Scalar;
use heapless::Vec;

/// Most effects one joint has.
pub const MAX_EFFECTS: usize = 12;

/// One effect's law, per-unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
#[non_exhaustive]
pub enum Effect<S: Scalar> {
    /// Friction that differs by direction.
    AsymmetricFriction(AsymmetricFriction<S>),
    /// Play in a stage.
    Backlash(Backlash<S>),
    /// Torque that follows the rotor angle.
    Cogging(Cogging<S>),
    /// A current sensor's zero.
    CurrentOffset(CurrentOffset<S>),
    /// Voltage lost against the current's sign.
    DeadTime(DeadTime<S>),
    /// A pendulum.
    Gravity(Gravity<S>),
    /// Friction that grows with the torque passed on.
    LoadDependentFriction(LoadDependentFriction<S>),
}

impl<S: Scalar> Effect<S> {
    /// The law in the units of `bases`; `None` where the place does not exist.
    pub fn new(effect: &EffectParameters, bases: &Bases<'_>) -> Option<Self> {
        let values = &effect.values;
        let mass = bases.mass(effect.location)?;
        let index = u8::try_from(mass).ok()?;
        let (torque, angle) = (bases.torque_at(mass), bases.angle_at(mass));
        Some(match effect.kind {
            Kind::AsymmetricFriction => {
                let reversed = bases.shaft(mass) < 0.0;
                Self::AsymmetricFriction(AsymmetricFriction::new(index, values, reversed))
            }
            Kind::Backlash => {
                Self::Backlash(Backlash::new(index.checked_sub(1)?, values, angle.abs()))
            }
            Kind::Cogging => Self::Cogging(Cogging::new(values, torque, angle)),
            Kind::CurrentOffset => Self::CurrentOffset(CurrentOffset::new(values, bases.current)),
            Kind::DeadTime => {
                Self::DeadTime(DeadTime::new(values, bases.resistance, bases.current))
            }
            Kind::Gravity => Self::Gravity(Gravity::new(index, values, torque, angle)),
            Kind::LoadDependentFriction => {
                let coulomb = bases.coulomb_at(mass);
                let law = LoadDependentFriction::new(index, values, coulomb, torque.abs());
                Self::LoadDependentFriction(law)
            }
        })
    }
}

type Laws<S> = Vec<Effect<S>, MAX_EFFECTS>;

/// The effects of one joint.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = "", from = "Laws<S>", into = "Laws<S>"))]
pub struct EffectSet<S: Scalar> {
    effects: Laws<S>,
    uses: Uses,
}

/// Which laws a set has, found when it is built, so that the step passes over the others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Uses {
    /// A bit for every mass that a torque acts on.
    torques: u32,
    levels: bool,
    viscous: bool,
    deflections: bool,
    drops: bool,
}

impl Uses {
    fn with<S: Scalar>(self, effect: &Effect<S>) -> Self {
        match effect {
            Effect::AsymmetricFriction(_) => Self { levels: true, viscous: true, ..self },
            Effect::Backlash(_) => Self { deflections: true, ..self },
            Effect::Cogging(_) => Self { torques: self.torques | 1, ..self },
            Effect::CurrentOffset(_) => self,
            Effect::DeadTime(_) => Self { drops: true, ..self },
            Effect::Gravity(law) => {
                Self { torques: self.torques | 1_u32.wrapping_shl(u32::from(law.mass)), ..self }
            }
            Effect::LoadDependentFriction(_) => Self { levels: true, ..self },
        }
    }
}

impl<S: Scalar> From<Laws<S>> for EffectSet<S> {
    fn from(effects: Laws<S>) -> Self {
        let uses = effects.iter().fold(Uses::default(), Uses::with);
        Self { effects, uses }
    }
}

impl<S: Scalar> From<EffectSet<S>> for Laws<S> {
    fn from(set: EffectSet<S>) -> Self {
        set.effects
    }
}

impl<S: Scalar> EffectSet<S> {
    /// The laws of these effects and of the load's gravity; `None` where a place does not exist
    /// or there are more than [`MAX_EFFECTS`].
    pub fn new(effects: &[EffectParameters], load: &Load, bases: &Bases<'_>) -> Option<Self> {
        let mut laws = Laws::new();
        if load.gravity_nm != 0.0 {
            let gravity = EffectParameters::new(Kind::Gravity, Location::Output)
                .with("amplitude_nm", load.gravity_nm)
                .with("phase_rad", load.gravity_phase_rad);
            laws.push(Effect::new(&gravity, bases)?).ok()?;
        }
        for effect in effects {
            laws.push(Effect::new(effect, bases)?).ok()?;
        }
        Some(laws.into())
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.effects.is_empty()
    }
}

impl<S: Scalar> Effects<S> for EffectSet<S> {
    #[inline(always)]
    fn has_torque(&self, mass: usize) -> bool {
        self.uses.torques & 1_u32.wrapping_shl(mass as u32) != 0
    }

    #[inline(always)]
    fn has_levels(&self) -> bool {
        self.uses.levels
    }

    #[inline(always)]
    fn has_drops(&self) -> bool {
        self.uses.drops
    }

    #[inline]
    fn voltage_drop(&self, current: S, per_drop: S) -> S {
        self.effects.iter().fold(S::ZERO, |sum, effect| match effect {
            Effect::DeadTime(law) => sum + law.drop(current, per_drop),
            _ => sum,
        })
    }

    #[inline]
    fn true_current(&self, measured: S) -> S {
        self.effects.iter().fold(measured, |current, effect| match effect {
            Effect::CurrentOffset(law) => law.actual(current),
            _ => current,
        })
    }

    #[inline]
    fn measured_current(&self, current: S) -> S {
        self.effects.iter().fold(current, |current, effect| match effect {
            Effect::CurrentOffset(law) => law.measured(current),
            _ => current,
        })
    }

    #[inline]
    fn torque(&self, mass: usize, at: Motion<S>) -> Torque<S> {
        let none = Torque { value: S::ZERO, slope: S::ZERO };
        self.effects.iter().fold(none, |sum, effect| {
            let torque = match effect {
                Effect::Cogging(law) if mass == 0 => law.torque(at),
                Effect::Gravity(law) if mass == usize::from(law.mass) => law.torque(at),
                _ => return sum,
            };
            Torque { value: sum.value + torque.value, slope: sum.slope + torque.slope }
        })
    }

    #[inline]
    fn deflection(&self, stage: usize, deflection: S) -> (S, S) {
        if !self.uses.deflections {
            return (deflection, S::ONE);
        }
        self.effects.iter().fold((deflection, S::ONE), |(felt, slope), effect| match effect {
            Effect::Backlash(law) if stage == usize::from(law.stage) => {
                let (felt, own) = law.deflection(felt);
                (felt, slope * own)
            }
            _ => (felt, slope),
        })
    }

    #[inline]
    fn inverse_level(&self, mass: usize, speed: S, transmitted: S) -> S {
        self.effects.iter().fold(S::ONE, |level, effect| match effect {
            Effect::AsymmetricFriction(law) if mass == usize::from(law.mass) => {
                level * law.inverse_level(speed)
            }
            Effect::LoadDependentFriction(law) if mass == usize::from(law.mass) => {
                level * law.inverse_level(transmitted)
            }
            _ => level,
        })
    }

    #[inline]
    fn viscous(&self, mass: usize, speed: S) -> S {
        if !self.uses.viscous {
            return S::ONE;
        }
        self.effects.iter().fold(S::ONE, |factor, effect| match effect {
            Effect::AsymmetricFriction(law) if mass == usize::from(law.mass) => {
                factor * law.viscous(speed)
            }
            _ => factor,
        })
    }
}

/// The place of an effect among the masses: its own number for the rotor and the stages, the last
/// one for the output.
pub(crate) fn mass_at(location: Location, stages: usize) -> Option<usize> {
    match location {
        Location::Stage(k) => {
            let k = usize::from(k);
            (k >= 1 && k <= stages).then_some(k)
        }
        Location::Output | Location::OutputEncoder => Some(stages),
        Location::Motor | Location::Inverter | Location::CurrentSensor | Location::Encoder => {
            Some(0)
        }
    }
}
