//! The signals of a log, under the short names that a map uses.

use super::unit::Quantity;
use crate::log::KNOWN;

/// A signal that a map fills.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Signal {
    /// Time.
    Time,
    /// DC-equivalent voltage on the two conducting phases.
    Voltage,
    /// Motor current.
    Current,
    /// Rotor angle.
    Motor,
    /// Angle behind the last gear stage.
    Output,
    /// Known load at the output.
    Load,
    /// Bus voltage.
    Bus,
    /// Temperature.
    Temperature,
    /// Reference angle.
    Reference,
}

impl Signal {
    /// All of them, in the order of a log's columns.
    pub const ALL: [Signal; 9] = [
        Signal::Time,
        Signal::Voltage,
        Signal::Current,
        Signal::Motor,
        Signal::Output,
        Signal::Load,
        Signal::Bus,
        Signal::Temperature,
        Signal::Reference,
    ];

    /// Its name in a map.
    pub fn key(self) -> &'static str {
        match self {
            Signal::Time => "t",
            Signal::Voltage => "u",
            Signal::Current => "i",
            Signal::Motor => "motor",
            Signal::Output => "output",
            Signal::Load => "load",
            Signal::Bus => "bus",
            Signal::Temperature => "temperature",
            Signal::Reference => "reference",
        }
    }

    /// Its column in a log.
    pub fn column(self) -> &'static str {
        KNOWN[self as usize]
    }

    /// What it measures.
    pub fn quantity(self) -> Quantity {
        match self {
            Signal::Time => Quantity::Time,
            Signal::Voltage | Signal::Bus => Quantity::Voltage,
            Signal::Current => Quantity::Current,
            Signal::Motor | Signal::Output | Signal::Reference => Quantity::Angle,
            Signal::Load => Quantity::Torque,
            Signal::Temperature => Quantity::Temperature,
        }
    }

    /// Whether its value holds until the next sample, as that of an input does.
    pub fn is_held(self) -> bool {
        self == Signal::Voltage
    }

    /// A signal by its name in a map, or by its column in a log.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|signal| name == signal.key() || name == signal.column())
    }

    /// All names, for a message.
    pub fn names() -> String {
        Self::ALL.map(Signal::key).join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_column_of_a_log_is_a_signal_in_the_same_order() {
        assert_eq!(Signal::ALL.map(Signal::column), KNOWN);
        for signal in Signal::ALL {
            assert_eq!(Signal::named(signal.key()), Some(signal));
            assert_eq!(Signal::named(signal.column()), Some(signal));
        }
        assert_eq!(Signal::named("torque"), None);
    }
}
