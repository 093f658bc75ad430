//! What a joint may have beside its plain equations: one law per file.
//!
//! Each file holds one effect: its equation, where it can sit, its parameters with unit and range,
//! and the per-unit law that both the drive's step and the host's reference call. How an effect is
//! spotted in a log stands in the host harness, not here. To add one: a file beside these and a row in
//! [`for_every_effect`](crate::for_every_effect), the table below.
//!
//! A file declares `SPEC` and the law, a type named as its row says: `at` builds it at an effect's
//! place, and [`Effects`] says where it enters the step.

mod hooks;
mod place;
pub mod table;
pub mod worm;

pub use hooks::{
    Constants, Effects, Excess, Felt, Flow, MEMORIES, Memory, Motion, Relaxation, Relaxations,
    Rubbing, Torque, Winding,
};
pub use set::{EffectSet, MAX_EFFECTS};
pub use table::{Knots, MAX_KNOTS, MAX_TABLES, TableSpec};

use crate::batch::{Batch, Numbers};
use crate::params::{Check, Location, ParameterError, Reason, Table};
use crate::per_unit::Bases;
use crate::scalar::Scalar;
use place::Place;

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
    /// A size that matters on a micromotor of 6 mm with two gear stages, without stopping it: its
    /// place, and the parameters that differ from their defaults. Every effect is checked and priced
    /// at it.
    pub example: (Location, &'static [(&'static str, f64)]),
    /// What its table is like; `None` where it has none.
    pub table: Option<TableSpec>,
    /// Whether the law has a [`Memory`].
    pub remembers: bool,
}

impl Spec {
    /// Whether it concerns what a sensor shows, not what the joint does.
    pub const fn is_of_a_sensor(&self) -> bool {
        matches!(
            self.locations.first(),
            Some(Location::CurrentSensor | Location::Encoder | Location::OutputEncoder)
        )
    }
}

/// The table of effects, a row each, handed to a macro: `for_every_effect!(declare)` calls
/// `declare! { module::Name, … }`. Whoever keeps something for every kind declares it by this table, so
/// that a row without it does not compile.
#[macro_export]
macro_rules! for_every_effect {
    ($declare:ident) => {
        $declare! {
            asymmetric_friction::AsymmetricFriction,
            backlash::Backlash,
            coating::Coating,
            cogging::Cogging,
            current_gain::CurrentGain,
            current_limit::CurrentLimit,
            current_offset::CurrentOffset,
            dead_time::DeadTime,
            drive_efficiency::DriveEfficiency,
            encoder_eccentricity::EncoderEccentricity,
            friction_course::FrictionCourse,
            friction_shape::FrictionShape,
            gravity::Gravity,
            hardening_stiffness::HardeningStiffness,
            input_delay::InputDelay,
            load_dependent_friction::LoadDependentFriction,
            lubricant_warming::LubricantWarming,
            position_dependent_friction::PositionDependentFriction,
            quadratic_drag::QuadraticDrag,
            sensor_delay::SensorDelay,
            sensor_lag::SensorLag,
            structural_hysteresis::StructuralHysteresis,
            supply_sag::SupplySag,
            torque_map::TorqueMap,
            torque_ripple::TorqueRipple,
            torque_saturation::TorqueSaturation,
            transmission_error::TransmissionError,
            winding_heating::WindingHeating,
        }
    };
}

