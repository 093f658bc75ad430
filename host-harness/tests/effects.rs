//! What every kind of effect must have, and where it is kept.

use std::collections::HashSet;

use host_harness::discover::candidates::{Benchmark, card};
use host_harness::encoders;
use host_harness::model::Model;
use host_harness::plant::{self, ScalarKind, Snapshot};
use host_harness::scenario::{ALL, Scenario, paper};
use host_harness::synthetic::{self, Experiment};
use joint_core::effect::{EffectParameters, Kind};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// The file of a kind in a folder of such files.
fn file(folder: &str, kind: Kind) -> String {
    format!("{folder}/{}.rs", kind.spec().kind.replace('-', "_"))
}

fn law(kind: Kind) -> String {
    file("joint-core/src/effect", kind)
}

fn card_file(kind: Kind) -> String {
    file("host-harness/src/discover/candidates", kind)
}

/// Current, motor and output angle by sample as the sensors show them: the joint turns back without a
/// load, and runs under one, so that every law has something to act on.
fn shown(model: &Model) -> Vec<Vec<f64>> {
    let scenarios = [ALL[1].lasting(0.05), ALL[2]];
    scenarios.iter().flat_map(|scenario| shown_in(model, scenario)).collect()
}

fn shown_in(model: &Model, scenario: &Scenario) -> [Vec<f64>; 3] {
    let inputs = scenario.inputs();
    let run = plant::simulate(model, &inputs, ScalarKind::F64, None, None).unwrap();
    let angles = encoders::shown(model, &inputs.time_s, &run);
    let current = |snapshot: &Snapshot| snapshot.measured_current_a;
    [run.iter().map(current).collect(), angles.motor, angles.output]
}

/// Largest change of a series over its largest value.
fn change(plain: &[f64], other: &[f64]) -> f64 {
    let largest = plain.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let changes = plain.iter().zip(other).map(|(a, b)| (a - b).abs());
    changes.fold(0.0, f64::max) / largest
}

#[test]
fn every_law_acts_at_the_size_of_its_example() {
    let plain = shown(&paper());
    for &kind in Kind::ALL {
        let (name, place) = (kind.spec().kind, law(kind));
        let example = EffectParameters::example(kind);
        let (location, values) = kind.spec().example;
        assert!(EffectParameters::admits(kind, location, 2), "{name}: the example in {place}");
        for (key, _) in values {
            assert!(example.get(key).is_some(), "{name}: the example's `{key}` in {place}");
        }
        if let Err(error) = example.validate(1) {
            panic!("{name}: the example in {place}: {error}");
        }
        let model = Model { effects: vec![example], ..paper() };
        let seen = shown(&model);
        let most = plain.iter().zip(&seen).map(|(a, b)| change(a, b)).fold(0.0, f64::max);
        println!("{name:<28} {most:.1e}");
        // A sensor of 13 bits shows an 8192nd.
        assert!(most > 1.2e-4, "{name}: the law in {place} changes nothing: {most:.1e}");
    }
}

#[test]
fn every_card_says_what_the_effect_is_and_which_experiment_tells_it() {
    let (mut words, mut experiments) = (HashSet::new(), HashSet::new());
    for &kind in Kind::ALL {
        let (name, place, card) = (kind.spec().kind, card_file(kind), card(kind));
        for text in [card.words, card.experiment] {
            let begins = text.chars().next().is_some_and(char::is_lowercase);
            assert!(begins && !text.ends_with('.'), "{name}: `{text}` in {place}");
        }
        assert!(words.insert(card.words), "{name}: the words in {place} are another's");
        assert!(experiments.insert(card.experiment), "{name}: the experiment in {place}");
        if let Some(key) = card.reference {
            let known = kind.spec().parameters.iter().any(|spec| spec.key == key);
            assert!(known, "{name}: there is no `{key}`, the reference in {place}");
        }
    }
}

#[test]
fn every_effect_is_hidden_by_the_benchmark_or_a_reason_says_why_not() {
    let plain = host_harness::demo::actuator();
    let experiment = Experiment::clean(0.4);
    let log = synthetic::record(&plain, &experiment, 1).unwrap();
    for &kind in Kind::ALL {
        let (name, place) = (kind.spec().kind, card_file(kind));
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let effect = host_harness::discover::hidden::hidden(kind, &plain, 1.0, 0.4, &mut random);
        if let Benchmark::Left(reason) = card(kind).benchmark {
            assert!(effect.is_none() && reason.len() > 20, "{name}: no reason in {place}");
            continue;
        }
        let Some(effect) = effect else { panic!("{name}: no size for the demo in {place}") };
        assert_eq!(effect.kind, kind, "{name}: {place} hides another kind");
        let truth = Model { effects: vec![effect], ..plain.clone() };
        assert_eq!(joint_core::effect::validate(&truth.effects, 1), Ok(()), "{name}: {place}");
        let hides = synthetic::record(&truth, &experiment, 1).unwrap();
        // Both logs have the same noise, so any difference is the effect's.
        let (current, other) = (log.current_a.as_ref(), hides.current_a.as_ref());
        let most = [
            change(current.unwrap(), other.unwrap()),
            change(&log.motor_angle_rad, &hides.motor_angle_rad),
        ];
        assert!(most[0].max(most[1]) > 1e-3, "{name}: the size in {place} shows nothing: {most:?}");
    }
}
