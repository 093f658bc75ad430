//! Discovery on logs made by the reference from a joint whose truth is known.

use std::ops::Range;

use host_harness::demo::{actuator, riddle};
use host_harness::discover::discover;
use host_harness::discover::findings::{Answer, Findings};
use host_harness::estimate::fit::Problem;
use host_harness::estimate::noise::expected;
use host_harness::estimate::parameters::Quantity;
use host_harness::estimate::record::Record;
use host_harness::estimate::refit::refit;
use host_harness::log::Log;
use host_harness::model::Model;
use host_harness::synthetic::{Experiment, perturbed, record};
use indicatif::ProgressBar;
use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

fn experiment() -> Experiment {
    Experiment { duration_s: 2.0, stribeck_exponent: 1.8, ..Experiment::default() }
}

fn found(nominal: &Model, log: Log) -> Findings {
    discover(nominal, &[log], &ProgressBar::hidden()).unwrap()
}

fn without(log: &Log, samples: Range<usize>) -> Log {
    let kept: Vec<bool> = (0..log.len()).map(|k| !samples.contains(&k)).collect();
    log.only(&kept)
}

#[test]
fn nothing_hidden_is_called_adequate() {
    let truth = perturbed(&actuator(), 11);
    let log = record(&truth, &experiment(), 12).unwrap();
    let findings = found(&perturbed(&truth, 13), log);
    let verdict = &findings.verdict;
    assert_eq!(verdict.verdict, Answer::Adequate, "{:?}", verdict.reasons);
    assert!(verdict.effects.is_empty());
    assert!((verdict.gap.before / verdict.gap.floor - 1.0).abs() < 0.05);
}

#[test]
fn hidden_cogging_is_named_measured_and_closes_the_gap() {
    let hidden = EffectParameters::new(Kind::Cogging, Location::Motor)
        .with("order", 42.0)
        .with("amplitude_nm", 0.012)
        .with("phase_rad", 0.8);
    let mut truth = perturbed(&actuator(), 21);
    truth.effects.push(hidden);
    let log = record(&truth, &experiment(), 22).unwrap();
    let findings = found(&perturbed(&truth, 23), log);
    let verdict = &findings.verdict;
    assert_eq!(verdict.verdict, Answer::Effect, "{:?}", verdict.reasons);
    let named = &verdict.effects[0];
    assert_eq!((named.kind.as_str(), named.location.as_str()), ("cogging", "motor"));
    assert_eq!(named.parameters["order"], 42.0);
    assert!((named.parameters["amplitude_nm"] / 0.012 - 1.0).abs() < 0.05);
    assert_eq!(verdict.whereabouts.orders[0], 42.0);
    let gap = &verdict.gap;
    assert!(gap.before > 1.5 && gap.after < 1.05 * gap.floor, "{gap:?}");
    let again = Model::parse(&findings.improved.to_toml(), "improved.toml".as_ref()).unwrap();
    assert_eq!(again, findings.improved);
}

#[test]
fn an_effect_of_no_list_is_called_unknown() {
    // A load that steps on and off, which the log does not show, is no law of the joint.
    let truth = perturbed(&actuator(), 31);
    let samples = (1.2 / truth.sensor.sample_time_s) as usize;
    let load_nm = (0..samples).map(|k| if (k / 400) % 2 == 0 { 0.0 } else { 0.6 }).collect();
    let log = record(&truth, &Experiment { load_nm, ..experiment() }, 32).unwrap();
    let findings = found(&perturbed(&truth, 33), log);
    assert_eq!(findings.verdict.verdict, Answer::Unknown, "{:?}", findings.verdict);
    assert_eq!(findings.verdict.whereabouts.equation, "output torque");
}

#[test]
fn a_refit_recovers_what_the_log_determines() {
    let truth = perturbed(&actuator(), 41);
    let nominal = perturbed(&truth, 42);
    let log = record(&truth, &experiment(), 43).unwrap();
    let record = Record::new(&log, Some(2));
    let mask = vec![1.0; record.len()];
    let fit = refit(&Problem::new(&record, &mask), &nominal).unwrap();
    for quantity in [
        Quantity::Resistance,
        Quantity::TorqueConstant,
        Quantity::Inertia(0),
        Quantity::Inertia(1),
        Quantity::Stiffness(0),
        Quantity::Viscous(1),
    ] {
        let before = quantity.distance(&truth, &nominal).abs();
        let after = quantity.distance(&truth, &fit.model).abs();
        assert!(after < 0.01 && after < before, "{}: {before} to {after}", quantity.key());
    }
}

#[test]
fn every_seed_of_the_demonstration_hides_one_effect_of_a_believable_size() {
    for seed in 0..4 {
        let riddle = riddle(seed).unwrap();
        riddle.hidden.validate(1).unwrap();
        assert!(riddle.log.time_s.len() > 5000);
    }
}

#[test]
fn behind_a_gap_the_filter_starts_anew_in_the_motion_that_the_encoder_shows() {
    let truth = perturbed(&actuator(), 51);
    let whole = record(&truth, &experiment(), 52).unwrap();
    let broken = without(&whole, 700..1200);
    let per_sample = |log: &Log, pretend: bool| {
        let mut record = Record::new(log, None);
        if pretend {
            record.cuts.clear();
            record.starts.truncate(1);
        }
        let mask = vec![1.0; record.len()];
        let noise = expected(&truth, &record);
        let problem = Problem::new(&record, &mask);
        let innovations = problem.design(&truth, &noise).unwrap().innovations;
        problem.sum_of_squares(&innovations) / record.len() as f64
    };
    let (intact, gapped) = (per_sample(&whole, false), per_sample(&broken, false));
    assert!((gapped / intact - 1.0).abs() < 0.1, "{gapped} beside {intact}");
    let naive = per_sample(&broken, true);
    assert!(naive > 2.0 * gapped, "a gap bridged by the model alone: {naive} beside {gapped}");
}

#[test]
fn a_log_may_begin_in_motion_and_behind_an_eccentric_encoder() {
    let mut truth = perturbed(&actuator(), 61);
    let hidden = EffectParameters::new(Kind::EncoderEccentricity, Location::Encoder)
        .with("amplitude_rad", 0.02)
        .with("phase_rad", 1.4);
    truth.effects.push(hidden);
    let log = record(&truth, &experiment(), 62).unwrap();
    let moving = without(&log, 0..700);
    let at_first = |log: &Log, begins_at_rest: bool| {
        let mut record = Record::new(log, None);
        assert_eq!(record.cuts.is_empty(), begins_at_rest);
        let mask: Vec<f64> = (0..record.len()).map(|k| f64::from(u8::from(k < 100))).collect();
        let noise = expected(&truth, &record);
        let per_sample = |record: &Record| {
            let problem = Problem::new(record, &mask);
            let innovations = problem.design(&truth, &noise).unwrap().innovations;
            problem.sum_of_squares(&innovations) / 100.0
        };
        let own = per_sample(&record);
        record.cuts.clear();
        (own, per_sample(&record))
    };
    let (from_rest, _) = at_first(&log, true);
    let (moving, naive) = at_first(&moving, false);
    assert!(from_rest < 5.0, "{from_rest}");
    assert!(moving < 5.0 && naive > 3.0 * moving, "{moving}, from rest {naive}");
}
