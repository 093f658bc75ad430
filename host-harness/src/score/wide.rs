//! Wide draws: joints that differ from the model as measured ones do.
//!
//! The narrow draws of [`super::blind`] have one motion, one length, one misfit and white noise. A
//! search that was made on them is right about them. Here everything is drawn that measured joints
//! were found to have; what it was stands in the case's truth. Everything follows from seed and
//! number.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::blind::{Trial, rig, told};
use super::misfits::{Misfits, breakaway_at_output_nm, rubbing_otherwise};
use super::{Case, TrueEffect};
use crate::discover::findings::Answer;
use crate::discover::hidden::{hidden, kinds, kinds_of_wide_draws};
use crate::model::Model;
use crate::reference::ReferenceError;
use crate::reference::friction::Family;
use crate::scenario;
use crate::synthetic::{
    Colour, Disturbances, Motion, Reported, Sensing, Setting, Stamps, perturbed, perturbed_within,
    record_wide,
};

/// What one trial of a round hides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Content {
    Nothing,
    Effects(usize),
    Withdrawn,
}

use Content::{Effects, Nothing, Withdrawn};

/// A round: five with nothing, nine single effects, three pairs, a triple, two withdrawn, in an order
/// that makes a part of a round much like the whole.
const ROUND: [Content; 20] = [
    Effects(1),
    Nothing,
    Effects(1),
    Effects(2),
    Withdrawn,
    Effects(1),
    Nothing,
    Effects(1),
    Effects(1),
    Effects(3),
    Nothing,
    Effects(1),
    Effects(2),
    Effects(1),
    Nothing,
    Withdrawn,
    Effects(1),
    Effects(2),
    Effects(1),
    Nothing,
];

/// Sizes of effects in units of what is typical: clear, and 0.4 of it.
pub const SIZES: [f64; 2] = [1.0, 0.4];

/// Sample times, s.
const SAMPLE_S: [f64; 7] = [1e-4, 1.25e-4, 2e-4, 2.5e-4, 4e-4, 5e-4, 1e-3];
/// Samples of a record.
const SAMPLES: [f64; 2] = [5_000.0, 40_000.0];
/// Length of a record, s; of the paper's joint, whose friction takes the reference the longest steps
/// of a tenth of a microsecond.
const DURATION_S: [f64; 2] = [1.0, 20.0];
const PAPER_DURATION_S: [f64; 2] = [1.0, 2.0];

/// The right answer of trial `number`, whatever its seed; an effect instead of nothing where the report of its
/// current is filtered, which has a name.
pub fn answer(number: u64) -> Answer {
    match content(number) {
        Nothing => Answer::Adequate,
        Effects(_) => Answer::Effect,
        Withdrawn => Answer::Unknown,
    }
}

fn content(number: u64) -> Content {
    ROUND[(number % ROUND.len() as u64) as usize]
}

/// How many effects trial `number` hides, the withdrawn one among them.
pub(super) fn effects_of(number: u64) -> usize {
    match content(number) {
        Nothing => 0,
        Effects(count) => count,
        Withdrawn => 1,
    }
}

/// Which joints are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rigs {
    /// All: of five one is the paper's.
    All,
    /// The paper's joint alone.
    Paper,
}

/// Draws trial `number` of a benchmark.
///
/// # Errors
/// The reference cannot simulate it.
pub fn trial(seed: u64, number: u64, rigs: Rigs) -> Result<Trial, ReferenceError> {
    let mixed = seed ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x7769_6465;
    let mut random = ChaCha8Rng::seed_from_u64(mixed);
    let paper = random.random_range(0..5) == 0 || rigs == Rigs::Paper;
    let mut truth = if paper {
        perturbed_within(&scenario::paper(), random.random(), [0.0, 0.2], [0.0, 0.2])
    } else {
        perturbed(&rig(&mut random), random.random())
    };
    let mut setting = setting(paper, &mut random);
    // A pendulum hangs on some; what it weighs is known.
    if !paper && random.random_range(0..7) == 0 {
        setting.motion = Motion::Swings;
        truth.load.gravity_nm = breakaway_at_output_nm(&truth) * random.random_range(1.0..4.0);
    }
    truth.sensor.sample_time_s = setting.sample_time_s;
    let worst = log_uniform([0.04, 0.3], &mut random);
    let nominal =
        perturbed_within(&truth, random.random(), [0.03, worst], [0.03_f64, worst.max(0.2)]);

    let content = content(number);
    let wanted = effects_of(number);
    let size = SIZES[random.random_range(0..SIZES.len())];
    let mut effects = hide(&truth, wanted, size, setting.duration_s, &mut random);
    timing(&mut effects, &truth, size, setting.duration_s, mixed);
    let withdrawn = effects.first().filter(|_| content == Withdrawn).map(|effect| effect.kind);
    truth.effects.extend(&effects);

    let mut levels = vec![1.0];
    let first = record_wide(&truth, &setting, random.random())?;
    let mut logs = vec![first.log];
    if random.random_range(0..3) == 0 {
        for _ in 0..random.random_range(1..=if paper { 1 } else { 2 }) {
            let level = random.random_range(0.8..1.2);
            let other = Setting {
                motion: motion(truth.load.gravity_nm != 0.0, &mut random),
                duration_s: setting.duration_s.min(if paper { 1.0 } else { 5.0 }),
                ..setting
            };
            let joint = rubbing_otherwise(&truth, level);
            logs.push(record_wide(&joint, &other, random.random())?.log);
            levels.push(level);
        }
    }
    let mut effects = told_with(&effects, &first.signal_to_noise);
    let reported = filtered(&setting).map(|lag| told(&lag));
    let right = match (answer(number), &reported) {
        (Answer::Adequate, Some(_)) => Answer::Effect,
        (right, _) => right,
    };
    effects.extend(reported);
    let case = Case {
        case: format!("{number:04}"),
        verdict: right.name().to_owned(),
        effects,
        size: (wanted > 0).then_some(size),
        withdrawn: withdrawn.map(|kind| kind.spec().kind.to_owned()),
        misfits: Some(Misfits::of(&truth, &setting, worst, levels)),
    };
    Ok(Trial { case, nominal, logs, withdrawn })
}

