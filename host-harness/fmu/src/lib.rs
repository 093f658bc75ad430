//! The joint in someone else's simulator, as an FMU for co-simulation (FMI 2.0.4 and 3.0.2).
//!
//! Not a translation: the shared library steps `joint-core` itself, in double precision, with every
//! effect. It is the same for all joints and for both versions of the standard; which joint it is
//! stands in the FMU's `resources/joint.json`, and every number there is also a parameter that the
//! importing tool may set before initialisation.

#![allow(unsafe_code)]

#[macro_use]
mod macros;

mod component;
mod description;
mod descriptions;
mod effect;
pub mod fmi2;
pub mod fmi3;
mod instance;
mod joint;
mod running;
mod state;

pub use component::Component;
pub use description::{Version, model_description};
pub use instance::{DISCARD, ERROR, Instance, OK, Status};
pub use joint::{EffectDescription, Input, Joint, JointError, Variable, guid};
