//! A benchmark of our own: joints whose truth is known because it was drawn.
//!
//! Every trial has another joint, another nominal, another friction law, another seed of noise, and
//! is integrated by the reference, which shares nothing with the fitter's step. What is hidden goes
//! round all kinds at several sizes, pairs, nothing at all, and effects whose own candidate is
//! withdrawn, so that no listed name is right.

use std::collections::BTreeMap;

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::{Friction, Load, Motor, Stage};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{Case, TrueEffect};
use crate::demo::actuator;
use crate::discover::findings::Answer;
use crate::discover::hidden::{hidden, kinds};
use crate::log::Log;
use crate::model::{Model, Sensor};
use crate::reference::ReferenceError;
use crate::synthetic::{Experiment, perturbed, record};

/// Length of a log, s.
const DURATION_S: f64 = 2.0;
/// Of sixteen trials: so many hide nothing, an effect whose candidate is withdrawn, a pair.
const NOTHING: u64 = 3;
const WITHDRAWN: u64 = 2;
const PAIRS: u64 = 2;
const CYCLE: u64 = 16;

/// One trial.
#[derive(Clone, Debug)]
pub struct Trial {
    /// What is right.
    pub case: Case,
    /// What the user knows.
    pub nominal: Model,
    /// What was measured, first what is asked about: further records have another level of
    /// friction and another motion.
    pub logs: Vec<Log>,
    /// The kind that discovery must do without.
    pub withdrawn: Option<Kind>,
}

/// The right answer of a benchmark's trial number `number`, whatever its seed.
pub fn answer(number: u64) -> Answer {
    match number % CYCLE {
        place if place < NOTHING => Answer::Adequate,
        place if place < NOTHING + WITHDRAWN => Answer::Unknown,
        _ => Answer::Effect,
    }
}

/// Draws trial number `number` of a benchmark.
///
/// # Errors
/// The reference cannot simulate it.
pub fn trial(seed: u64, number: u64) -> Result<Trial, ReferenceError> {
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let mut truth = perturbed(&rig(&mut random), random.random());
    let nominal = perturbed(&truth, random.random());
    let all: Vec<Kind> = kinds().collect();
    let place = number % CYCLE;
    let answer = answer(number);
    let pairs = NOTHING + WITHDRAWN..NOTHING + WITHDRAWN + PAIRS;
    let wanted = match answer {
        Answer::Adequate => 0,
        _ if pairs.contains(&place) => 2,
        _ => 1,
    };
    let mut turn = (number / CYCLE * (CYCLE - NOTHING) + place) as usize;
    let mut effects: Vec<EffectParameters> = Vec::new();
    let mut sizes = Vec::new();
    while effects.len() < wanted {
        let size = 2.0_f64.powf(random.random_range(-1.0..1.0));
        let kind = all[turn % all.len()];
        turn += if wanted == 2 { 1 + random.random_range(0..all.len() - 1) } else { 1 };
        if effects.iter().any(|effect| effect.kind == kind) {
            continue;
        }
        if let Some(effect) = hidden(kind, &truth, size, DURATION_S, &mut random) {
            effects.push(effect);
            sizes.push(size);
        }
    }
    let known = effects.first().map(|effect| effect.kind);
    let withdrawn = known.filter(|_| answer == Answer::Unknown);
    truth.effects.extend(&effects);
    let experiment = Experiment {
        duration_s: DURATION_S,
        stribeck_exponent: random.random_range(1.6..2.0),
        voltage_noise: random.random_range(1e-3..3e-3),
        torque_noise: random.random_range(5e-3..2e-2),
        ..Experiment::default()
    };
    let log = record(&truth, &experiment, random.random())?;
    let case = Case {
        case: format!("{number:04}"),
        verdict: answer.name().to_owned(),
        effects: effects.iter().map(told).collect(),
        size: sizes.first().copied(),
        withdrawn: withdrawn.map(|kind| kind.spec().kind.to_owned()),
        misfits: None,
    };
    Ok(Trial { case, nominal, logs: vec![log], withdrawn })
}

pub(super) fn told(effect: &EffectParameters) -> TrueEffect {
    let values = effect.kind.spec().parameters.iter().zip(effect.values);
    let parameters: BTreeMap<String, serde_json::Value> =
        values.map(|(spec, value)| (spec.key.to_owned(), value.into())).collect();
    TrueEffect {
        kind: effect.kind.spec().kind.to_owned(),
        location: effect.location.to_string(),
        parameters,
        signal_to_noise: None,
    }
}