fn log_uniform([from, to]: [f64; 2], random: &mut impl Rng) -> f64 {
    from * (to / from).powf(random.random())
}

/// The effects of a case's truth, each with its signal over the noise.
pub(super) fn told_with(effects: &[EffectParameters], signal_to_noise: &[f64]) -> Vec<TrueEffect> {
    let pairs = effects.iter().zip(signal_to_noise);
    pairs.map(|(own, ratio)| TrueEffect { signal_to_noise: Some(*ratio), ..told(own) }).collect()
}

/// The filter of the current's report, where it is longer than a sample.
fn filtered(setting: &Setting) -> Option<EffectParameters> {
    match setting.sensing.current {
        Reported::Filtered(constant_s) if constant_s > setting.sample_time_s => {
            let lag = EffectParameters::new(Kind::SensorLag, Location::CurrentSensor);
            Some(lag.with("time_constant_s", constant_s))
        }
        _ => None,
    }
}

/// One trial in so many that hide effects has a wide draw's own kind in place of its first one.
const TIMING: u32 = 8;

/// Puts a kind that wide draws alone hide in the place of the first effect of some trials. What it takes is
/// drawn apart, so that all else of a seed stays as it is.
fn timing(effects: &mut [EffectParameters], truth: &Model, size: f64, duration_s: f64, mixed: u64) {
    let mut random = ChaCha8Rng::seed_from_u64(mixed ^ 0x7469_6d69_6e67);
    let kinds: Vec<Kind> = kinds_of_wide_draws().collect();
    let kind = kinds[random.random_range(0..kinds.len())];
    let Some(first) = effects.first_mut() else { return };
    if random.random_range(0..TIMING) == 0
        && let Some(effect) = hidden(kind, truth, size, duration_s, &mut random)
    {
        *first = effect;
    }
}

/// So many effects of different kinds; fewer where the joint has no place for more.
pub(super) fn hide(
    truth: &Model,
    wanted: usize,
    size: f64,
    duration_s: f64,
    random: &mut impl Rng,
) -> Vec<EffectParameters> {
    // Gravity beside a pendulum that is known is the same law.
    let known = |kind: &Kind| *kind == Kind::Gravity && truth.load.gravity_nm != 0.0;
    let mut left: Vec<Kind> = kinds().filter(|kind| !known(kind)).collect();
    let mut effects = Vec::new();
    while effects.len() < wanted && !left.is_empty() {
        let kind = left.swap_remove(random.random_range(0..left.len()));
        effects.extend(hidden(kind, truth, size, duration_s, random));
    }
    effects
}

fn motion(hanging: bool, random: &mut impl Rng) -> Motion {
    if hanging && random.random_range(0..3) > 0 {
        Motion::Swings
    } else {
        Motion::LEVEL[random.random_range(0..Motion::LEVEL.len())]
    }
}