/// Declares the module, the kind and the law of every effect.
macro_rules! effects {
    ($($module:ident :: $name:ident,)+) => {
        $(pub mod $module;)+

        /// The effects by name.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[non_exhaustive]
        pub enum Kind {
            $(#[doc = concat!("[`", stringify!($module), "`].")] $name,)+
        }

        impl Kind {
            /// Every kind, in the order of the names.
            pub const ALL: &'static [Kind] = &[$(Kind::$name,)+];

            /// Name, places and parameters.
            pub const fn spec(self) -> &'static Spec {
                match self {
                    $(Kind::$name => &$module::SPEC,)+
                }
            }
        }

        /// One effect's law, per-unit.
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[cfg_attr(feature = "serde", serde(bound = ""))]
        #[non_exhaustive]
        pub enum Effect<S: Scalar> {
            $(#[doc = concat!("[`", stringify!($module), "`].")] $name($module::$name<S>),)+
            /// The mesh of a worm stage, [`worm`]: a law of the stage, not of an `[[effect]]`.
            Worm(worm::Worm<S>),
        }

        impl<S: Scalar> Effect<S> {
            /// The law in the units of `bases`, with its memory in the first slot and its table in the
            /// second, if it has one; `None` where the place does not exist.
            pub fn new(
                effect: &EffectParameters,
                bases: &Bases<'_>,
                slots: [u8; 2],
            ) -> Option<Self> {
                let place = Place::of(effect, bases, slots)?;
                match effect.kind {
                    $(Kind::$name => $module::$name::at(&place).map(Self::$name),)+
                }
            }
        }

        impl<U: Scalar<Gain = U>> Batch<U> for Effect<f64> {
            type Batched = Effect<U>;
            fn batch(&self, numbers: &mut impl Numbers<U>) -> Effect<U> {
                match self {
                    $(Self::$name(law) => Effect::$name(law.batch(numbers)),)+
                    Self::Worm(law) => Effect::Worm(law.batch(numbers)),
                }
            }
        }

        /// Calls a hook of whatever law an [`Effect`] is.
        macro_rules! law {
            ($effect:expr, $law:ident => $call:expr) => {
                match $effect {
                    $($crate::effect::Effect::$name($law) => $call,)+
                    $crate::effect::Effect::Worm($law) => $call,
                }
            };
        }
    };
}

for_every_effect!(effects);

mod set;

#[cfg(any(test, feature = "serde"))]
impl<S: Scalar> Effect<S> {
    /// Whether the law looks into a table.
    pub(crate) fn has_table(&self) -> bool {
        matches!(self, Self::FrictionCourse(_) | Self::TorqueMap(_))
    }
}

impl Kind {
    /// Whether the law has a [`Memory`].
    pub const fn remembers(self) -> bool {
        self.spec().remembers
    }

    /// Whether the law has a table.
    pub const fn has_table(self) -> bool {
        self.spec().table.is_some()
    }

    /// Whether the law says what is there without saying why: nothing is known by it.
    pub const fn is_unnamed(self) -> bool {
        matches!(self, Kind::TorqueMap)
    }

    /// Whether the law concerns what a sensor shows, not what the joint does.
    pub const fn is_of_a_sensor(self) -> bool {
        self.spec().is_of_a_sensor()
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
    /// The knots of its table; none where its kind has none.
    pub table: Knots,
}

impl EffectParameters {
    /// An effect with the default of every parameter that has one, and zero for the others.
    pub fn new(kind: Kind, location: Location) -> Self {
        let mut values = [0.0; MAX_VALUES];
        for (value, spec) in values.iter_mut().zip(kind.spec().parameters) {
            *value = spec.default.unwrap_or(0.0);
        }
        Self { kind, location, values, table: Knots::NONE }
    }

    /// An effect of this kind as its spec's example says: of a size that matters on a micromotor.
    pub fn example(kind: Kind) -> Self {
        let (location, values) = kind.spec().example;
        let mut example = Self::new(kind, location);
        if let Some(TableSpec { example: [forward, backward], .. }) = &kind.spec().table {
            example.table = Knots::new(forward, backward).unwrap_or_default();
        }
        values.iter().fold(example, |effect, (key, value)| effect.with(key, *value))
    }

    /// The same effect with these knots, those of the negative direction empty where they are the same;
    /// `None` where both directions have another number of them, or a table has no room for so many.
    pub fn with_table(mut self, forward: &[f64], backward: &[f64]) -> Option<Self> {
        self.table = Knots::new(forward, backward)?;
        Some(self)
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
        if let Some(spec) = &self.kind.spec().table {
            self.table.validate(spec, &check)?;
        }
        match self.kind {
            Kind::FrictionCourse => friction_course::validate(&self.values, &self.table, &check),
            Kind::TorqueMap => torque_map::validate(&self.values, &self.table, &check),
            _ => Ok(()),
        }
    }

    /// Whether its table ends where it begins.
    pub(crate) fn is_periodic(&self) -> bool {
        match self.kind {
            Kind::FrictionCourse => friction_course::is_periodic(&self.values),
            Kind::TorqueMap => torque_map::is_periodic(&self.values),
            _ => false,
        }
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
    if let Some((k, _)) =
        effects.iter().enumerate().filter(|(_, effect)| effect.kind.has_table()).nth(MAX_TABLES)
    {
        let reason = Reason::TooManyTables { most: MAX_TABLES };
        return Err(Check(Table::Effect(k + 1)).fail("kind", effects.len() as f64, reason));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::{Motor, Stage};

    #[test]
    fn every_spec_says_of_its_law_whether_it_remembers_and_where_it_acts() {
        let stages = [Stage { reduction: 8.0, ..Stage::default() }; 2];
        let motor = Motor { torque_constant_nm_per_a: 1.0, ..Motor::default() };
        let bases = Bases::si(&motor, &stages);
        for kind in Kind::ALL {
            let (name, spec) = (kind.spec().kind, kind.spec());
            let law = Effect::<f64>::new(&EffectParameters::example(*kind), &bases, [0; 2]);
            let Some(law) = law else { panic!("{name}: there is no place for its example") };
            let remembers = law!(&law, law => Effects::<f64>::has_memory(law));
            assert_eq!(remembers, spec.remembers, "{name}: `remembers` of its spec");
            let [levels, stages] = law!(&law, law => [
                (Effects::<f64>::has_levels(law), (0..9).any(|at| Effects::<f64>::has_level(law, at))),
                (Effects::<f64>::has_stages(law), (0..9).any(|at| Effects::<f64>::has_stage(law, at))),
            ]);
            assert!(levels.0 == levels.1 && stages.0 == stages.1, "{name}: of none, or of some");
            assert_eq!(Kind::from_name(name), Some(*kind));
            assert_eq!(law.has_table(), kind.has_table(), "{name}: `has_table` of its law");
            let of_a_sensor = |place: &Location| {
                use Location::{CurrentSensor, Encoder, OutputEncoder};
                matches!(place, CurrentSensor | Encoder | OutputEncoder)
            };
            let mut places = spec.locations.iter();
            let same = places.all(|place| of_a_sensor(place) == spec.is_of_a_sensor());
            assert!(same, "{name}: a sensor's law sits at sensors alone");
        }
    }

    #[test]
    fn the_ends_of_a_range_belong_to_it() {
        let drag = |value| {
            EffectParameters::new(Kind::QuadraticDrag, Location::Motor)
                .with("coefficient_nm_s2", value)
        };
        let spec = Kind::QuadraticDrag.spec().parameters[0];
        let refused = |value| validate(&[drag(spec.low), drag(value)], 0).map_err(|it| it.table);
        assert_eq!([refused(spec.low), refused(spec.high)], [Ok(()); 2]);
        for value in [spec.low - 1.0, 2.0 * spec.high, f64::NAN] {
            assert_eq!(refused(value), Err(Table::Effect(2)));
        }
    }
}
