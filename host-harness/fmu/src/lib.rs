//! The joint in someone else's simulator, as an FMU for co-simulation (FMI 2.0.4).
//!
//! Not a translation: the shared library steps `joint-core` itself, in double precision, with every
//! effect. It is the same for all joints; which one it is stands in the FMU's
//! `resources/joint.json`, and every number there is also a parameter that the importing tool may
//! set before initialisation.

#![allow(unsafe_code)]

mod component;
mod description;
mod descriptions;
mod effect;
pub mod functions;
mod joint;
mod running;

pub use description::model_description;
pub use joint::{EffectDescription, Input, Joint, JointError, Variable, guid};