fn setting(paper: bool, random: &mut impl Rng) -> Setting {
    let duration = log_uniform(if paper { PAPER_DURATION_S } else { DURATION_S }, random);
    let fits = |sample: &&f64| (SAMPLES[0]..=SAMPLES[1]).contains(&(duration / **sample));
    let fitting: Vec<f64> = SAMPLE_S.iter().filter(fits).copied().collect();
    // The paper's joint rings at kilohertz.
    let fitting = if paper { &fitting[..1] } else { &fitting[..] };
    let sample_time_s = fitting[random.random_range(0..fitting.len())];
    Setting {
        motion: motion(false, random),
        duration_s: (duration / sample_time_s).round() * sample_time_s,
        sample_time_s,
        friction: family(random),
        stribeck_exponent: if random.random_range(0..3) == 0 {
            random.random_range(0.5..1.6)
        } else {
            random.random_range(1.6..2.0)
        },
        disturbance: disturbances(random),
        sensing: sensing(random),
    }
}

fn family(random: &mut impl Rng) -> Family {
    match random.random_range(0..6) {
        0 | 1 => Family::LuGre,
        2 => Family::ElastoPlastic { breakaway: random.random_range(0.4..0.9) },
        3 => Family::MaxwellSlip {
            elements: random.random_range(4..=10),
            attraction: random.random_range(0.3..3.0),
        },
        4 => Family::Tanh { width: random.random_range(0.03..0.15) },
        _ => Family::LimitedViscous { limit: random.random_range(0.1..0.6) },
    }
}

/// A family other than the model's own, and the exponent of its Stribeck curve.
pub(super) fn another_family(random: &mut impl Rng) -> (Family, f64) {
    match family(random) {
        Family::LuGre => (Family::LuGre, random.random_range(0.5..1.6)),
        other => (other, random.random_range(0.5..2.0)),
    }
}

fn disturbances(random: &mut impl Rng) -> Disturbances {
    let torque = Colour {
        deviation: log_uniform([2e-3, 5e-2], random),
        correlation_s: log_uniform([1e-3, 0.5], random),
    };
    let wanders = random.random::<bool>();
    let friction = Colour {
        deviation: if wanders { log_uniform([5e-3, 5e-2], random) } else { 0.0 },
        correlation_s: log_uniform([2e-2, 2.0], random),
    };
    Disturbances {
        white_torque: log_uniform([2e-3, 2e-2], random),
        torque,
        friction,
        voltage: log_uniform([5e-4, 1e-2], random),
    }
}

fn sensing(random: &mut impl Rng) -> Sensing {
    let current = match random.random_range(0..3) {
        0 => Reported::AtOnce,
        1 => Reported::Late(if random.random::<bool>() {
            f64::from(random.random_range(1..=5))
        } else {
            random.random_range(0.0..5.0)
        }),
        _ => Reported::Filtered(log_uniform([1e-4, 0.1], random)),
    };
    let jitters = random.random_range(0..4) == 0;
    Sensing {
        current,
        jitter: if jitters { log_uniform([0.03, 0.2], random) } else { 0.0 },
        stamps: [Stamps::Exact, Stamps::Even, Stamps::RowBefore][random.random_range(0..3)],
        bus_ripple: (random.random_range(0..4) == 0).then(|| log_uniform([0.01, 0.2], random)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_round_has_every_kind_of_answer_and_says_what_it_has() {
        for number in [0, 1, 3, 4, 9] {
            let trial = trial(5, number, Rigs::All).unwrap();
            let Trial { case, logs, withdrawn, .. } = &trial;
            let filtered = case.effects.iter().any(|effect| effect.kind == "sensor-lag");
            assert!(filtered || case.verdict == answer(number).name(), "{number}");
            assert_eq!(withdrawn.is_some(), content(number) == Withdrawn, "{number}");
            let misfits = case.misfits.as_ref().unwrap();
            assert_eq!(misfits.friction_levels.len(), logs.len());
            assert!((1.0..=20.01).contains(&misfits.duration_s), "{}", misfits.duration_s);
            assert!((4_999..=40_001).contains(&logs[0].len()), "{}", logs[0].len());
            for effect in &case.effects {
                let filter = effect.kind == "sensor-lag";
                assert!(filter || effect.signal_to_noise.is_some_and(|r| r > 0.0), "{number}");
            }
        }
        let of = |wanted: Content| ROUND.iter().filter(|content| **content == wanted).count();
        assert_eq!((of(Nothing), of(Withdrawn), of(Effects(1)), of(Effects(2))), (5, 2, 9, 3));
    }

    #[test]
    fn seed_and_number_say_everything() {
        let drawn = |seed: u64| trial(seed, 2, Rigs::All).unwrap();
        let (one, again, other) = (drawn(3), drawn(3), drawn(4));
        assert_eq!((&one.logs, &one.nominal), (&again.logs, &again.nominal));
        assert_ne!(one.logs, other.logs);
    }

    #[test]
    fn the_papers_joint_can_be_drawn_alone() {
        for number in 1..3 {
            let trial = trial(1, number, Rigs::Paper).unwrap();
            assert_eq!((trial.nominal.stages.len(), trial.nominal.name.as_str()), (2, "paper"));
        }
    }
}
