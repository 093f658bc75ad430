//! A handful of effects chosen at run time, for the host and for firmware that takes them from its
//! parameter block. A joint with a fixed set names its types instead and pays for no dispatch.

use super::hooks::{
    Constants, Effects, Excess, Felt, Flow, MEMORIES, Memory, Motion, Relaxations, Rubbing, Torque,
    Winding,
};
use super::table::{Table, Tables};
use super::worm::Worm;
use super::{Effect, EffectParameters, Kind};
use crate::angle::Angle;
use crate::batch::{Batch, Numbers};
use crate::friction::Creep;
use crate::params::{Load, Location};
use crate::per_unit::Bases;
use crate::scalar::Scalar;
use crate::work::widely;
use heapless::Vec;

/// Most effects one joint has.
pub const MAX_EFFECTS: usize = 12;

type Laws<S> = Vec<Effect<S>, MAX_EFFECTS>;

/// The effects of one joint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EffectSet<S: Scalar> {
    effects: Laws<S>,
    /// Those of the laws that have one, in their order.
    tables: Tables<S>,
    uses: Uses,
}

/// Which hooks a set has, found when it is built, so that the step passes over the others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Uses {
    /// A bit for every mass that a torque acts on, whose level is changed, whose friction creeps or whose damping
    /// is changed, and for every stage.
    torques: u32,
    levels: u32,
    creeps: u32,
    damping: u32,
    stages: u32,
    angled_levels: bool,
    drops: bool,
    limit: bool,
    constants: bool,
    memory: bool,
}

#[inline(always)]
fn is_marked(bits: u32, place: usize) -> bool {
    bits & 1_u32.wrapping_shl(place as u32) != 0
}

impl Uses {
    fn with<S: Scalar>(self, effect: &Effect<S>) -> Self {
        let mut uses = self;
        for place in 0..32_usize {
            law!(effect, law => {
                let mark = |bits: &mut u32, has: bool| *bits |= u32::from(has) << place;
                mark(&mut uses.torques, Effects::<S>::has_torque(law, place));
                mark(&mut uses.levels, Effects::<S>::has_level(law, place));
                mark(&mut uses.creeps, Effects::<S>::creep(law, place).is_some());
                mark(&mut uses.damping, Effects::<S>::has_damping(law, place));
                mark(&mut uses.stages, Effects::<S>::has_stage(law, place));
            });
        }
        law!(effect, law => {
            uses.angled_levels |= Effects::<S>::has_angled_levels(law);
            uses.drops |= Effects::<S>::has_drops(law);
            uses.limit |= Effects::<S>::has_limit(law);
            uses.constants |= Effects::<S>::has_constants(law);
            uses.memory |= Effects::<S>::has_memory(law);
        });
        uses
    }
}

/// Moves transmission errors before all others: teeth stand where they stand before play lies between them.
fn teeth_first<S: Scalar>(laws: &mut [Effect<S>]) {
    let mut ahead = 0;
    for k in 0..laws.len() {
        if let Some(Effect::TransmissionError(_)) = laws.get(k) {
            for at in (ahead..k).rev() {
                let (before, after) = laws.split_at_mut_checked(at + 1).unwrap_or_default();
                if let (Some(one), Some(other)) = (before.last_mut(), after.first_mut()) {
                    core::mem::swap(one, other);
                }
            }
            ahead += 1;
        }
    }
}

impl<S: Scalar> EffectSet<S> {
    fn of(mut effects: Laws<S>, tables: Tables<S>) -> Self {
        teeth_first(&mut effects);
        let uses = effects.iter().fold(Uses::default(), Uses::with);
        Self { effects, tables, uses }
    }
}

impl<U: Scalar<Gain = U>> Batch<U> for EffectSet<f64> {
    type Batched = EffectSet<U>;
    fn batch(&self, numbers: &mut impl Numbers<U>) -> EffectSet<U> {
        let mut effects = Laws::new();
        for effect in &self.effects {
            effects.push(effect.batch(numbers)).ok();
        }
        let tables = self.tables.iter().map(|table| table.batch(numbers)).collect();
        EffectSet { effects, tables, uses: self.uses }
    }
}

