//! Friction of another shape than LuGre's: one that gives way below breakaway, and a viscous part that falls
//! behind the speed.
//!
//! The bristle relaxes so that friction in slip is `g(v) tanh(v/w)` ([`Creep`]), and the viscous
//! coefficient becomes `σ2 / (1 + c |v|)`. No law of its own, but the shape of the joint's friction, which a refit
//! finds. Source: Makkar et al., Proc. IEEE/ASME AIM (2005); Cross, "Rheology of non-Newtonian fluids", J. Colloid
//! Science 20 (1965), for a lubricant that is thinned by shear.

use super::hooks::{Effects, Memory};
use super::{ParameterSpec, Place, Spec};
use crate::batch::batch;
use crate::friction::Creep;
use crate::params::Location;
use crate::scalar::Scalar;

/// Name, places and parameters.
pub const SPEC: Spec = Spec {
    kind: "friction-shape",
    locations: &[Location::Motor, Location::Stage(0)],
    parameters: &[
        // w: speed below which friction creeps; sticks at zero.
        ParameterSpec { key: "creep_rad_per_s", default: Some(0.0), low: 0.0, high: 1e9 },
        // c: the viscous coefficient is halved at one over it.
        ParameterSpec { key: "thinning_s_per_rad", default: Some(0.0), low: 0.0, high: 1e9 },
    ],
    example: (Location::Motor, &[("creep_rad_per_s", 20.0), ("thinning_s_per_rad", 2e-4)]),
    table: None,
    remembers: false,
};

/// The law for one mass.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct FrictionShape<S: Scalar> {
    mass: u8,
    creep: Creep<S>,
    thinning: S::Gain,
}

batch!(FrictionShape<Scalar>: creep, thinning; mass);

impl<S: Scalar> FrictionShape<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        Some(Self::new(place.mass, place.values, place.speed.abs()))
    }

    /// From the values of [`SPEC`] and the unit of speed at the mass in rad/s.
    pub fn new(mass: u8, values: &[f64], speed: f64) -> Self {
        let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
        let creep = Creep::new(value(0) / speed);
        Self { mass, creep, thinning: S::gain(value(1) * speed) }
    }
}

impl<S: Scalar> Effects<S> for FrictionShape<S> {
    fn has_damping(&self, mass: usize) -> bool {
        mass == usize::from(self.mass)
    }

    fn has_levels(&self) -> bool {
        true
    }

    fn has_level(&self, mass: usize) -> bool {
        mass == usize::from(self.mass)
    }

    #[inline(always)]
    fn creep(&self, mass: usize) -> Option<Creep<S>> {
        (mass == usize::from(self.mass)).then_some(self.creep)
    }

    #[inline(always)]
    fn viscous(&self, mass: usize, speed: S, _memory: &Memory<S>) -> S {
        if mass == usize::from(self.mass) {
            S::ONE.over(S::ONE + speed.abs().times(self.thinning))
        } else {
            S::ONE
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::hooks::MEMORIES;
    use super::*;

    #[test]
    fn it_creeps_and_thins_at_the_speeds_of_its_own_mass() {
        let law = FrictionShape::<f64>::new(1, &[0.4, 0.5], 2.0);
        let creep = law.creep(1).unwrap();
        // Two units are 4 rad/s: ten w, and three halves of what thins.
        assert!((creep.rate(2.0).0 - 2.0).abs() < 0.01 && creep.rate(0.0).0 == 0.2);
        assert_eq!(law.viscous(1, -2.0, &[0.0; MEMORIES]), 1.0 / 3.0);
        assert_eq!((law.creep(0), law.viscous(0, 2.0, &[0.0; MEMORIES])), (None, 1.0));
        // Without creep it sticks, but for what fixed point can tell from zero.
        let stuck = FrictionShape::<f64>::new(1, &[], 2.0).creep(1).unwrap();
        assert_eq!((stuck.rate(0.0).0, stuck.rate(1e-3).1), (1e-6, 1.0));
    }
}