/// A joint: a direct drive, an actuator with one stage, or a small one with two, of a size of its
/// own.
pub(super) fn rig(random: &mut impl Rng) -> Model {
    let mut model = match random.random_range(0..5) {
        0 | 1 => direct(),
        2 | 3 => actuator(),
        _ => small(),
    };
    let size = 2.0_f64.powf(random.random_range(-1.0..1.0));
    // A larger joint: torques with the size, inertias with its square, a winding to match.
    let motor = &mut model.motor;
    motor.torque_constant_nm_per_a *= size.sqrt();
    motor.phase_back_emf_constant_v_s_per_rad = None;
    motor.rotor_inertia_kg_m2 *= size.powf(1.5);
    grow(&mut motor.friction, size);
    for stage in &mut model.stages {
        stage.inertia_kg_m2 *= size.powf(1.5);
        stage.stiffness_nm_per_rad *= size;
        stage.cubic_stiffness_nm_per_rad3 *= size;
        stage.damping_nm_s_per_rad *= size;
        grow(&mut stage.friction, size);
    }
    let counts = 2.0_f64.powi(random.random_range(13..17));
    model.sensor.motor_encoder_counts_per_rev = counts;
    let seen = model.stages.is_empty() || random.random_range(0..4) > 0;
    model.sensor.output_encoder_counts_per_rev = if seen { 4.0 * counts } else { 0.0 };
    model
}

fn grow(friction: &mut Friction, size: f64) {
    friction.sigma0_nm_per_rad *= size;
    friction.sigma1_nm_s_per_rad *= size;
    friction.sigma2_nm_s_per_rad *= size;
    friction.coulomb_nm *= size;
    friction.stribeck_nm *= size;
}

/// A gimbal motor with a wheel on it.
fn direct() -> Model {
    Model {
        name: "direct".to_owned(),
        motor: Motor {
            phase_resistance_ohm: 2.4,
            phase_inductance_h: 0.9e-3,
            torque_constant_nm_per_a: 0.13,
            pole_pairs: 11,
            rotor_inertia_kg_m2: 1.4e-4,
            friction: Friction {
                sigma0_nm_per_rad: 9.0,
                sigma1_nm_s_per_rad: 0.02,
                sigma2_nm_s_per_rad: 1.5e-4,
                coulomb_nm: 0.008,
                stribeck_nm: 0.004,
                stribeck_velocity_rad_per_s: 1.2,
            },
            ..Motor::default()
        },
        stages: Vec::new(),
        load: Load { inertia_kg_m2: 1e-4, ..Load::default() },
        sensor: Sensor {
            sample_time_s: 2e-4,
            motor_encoder_counts_per_rev: 16384.0,
            output_encoder_counts_per_rev: 0.0,
            current_noise_a: 0.006,
            ..Sensor::default()
        },
        effects: Vec::new(),
        friction_levels: Vec::new(),
    }
}

/// A small servo of two stages.
fn small() -> Model {
    let mut model = actuator();
    let first = Stage {
        reduction: 5.0,
        inertia_kg_m2: 1.2e-5,
        stiffness_nm_per_rad: 45.0,
        damping_nm_s_per_rad: 2e-3,
        friction: Friction {
            sigma0_nm_per_rad: 60.0,
            sigma1_nm_s_per_rad: 0.03,
            sigma2_nm_s_per_rad: 2e-4,
            coulomb_nm: 0.02,
            stribeck_nm: 0.01,
            stribeck_velocity_rad_per_s: 1.0,
        },
        ..Stage::default()
    };
    model.name = "small".to_owned();
    model.stages.insert(0, first);
    if let Some(last) = model.stages.last_mut() {
        last.reduction = 6.0;
    }
    model
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_round_of_trials_has_every_kind_of_answer() {
        let trials: Vec<Trial> = (0..CYCLE).map(|number| trial(7, number).unwrap()).collect();
        for (number, Trial { case, withdrawn, .. }) in (0..).zip(&trials) {
            let told = match (case.effects.is_empty(), withdrawn) {
                (true, None) => Answer::Adequate,
                (false, Some(_)) => Answer::Unknown,
                (false, None) => Answer::Effect,
                (true, Some(_)) => panic!("{number}: nothing was withdrawn"),
            };
            assert_eq!((answer(number), case.verdict.as_str()), (told, told.name()), "{number}");
        }
        let count = |told: Answer| (0..CYCLE).filter(|number| answer(*number) == told).count();
        assert_eq!((count(Answer::Adequate), count(Answer::Unknown)), (3, 2));
        assert_eq!(trials[5].case.effects.len(), 2);
    }
}