impl<S: Scalar> EffectSet<S> {
    /// The laws of these effects, of the load's gravity and of worm stages; `None` where a place does not exist,
    /// or there are more than [`MAX_EFFECTS`], more than [`MEMORIES`] that remember, or more than
    /// [`MAX_TABLES`](super::MAX_TABLES) that have a table.
    pub fn new(effects: &[EffectParameters], load: &Load, bases: &Bases<'_>) -> Option<Self> {
        let mut laws = Laws::new();
        if load.gravity_nm != 0.0 {
            let gravity = EffectParameters::new(Kind::Gravity, Location::Output)
                .with("amplitude_nm", load.gravity_nm)
                .with("phase_rad", load.gravity_phase_rad);
            laws.push(Effect::new(&gravity, bases, [0; 2])?).ok()?;
        }
        for (mass, stage) in bases.stages().iter().enumerate() {
            if let Some(worm) = Worm::new(mass, stage, bases) {
                laws.push(Effect::Worm(worm)).ok()?;
            }
        }
        let (mut slot, mut tables) = (0, Tables::new());
        for effect in effects {
            if effect.kind.remembers() && usize::from(slot) >= MEMORIES {
                return None;
            }
            let slots = [slot, tables.len() as u8];
            laws.push(Effect::new(effect, bases, slots)?).ok()?;
            slot += u8::from(effect.kind.remembers());
            if effect.kind.has_table() {
                tables.push(Table::new(&effect.table, effect.is_periodic())).ok()?;
            }
        }
        Some(Self::of(laws, tables))
    }

    #[inline(never)]
    fn first_creep(&self, mass: usize) -> Option<Creep<S>> {
        self.effects.iter().find_map(|effect| law!(effect, law => law.creep(mass)))
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.effects.is_empty()
    }
}

/// In a parameter block: the laws, and right after them their tables, whose number follows from the laws. A
/// set without a table is its laws, as it was before there were tables.
#[cfg(feature = "serde")]
mod wire {
    use core::fmt;
    use core::marker::PhantomData;

    use serde::de::{Error, SeqAccess, Visitor};
    use serde::ser::SerializeTuple;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::{EffectSet, Laws, Tables};
    use crate::effect::MAX_TABLES;
    use crate::scalar::Scalar;

    impl<S: Scalar> Serialize for EffectSet<S> {
        fn serialize<T: Serializer>(&self, serializer: T) -> Result<T::Ok, T::Error> {
            let mut parts = serializer.serialize_tuple(1 + self.tables.len())?;
            parts.serialize_element(&self.effects)?;
            for table in &self.tables {
                parts.serialize_element(table)?;
            }
            parts.end()
        }
    }

    struct Parts<S>(PhantomData<S>);

    impl<'de, S: Scalar> Visitor<'de> for Parts<S> {
        type Value = EffectSet<S>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("laws and their tables")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut parts: A) -> Result<EffectSet<S>, A::Error> {
            let missing = || A::Error::custom("laws without their tables");
            let effects: Laws<S> = parts.next_element()?.ok_or_else(missing)?;
            let mut tables = Tables::new();
            for _ in effects.iter().filter(|effect| effect.has_table()) {
                let table = parts.next_element()?.ok_or_else(missing)?;
                tables.push(table).map_err(|_| A::Error::custom("too many tables"))?;
            }
            Ok(EffectSet::of(effects, tables))
        }
    }

    impl<'de, S: Scalar> Deserialize<'de> for EffectSet<S> {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            deserializer.deserialize_tuple(1 + MAX_TABLES, Parts(PhantomData))
        }
    }
}

/// Asks every law in turn, as work that a number may have done in its own way: begins with a value, and
/// makes the next one of it and what a law says.
macro_rules! asked {
    (
        $set:ident, ($($name:ident: $type:ty),*) -> $answer:ty,
        $first:expr, |$so_far:ident, $law:ident| $next:expr
    ) => {{
        widely!(<S>(effects: &'a [Effect<S>] = &$set.effects, $($name: $type = $name),*) -> $answer {
            let mut $so_far = $first;
            for effect in effects {
                $so_far = law!(effect, $law => $next);
            }
            $so_far
        })
    }};
}

