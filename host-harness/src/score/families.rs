//! Draws of joints whose friction is another law than the model's, and that have no other misfit.
//!
//! A joint that another simulator made, or a real one, rubs by a law of its own. With nothing else wrong, what
//! is named in it falsely is due to friction alone, which the wide draws of [`super::wide`] cannot tell.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::Case;
use super::blind::{Trial, rig};
use super::misfits::Misfits;
use super::wide::{SIZES, another_family, answer, effects_of, hide, told_with};
use crate::discover::findings::Answer;
use crate::reference::ReferenceError;
use crate::synthetic::{
    Colour, Disturbances, Motion, Reported, Sensing, Setting, Stamps, perturbed, perturbed_within,
    record_wide,
};

/// Length of a log, s, and its sample time, s.
const DURATION_S: [f64; 2] = [2.0, 4.0];
const SAMPLE_S: f64 = 2e-4;
/// Errors of the nominal's parameters.
const ERRORS: [f64; 2] = [0.05, 0.1];

/// Draws trial `number` of a benchmark; its right answer is [`answer`]'s.
///
/// # Errors
/// The reference cannot simulate it.
pub fn trial(seed: u64, number: u64) -> Result<Trial, ReferenceError> {
    let mixed = seed ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x6672_6963_7469_6f6e;
    let mut random = ChaCha8Rng::seed_from_u64(mixed);
    let mut truth = perturbed(&rig(&mut random), random.random());
    truth.sensor.sample_time_s = SAMPLE_S;
    let nominal = perturbed_within(&truth, random.random(), ERRORS, ERRORS);
    let duration = random.random_range(DURATION_S[0]..DURATION_S[1]);
    let still = Colour { deviation: 0.0, correlation_s: 1.0 };
    let (friction, stribeck_exponent) = another_family(&mut random);
    let setting = Setting {
        motion: Motion::LEVEL[random.random_range(0..Motion::LEVEL.len())],
        duration_s: (duration / SAMPLE_S).round() * SAMPLE_S,
        sample_time_s: SAMPLE_S,
        friction,
        stribeck_exponent,
        disturbance: Disturbances {
            white_torque: random.random_range(5e-3..2e-2),
            torque: still,
            friction: still,
            voltage: random.random_range(1e-3..3e-3),
        },
        sensing: Sensing {
            current: Reported::AtOnce,
            jitter: 0.0,
            stamps: Stamps::Exact,
            bus_ripple: None,
        },
    };
    let size = SIZES[random.random_range(0..SIZES.len())];
    let effects = hide(&truth, effects_of(number), size, setting.duration_s, &mut random);
    truth.effects.extend(&effects);
    let right = answer(number);
    let withdrawn = effects.first().filter(|_| right == Answer::Unknown).map(|effect| effect.kind);
    let record = record_wide(&truth, &setting, random.random())?;
    let case = Case {
        case: format!("{number:04}"),
        verdict: right.name().to_owned(),
        effects: told_with(&effects, &record.signal_to_noise),
        size: (!effects.is_empty()).then_some(size),
        withdrawn: withdrawn.map(|kind| kind.spec().kind.to_owned()),
        misfits: Some(Misfits::of(&truth, &setting, ERRORS[1], vec![1.0])),
    };
    Ok(Trial { case, nominal, logs: vec![record.log], withdrawn })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_is_the_only_misfit_and_never_the_models_own() {
        for number in 0..4 {
            let case = trial(3, number).unwrap().case;
            assert_eq!(case.verdict, answer(number).name());
            let misfits = case.misfits.unwrap();
            assert!(misfits.friction != "lugre" || misfits.stribeck_exponent < 1.6);
            assert_eq!(misfits.disturbance.torque.deviation, 0.0);
            assert_eq!(misfits.classes()[3].1, "exact");
        }
    }
}
