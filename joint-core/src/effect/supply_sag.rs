//! Supply sag: a bus that gives way under the power it is asked for.
//!
//! `u (1 − r u i / V²)` with r the resistance of the source and V the bus voltage at no load: the
//! bus carries duty times current, and the winding sees duty times bus. Source: the average model of
//! a bridge, Erickson and Maksimović, "Fundamentals of Power Electronics".

use super::hooks::{Effects, Memory, Winding};
use super::{ParameterSpec, Place, Spec};
use crate::batch::batch;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "supply-sag",
    locations: &[Location::Inverter],
    parameters: &[
        ParameterSpec { key: "source_resistance_ohm", default: None, low: 0.0, high: 1e6 },
        ParameterSpec { key: "bus_voltage_v", default: None, low: 1e-9, high: 1e6 },
    ],
    example: (Location::Inverter, &[("source_resistance_ohm", 1.0), ("bus_voltage_v", 6.0)]),
    table: None,
    remembers: false,
};

/// The law.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct SupplySag<S: Scalar> {
    per_drive: S::Gain,
}

batch!(SupplySag<Scalar>: per_drive);

impl<S: Scalar> SupplySag<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.values, place.resistance, place.current))
    }

    /// From the values of [`SPEC`], the winding's 2R in ohm and the unit of current in A.
    pub fn new(values: &[f64], resistance: f64, current: f64) -> Self {
        let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
        let duty = resistance * current / value(1);
        let share = if resistance > 0.0 { value(0) / resistance } else { 0.0 };
        Self { per_drive: S::gain(libm::sqrt(share) * duty) }
    }
}

impl<S: Scalar> Effects<S> for SupplySag<S> {
    fn has_drops(&self) -> bool {
        true
    }

    #[inline(always)]
    fn voltage_drop(&self, at: Winding<S>, _memory: &Memory<S>) -> S {
        let duty = at.drive.times(self.per_drive);
        at.drop_of(duty * duty)
    }
}

#[cfg(test)]
mod tests {
    use super::super::hooks::MEMORIES;
    use super::*;

    #[test]
    fn the_drop_is_the_equation() {
        let (r, bus, resistance, u, i) = (0.4, 24.0, 3.0, -9.0, -2.0);
        let law = SupplySag::<f64>::new(&[r, bus], resistance, 1.0);
        let at = Winding { current: i, per_drop: 0.0, drive: u / resistance };
        let drop = law.voltage_drop(at, &[0.0; MEMORIES]) * resistance;
        assert!((drop - u * r * u * i / (bus * bus)).abs() < 1e-12);
    }
}