// What is asked only where its `has_` says so is a function of its own: every number of stages calls
// the same one, and a flash of 128 KiB holds all laws once instead of a dozen times.
impl<S: Scalar> Effects<S> for EffectSet<S> {
    const CHOSEN: bool = true;

    #[inline(always)]
    fn has_torque(&self, mass: usize) -> bool {
        is_marked(self.uses.torques, mass)
    }

    #[inline(always)]
    fn has_levels(&self) -> bool {
        self.uses.levels != 0
    }

    #[inline(always)]
    fn has_level(&self, mass: usize) -> bool {
        is_marked(self.uses.levels, mass)
    }

    #[inline(always)]
    fn has_angled_levels(&self) -> bool {
        self.uses.angled_levels
    }

    #[inline(always)]
    fn has_drops(&self) -> bool {
        self.uses.drops
    }

    #[inline(always)]
    fn has_limit(&self) -> bool {
        self.uses.limit
    }

    #[inline(always)]
    fn has_constants(&self) -> bool {
        self.uses.constants
    }

    #[inline(always)]
    fn has_stages(&self) -> bool {
        self.uses.stages != 0
    }

    #[inline(always)]
    fn has_stage(&self, stage: usize) -> bool {
        is_marked(self.uses.stages, stage)
    }

    #[inline(always)]
    fn has_damping(&self, mass: usize) -> bool {
        is_marked(self.uses.damping, mass)
    }

    #[inline(always)]
    fn has_memory(&self) -> bool {
        self.uses.memory
    }

