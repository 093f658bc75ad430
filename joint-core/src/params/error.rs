//! Values that the equations cannot take: where they stand, and why they are refused.

use core::fmt;

/// The table of the model file in which an inadmissible value stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Table {
    /// `[motor]`.
    Motor,
    /// `[motor.friction]`.
    MotorFriction,
    /// The stage with this number, from 1.
    Stage(usize),
    /// The friction of the stage with this number, from 1.
    StageFriction(usize),
    /// `[load]`.
    Load,
    /// The effect with this number, from 1.
    Effect(usize),
    /// The amplifier of the three-phase motor; not a table of the model file.
    Amplifier,
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Table::Motor => f.write_str("[motor]"),
            Table::MotorFriction => f.write_str("[motor.friction]"),
            Table::Stage(k) => write!(f, "[[stage]] number {k}"),
            Table::StageFriction(k) => write!(f, "[stage.friction] of stage {k}"),
            Table::Load => f.write_str("[load]"),
            Table::Effect(k) => write!(f, "[[effect]] number {k}"),
            Table::Amplifier => f.write_str("amplifier"),
        }
    }
}

/// Why a value is not admissible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reason {
    /// NaN or infinite.
    NotFinite,
    /// Must be zero or more.
    Negative,
    /// Must be more than zero.
    NotPositive,
    /// Must not be zero.
    Zero,
    /// k_t = 2 k_e is broken by more than one per cent: the motor would create or destroy power.
    PowerBalance {
        /// The value that k_t asks for.
        expected: f64,
    },
    /// The joint has no such place for this effect.
    NoSuchPlace,
    /// Only a joint with an effect set has this law.
    NeedsEffectSet,
    /// There may be this many.
    TooMany {
        /// Most there may be.
        most: usize,
    },
    /// There must be so many knots.
    Knots {
        /// Fewest there may be.
        least: usize,
        /// Most there may be.
        most: usize,
    },
    /// There may be this many effects with a table.
    TooManyTables {
        /// Most there may be.
        most: usize,
    },
    /// Just one of the keys that say over what the knots stand must be above zero.
    NotOneOf,
    /// Must lie in this closed range.
    OutOfRange {
        /// Smallest admissible value.
        low: f64,
        /// Largest admissible value.
        high: f64,
    },
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Reason::NotFinite => f.write_str("must be a finite number"),
            Reason::Negative => f.write_str("must be zero or more"),
            Reason::NotPositive => f.write_str("must be more than zero"),
            Reason::Zero => f.write_str("must not be zero"),
            Reason::PowerBalance { expected } => write!(
                f,
                "breaks the power balance k_t = 2 k_e: expected {expected} (leave the key out to have it so)"
            ),
            Reason::NoSuchPlace => f.write_str("this effect cannot sit there in this joint"),
            Reason::NeedsEffectSet => {
                f.write_str("needs a joint with an effect set: Joint<S, N, EffectSet<S>>")
            }
            Reason::TooMany { most } => write!(f, "at most {most} effects fit one joint"),
            Reason::Knots { least, most } => write!(f, "knots: there must be {least} to {most}"),
            Reason::TooManyTables { most } => {
                write!(f, "at most {most} effects with a table fit one joint")
            }
            Reason::NotOneOf => f.write_str(
                "just one of the span, the period and, of a torque map, the speed must be above zero",
            ),
            Reason::OutOfRange { low, high } => write!(f, "must lie between {low} and {high}"),
        }
    }
}

/// A value that the equations cannot take: where it stands, its key, the value, and why.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterError {
    /// The table in which it stands.
    pub table: Table,
    /// Its key.
    pub key: &'static str,
    /// The offending value.
    pub value: f64,
    /// What is wrong with it.
    pub reason: Reason,
}

impl fmt::Display for ParameterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} = {}: {}", self.table, self.key, self.value, self.reason)
    }
}

impl core::error::Error for ParameterError {}

/// One table under validation; each check names its key.
#[derive(Clone, Copy)]
pub(crate) struct Check(pub(crate) Table);

impl Check {
    pub(crate) fn fail(self, key: &'static str, value: f64, reason: Reason) -> ParameterError {
        ParameterError { table: self.0, key, value, reason }
    }

    pub(crate) fn finite(self, key: &'static str, value: f64) -> Result<(), ParameterError> {
        if value.is_finite() { Ok(()) } else { Err(self.fail(key, value, Reason::NotFinite)) }
    }

    pub(crate) fn not_negative(self, key: &'static str, value: f64) -> Result<(), ParameterError> {
        self.finite(key, value)?;
        if value < 0.0 { Err(self.fail(key, value, Reason::Negative)) } else { Ok(()) }
    }

    pub(crate) fn positive(self, key: &'static str, value: f64) -> Result<(), ParameterError> {
        self.finite(key, value)?;
        if value > 0.0 { Ok(()) } else { Err(self.fail(key, value, Reason::NotPositive)) }
    }
}
