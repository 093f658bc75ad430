//! The demonstration: a joint with something hidden in it, and a user who knows a nominal model.
//!
//! The joint is a small robot actuator of our own choosing. Its log is made by the reference
//! integrator, which shares nothing with the fitter's step, with noise, counts and a friction law
//! that is not quite the model's; the nominal is wrong in every parameter. Which effect is hidden,
//! and how large it is, follows from the seed.

use joint_core::effect::{EffectParameters, Kind};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub use joint_simulation::demo::actuator;

use crate::discover::hidden::{hidden, kinds};
use crate::log::Log;
use crate::model::Model;
use crate::reference::ReferenceError;
use crate::synthetic::{Experiment, perturbed, record};

/// Length of the log, s.
const DURATION_S: f64 = 2.0;

/// A log with something hidden in it.
#[derive(Clone, Debug)]
pub struct Riddle {
    /// What the user knows.
    pub nominal: Model,
    /// What was measured.
    pub log: Log,
    /// What was hidden.
    pub hidden: EffectParameters,
}

/// Makes the riddle of a seed.
///
/// # Errors
/// The reference cannot simulate it.
pub fn riddle(seed: u64) -> Result<Riddle, ReferenceError> {
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x6a6f_696e_7400);
    let mut truth = perturbed(&actuator(), seed);
    let nominal = perturbed(&truth, seed.wrapping_add(1));
    let kinds: Vec<Kind> = kinds().collect();
    let kind = kinds[random.random_range(0..kinds.len())];
    let size = random.random_range(0.7..1.5);
    let hidden = hidden(kind, &truth, size, DURATION_S, &mut random)
        .ok_or(ReferenceError::Inputs("the joint has no place for this effect"))?;
    truth.effects.push(hidden);
    let exponent = random.random_range(1.7..2.0);
    let experiment =
        Experiment { duration_s: DURATION_S, stribeck_exponent: exponent, ..Experiment::default() };
    let log = record(&truth, &experiment, seed)?;
    Ok(Riddle { nominal, log, hidden })
}
