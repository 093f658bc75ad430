use std::f64::consts::TAU;

use super::*;
use crate::scenario::paper;

fn short() -> Experiment {
    Experiment { duration_s: 0.2, ..Experiment::default() }
}

#[test]
fn the_seed_says_everything() {
    let log = record(&paper(), &short(), 7).unwrap();
    assert_eq!(log, record(&paper(), &short(), 7).unwrap());
    assert_ne!(log, record(&paper(), &short(), 8).unwrap());
}

#[test]
fn encoders_count_from_zero_and_the_current_has_its_noise() {
    let model = paper();
    let log = record(&model, &short(), 1).unwrap();
    assert_eq!((log.len(), log.time_s[0], log.motor_angle_rad[0]), (2000, 0.0, 0.0));
    let count = TAU / model.sensor.motor_encoder_counts_per_rev;
    assert!(log.motor_angle_rad.iter().all(|q| (q / count - (q / count).round()).abs() < 1e-6));
    // The first 4 % stand still: what the current shows there is noise, with its rounding.
    let still = &log.current_a.as_ref().unwrap()[..80];
    let deviation = (still.iter().map(|i| i * i).sum::<f64>() / 80.0).sqrt();
    let noise = model.sensor.current_noise_a;
    // Three standard errors of 80 samples are 24 %; voltage noise adds a little.
    assert!((deviation / noise - 1.0).abs() < 0.35, "{deviation} where {noise} is right");
}

#[test]
fn the_excitation_runs_the_joint_fast_both_ways_and_stops_it() {
    let model = paper();
    let log = record(&model, &Experiment { duration_s: 1.0, ..Experiment::clean(1.0) }, 3).unwrap();
    let speeds: Vec<f64> = log.motor_angle_rad.windows(11).map(|w| (w[10] - w[0]) / 1e-3).collect();
    let (low, high) = speeds.iter().fold((0.0_f64, 0.0_f64), |(l, h), v| (l.min(*v), h.max(*v)));
    assert!(low < -200.0 && high > 200.0 && high < 1500.0, "{low} to {high} rad/s");
    assert_eq!(speeds.last(), Some(&0.0));
}

#[test]
fn a_perturbed_model_is_wrong_everywhere_and_still_admissible() {
    let model = paper();
    for seed in 0..50 {
        let other = perturbed(&model, seed);
        let ratio = other.motor.phase_resistance_ohm / model.motor.phase_resistance_ohm;
        assert!((0.03..0.08).contains(&(ratio - 1.0).abs()));
        let ratio = other.stages[1].friction.coulomb_nm / model.stages[1].friction.coulomb_nm;
        assert!((0.1..0.2).contains(&(ratio - 1.0).abs()));
        assert_eq!(other.stages[0].reduction, 32.0);
        let admissible = joint_core::params::validate(&other.motor, &other.stages, &other.load);
        assert_eq!(admissible, Ok(()));
    }
}

#[test]
fn an_experiment_without_length_is_refused() {
    let nothing = Experiment { duration_s: f64::NAN, ..Experiment::default() };
    assert!(record(&paper(), &nothing, 0).is_err());
    assert!(record(&paper(), &Experiment { duration_s: 0.0, ..nothing }, 0).is_err());
}