    #[inline(never)]
    fn voltage_drop(&self, at: Winding<S>, memory: &Memory<S>) -> S {
        asked!(self, (at: Winding<S>, memory: &'a Memory<S>) -> S, S::ZERO,
            |sum, law| sum + law.voltage_drop(at, memory))
    }

    #[inline(never)]
    fn excess(&self, settled: S) -> Excess<S> {
        asked!(self, (settled: S) -> Excess<S>, Excess::NONE,
            |so_far, law| so_far.then(law.excess(settled - so_far.value)))
    }

    #[inline(never)]
    fn constants(&self, angle: Angle<S>, current: S) -> Constants<S> {
        asked!(self, (angle: Angle<S>, current: S) -> Constants<S>, Constants::NONE,
            |both, law| both.times(law.constants(angle, current)))
    }

    #[inline]
    fn true_current(&self, measured: S) -> S {
        let undone = self.effects.iter().rev();
        undone.fold(measured, |current, effect| law!(effect, law => law.true_current(current)))
    }

    #[inline]
    fn lagged_current(&self, current: S, memory: &Memory<S>) -> S {
        let effects = self.effects.iter();
        effects.fold(current, |now, effect| law!(effect, law => law.lagged_current(now, memory)))
    }

    #[inline]
    fn measured_current(&self, current: S) -> S {
        let effects = self.effects.iter();
        effects.fold(current, |current, effect| law!(effect, law => law.measured_current(current)))
    }

    #[inline(never)]
    fn encoder_error(&self, output: bool, angle: Angle<S>, speed: S, memory: &Memory<S>) -> S {
        asked!(self, (output: bool, angle: Angle<S>, speed: S, memory: &'a Memory<S>) -> S, S::ZERO,
            |sum, law| sum + law.encoder_error(output, angle, speed, memory))
    }

    #[inline(never)]
    fn torque(&self, mass: usize, at: Motion<S>, memory: &Memory<S>) -> Torque<S> {
        let tables = &self.tables;
        asked!(self,
            (mass: usize, at: Motion<S>, memory: &'a Memory<S>, tables: &'a Tables<S>) -> Torque<S>,
            Torque::NONE, |sum, law| sum.plus(law.torque_from(tables, mass, at, memory)))
    }

    #[inline(never)]
    fn stage(&self, stage: usize, deflection: S, input: Angle<S>) -> Felt<S> {
        asked!(self, (stage: usize, deflection: S, input: Angle<S>) -> Felt<S>,
            Felt { deflection, contact: S::ONE, leverage: S::ONE },
            |felt, law| felt.then(law.stage(stage, felt.deflection, input)))
    }

    #[inline(never)]
    fn stage_torque(&self, stage: usize, felt: S, memory: &Memory<S>) -> Torque<S> {
        asked!(self, (stage: usize, felt: S, memory: &'a Memory<S>) -> Torque<S>, Torque::NONE,
            |sum, law| sum.plus(law.stage_torque(stage, felt, memory)))
    }

    #[inline(never)]
    fn inverse_level(&self, mass: usize, at: Rubbing<S>) -> S {
        let tables = &self.tables;
        asked!(self, (mass: usize, at: Rubbing<S>, tables: &'a Tables<S>) -> S, S::ONE,
            |level, law| level * law.inverse_level_from(tables, mass, at))
    }

    #[inline(always)]
    fn creep(&self, mass: usize) -> Option<Creep<S>> {
        if is_marked(self.uses.creeps, mass) { self.first_creep(mass) } else { None }
    }

    #[inline(never)]
    fn viscous(&self, mass: usize, speed: S, memory: &Memory<S>) -> S {
        asked!(self, (mass: usize, speed: S, memory: &'a Memory<S>) -> S, S::ONE,
            |factor, law| factor * law.viscous(mass, speed, memory))
    }

    #[inline(never)]
    fn drag(&self, mass: usize, speed: S) -> S {
        asked!(self, (mass: usize, speed: S) -> S, S::ZERO,
            |sum, law| sum + law.drag(mass, speed))
    }

    #[inline(never)]
    fn relax(&self, flow: &Flow<'_, S>, all: &mut Relaxations<S>) {
        asked!(self, (flow: &'a Flow<'a, S>, all: &'a mut Relaxations<S>) -> (), (),
            |_none, law| law.relax(flow, all))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::{Motor, Stage};

    fn set(effects: &[EffectParameters]) -> EffectSet<f64> {
        let stages = [Stage { reduction: 8.0, ..Stage::default() }; 2];
        let motor = Motor { torque_constant_nm_per_a: 1.0, ..Motor::default() };
        EffectSet::new(effects, &Load::default(), &Bases::si(&motor, &stages)).unwrap()
    }

    #[test]
    fn play_lies_between_teeth_in_whatever_order_they_are_listed() {
        let play =
            EffectParameters::new(Kind::Backlash, Location::Stage(1)).with("width_rad", 2e-3);
        let teeth = EffectParameters::new(Kind::TransmissionError, Location::Stage(1))
            .with("amplitude_rad", 3e-4)
            .with("order", 2.0);
        let [one, other] = [[play, teeth], [teeth, play]].map(|effects| set(&effects));
        assert_eq!(one, other);
        // An eighth of a turn is the top of the error, 2.4 mrad at the motor; within the play, 8 mrad to
        // either side, nothing is felt of it.
        let felt = |deflection| one.stage(0, deflection, Angle::from_turns(0.125));
        assert_eq!((felt(5e-3).deflection, felt(5e-3).contact), (0.0, 0.0));
        assert!((felt(16e-3).deflection - 10.4e-3).abs() < 1e-9);
    }

    #[test]
    fn effects_on_the_torque_constant_never_turn_its_sign() {
        let ripple = EffectParameters::new(Kind::TorqueRipple, Location::Motor)
            .with("relative_amplitude", 0.9)
            .with("order", 1.0);
        let saturation =
            EffectParameters::new(Kind::TorqueSaturation, Location::Motor).with("current_a", 1.0);
        for effects in [[ripple, saturation], [saturation, ripple]] {
            let own = set(&effects).constants(Angle::from_turns(0.5), 3.0);
            // A tenth of the magnets' by the ripple, and a tenth of that by the current.
            assert!((own.torque + 0.99).abs() < 1e-9 && (own.back_emf + 0.9).abs() < 1e-9);
        }
    }
}
