//! Friction of other families than the model's, for joints that a model has to be held against.
//!
//! A program that finds effects in joints whose friction is its own learns nothing of what it does
//! elsewhere. The laws here are the field's other ones. All take the model's six friction
//! parameters, so that the same joint can be run under each: the Stribeck curve
//! g(v) = α0 + α1 exp(−|v/v0|^δ) is their sliding level, σ0 their stiffness from rest (but
//! [`tanh`]'s, which has none), σ2 their viscous coefficient. Everything is at the motor shaft, in
//! Nm, rad and s. Nothing here runs on the drive.

pub mod elastoplastic;
pub mod limited_viscous;
pub mod maxwell_slip;
pub mod tanh;
#[cfg(test)]
mod tests;

/// A family of friction laws with what is its own.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Family {
    /// The model's own (Canudas de Wit, Olsson, Åström, Lischinsky, IEEE Trans. Autom. Control 40,
    /// 1995).
    #[default]
    LuGre,
    /// [`elastoplastic`].
    ElastoPlastic {
        /// Deflection up to which nothing slides, over that of sliding; 0 to below 1.
        breakaway: f64,
    },
    /// [`maxwell_slip`].
    MaxwellSlip {
        /// Number of elements.
        elements: usize,
        /// Attraction C over σ0 v0: how fast sliding elements follow the Stribeck curve.
        attraction: f64,
    },
    /// [`tanh`].
    Tanh {
        /// Speed over v0 at which the sign has grown to tanh 1.
        width: f64,
    },
    /// LuGre with the viscous part of [`limited_viscous`].
    LimitedViscous {
        /// Largest viscous torque over the Coulomb level.
        limit: f64,
    },
}

impl Family {
    /// Its name in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Family::LuGre => "lugre",
            Family::ElastoPlastic { .. } => "elastoplastic",
            Family::MaxwellSlip { .. } => "maxwell-slip",
            Family::Tanh { .. } => "tanh",
            Family::LimitedViscous { .. } => "limited-viscous",
        }
    }

    /// States of a mass's friction beside one bristle.
    pub(super) fn slots(self) -> usize {
        match self {
            Family::MaxwellSlip { elements, .. } => 2 * elements + 1,
            _ => 0,
        }
    }
}

/// What a law is asked about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Sliding speed, rad/s.
    pub speed: f64,
    /// Torque of even sliding at this speed, without the viscous part, Nm: g(v).
    pub level: f64,
    /// Stiffness from rest, Nm/rad.
    pub sigma0: f64,
    /// Damping of a deflection, Nm s/rad.
    pub sigma1: f64,
    /// Stribeck velocity v0, rad/s.
    pub stribeck_velocity: f64,
}
