//! Parts of the gap, made up and of a motor's log.

use std::f64::consts::SQRT_2;

use super::*;
use crate::discover::candidates::cogging;
use crate::discover::evidence::unseen::unseen;
use crate::discover::trial;
use crate::estimate::noise::expected;
use crate::log::Log;

#[test]
fn the_parts_add_up_to_one_and_none_is_below_zero() {
    for (after, white, share) in
        [(0.1, 0.05, 0.5), (2.0, 0.3, 0.0), (0.0, 1.0, 0.9), (0.5, 9.0, 0.2)]
    {
        let gone = Disturbances { before: vec![1.0; 10], after: vec![after; 10] };
        let unnamed =
            Predicted { share: Share { value: share, error: 0.01 }, ..Predicted::default() };
        let budget = split(&gone, 10.0 * white, Some(&unnamed), 100.0, 1.0);
        let parts = [budget.named, budget.unnamed, budget.coloured, budget.white];
        assert!((parts.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{budget:?}");
        assert!(parts.iter().all(|part| *part >= 0.0), "{budget:?}");
    }
}

#[test]
fn what_is_unnamed_is_told_against_what_drives_the_joint() {
    let gone = Disturbances { before: vec![400.0; 10], after: vec![100.0; 10] };
    let unnamed = Predicted { share: Share { value: 0.25, error: 0.01 }, ..Predicted::default() };
    let budget = split(&gone, 0.0, Some(&unnamed), 1000.0, 10.0);
    // 1 unit RMS is left, a quarter of its square is unnamed: 0.5 of 10.
    assert!((budget.rms_after - 1.0).abs() < 1e-12);
    assert!((budget.unnamed_of_drive.unwrap() - 0.05).abs() < 1e-12, "{budget:?}");
    assert!((budget.unnamed - 0.0625).abs() < 1e-12);
    assert!((budget.unnamed_error - 0.0025).abs() < 1e-12);
    // No white noise was given, so all of the one unit is left, a tenth of the drive.
    assert!((budget.rms_left - 1.0).abs() < 1e-12);
    assert!((budget.left_of_drive.unwrap() - 0.1).abs() < 1e-12);
    // Beside a drive of nothing there is no share, not one of zero.
    let still = split(&gone, 0.0, Some(&unnamed), 1000.0, 0.0);
    assert_eq!((still.unnamed_of_drive, still.left_of_drive), (None, None));
}

#[test]
fn motor_torque_drives_a_torque_with_or_without_a_measured_current_and_voltage_a_voltage() {
    let model = trial::motor();
    let log = trial::log(&model, trial::line(12.0), 4.0);
    let blind = Log { current_a: None, ..log.clone() };
    let [record, blind] = [&log, &blind].map(|log| Record::new(log, None));
    let rms =
        |values: &[f64]| (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
    let tested = vec![true; record.len()];
    let current = log.current_a.clone().unwrap();
    let constant = model.motor.torque_constant_nm_per_a;
    let of = |record: &Record, equation: Equation| {
        drive(record, &model, Walk::random(equation, 1.0, 1.0), &tested, &current)
    };
    for record in [&record, &blind] {
        let torque = of(record, Equation::Torque(0));
        assert!((torque / (constant * rms(&current)) - 1.0).abs() < 1e-9, "{torque}");
        let volts = of(record, Equation::Voltage);
        assert!((volts / rms(&record.drive_values) - 1.0).abs() < 1e-9, "{volts}");
    }
}

#[test]
fn white_noise_has_its_share_of_what_the_nominal_misses_and_all_of_nothing() {
    let gone = Disturbances { before: vec![400.0; 10], after: vec![100.0; 10] };
    let budget = split(&gone, 400.0, None, 1000.0, 10.0);
    let Budget { named, white, coloured, rms_before, .. } = budget;
    assert!([named - 0.75, white - 0.1, coloured - 0.15].iter().all(|off| off.abs() < 1e-12));
    assert_eq!(rms_before, 2.0);
    let gone = Disturbances { before: vec![0.0; 10], after: vec![0.0; 10] };
    assert_eq!(split(&gone, 0.0, None, 1000.0, 10.0).white, 1.0);
}

#[test]
fn an_equation_is_believed_to_scatter_by_so_many_times_its_own_noise() {
    let model = trial::motor();
    let record = Record::new(&trial::log(&model, trial::line(12.0), 4.0), None);
    let sensors = [0.1, 0.2, 0.4];
    let noise = Noise { drive: 0.5, torque: 0.25, sensors, ..expected(&model, &record) };
    assert_eq!(most_scatter(Equation::Voltage, &noise), DRIVE_RATIO * 0.5);
    assert_eq!(most_scatter(Equation::Torque(3), &noise), TORQUE_RATIO * 0.25);
    assert_eq!(most_scatter(Equation::Sensor(Channel::Motor), &noise), LOST * sensors[1]);
}

#[test]
fn what_exceeds_the_scatter_in_its_equation_or_behind_the_gear_is_unbelievable() {
    let unbelievable = |over_believable, white_behind| {
        Weighed { over_believable, white_behind, ..Weighed::default() }.is_unbelievable()
    };
    assert!(!unbelievable(1.0, 1.0) && !unbelievable(0.0, 0.0));
    assert!(unbelievable(1.1, 0.0) && unbelievable(0.0, 1.1));
}

#[test]
fn a_disturbance_of_a_sensor_is_about_its_mean_and_of_a_torque_as_it_is() {
    let of = |equation| disturbance(vec![1.0, 2.0, 6.0], Walk::random(equation, 1.0, 1.0));
    assert_eq!(of(Equation::Sensor(Channel::Motor)), [-2.0, -1.0, 3.0]);
    assert_eq!(of(Equation::Torque(0)), [1.0, 2.0, 6.0]);
}

#[test]
fn samples_are_those_of_all_blocks_and_laws_are_weighed_by_current_speed_and_voltage() {
    assert_eq!(blocks_length(&Blocks::over(&[true, true, false, true], 1)), 3.0);
    assert_eq!(blocks_length(&Blocks::over(&[false; 4], 1)), 1.0);
    let names = ["i_a", "t_s", "motor_speed_rad_per_s", "output_speed_rad_per_s", "u_v"];
    let told = weights(&names.map(|name| (name, vec![0.5])));
    assert_eq!(told, [names[0], names[2], names[4]].map(|name| (name, vec![0.5])));
}

#[test]
fn a_sensor_is_driven_by_its_own_signal_about_the_mean_where_it_is_tested_and_seen() {
    let model = trial::motor();
    let mut record = Record::new(&trial::log(&model, trial::line(12.0), 4.0), None);
    let tested: Vec<bool> = (0..record.len()).map(|k| (1..5).contains(&k)).collect();
    let motor = Channel::Motor as usize;
    for (k, angle) in [9.0, 1.0, f64::NAN, 2.0, 6.0, 9.0].into_iter().enumerate() {
        record.measured[k][motor] = angle;
    }
    let walk = Walk::random(Equation::Sensor(Channel::Motor), 1.0, 1.0);
    // Of 1, 2 and 6: 2, 1 and 3 off their mean.
    let rms = drive(&record, &model, walk, &tested, &[]);
    assert!((rms - (14.0_f64 / 3.0).sqrt()).abs() < 1e-12, "{rms}");
}

/// A motor's log in which a line of order 12 is hidden, that many times the usual one.
fn hidden(times: f64) -> Record {
    let line = trial::line(12.0);
    let line = line.with("amplitude_nm", 0.02 * times);
    Record::new(&trial::log(&trial::motor(), line, 4.0), None)
}

#[test]
fn a_line_is_weighed_by_what_the_rotor_misses_without_it() {
    let (nominal, record) = (trial::motor(), hidden(1.0));
    let (tested, mask) = trial::split(&record);
    let problem = Problem::new(&record, &mask).rough();
    let before = trial::fitted(&problem, &nominal, &[]).fit;
    let mut after = trial::fitted(&problem, &nominal, &[cogging::line(12.0, 0.01, false)]).fit;
    // A mass behind the rotor, if there were one, needs nine times what is expected of it.
    let expected = Noise { output: 1e-12, ..expected(&nominal, &record) };
    after.noise.output = 9e-12;
    let own = unseen(&problem, &before, &after, &tested).unwrap();
    let nothing = Unseen { series: vec![0.0; record.len()], ..Unseen::default() };
    let scale = 20.0 * expected.torque;
    let walk = Walk::random(Equation::Torque(0), scale, 10.0 * scale);
    let told = |effects: &[Unseen]| {
        weigh(&problem, [&before, &after], walk, [&expected; 2], &tested, effects).unwrap()
    };
    let both = told(&[own.clone(), nothing]);
    let budget = both.budget.unwrap();
    let Budget { named, unnamed, coloured, white, .. } = budget;
    assert!((named + unnamed + coloured + white - 1.0).abs() < 1e-12 && named > 0.9, "{budget:?}");
    assert_eq!((&*budget.equation, &*budget.unit), ("rotor torque", "Nm"));
    // RMS of a line of 20 mNm.
    assert!((budget.rms_before / (0.02 / SQRT_2) - 1.0).abs() < 0.1, "{budget:?}");
    assert_eq!([both.shares[0].value, both.shares[1].value], [named, 0.0]);
    assert_eq!(both.over_believable, budget.rms_left / (TORQUE_RATIO * expected.torque));
    assert_eq!((both.white_behind, both.of_sensor), (9.0 / TORQUE_RATIO, false));
    let alone = told(&[own]).shares;
    assert_eq!(alone.iter().map(|share| share.value).collect::<Vec<_>>(), [named]);
    assert!(told(&[]).shares.is_empty());
}

#[test]
fn what_a_complete_model_leaves_is_what_white_noise_leaves_of_its_replicates() {
    let (nominal, record) = (trial::motor(), hidden(0.0));
    let mask = vec![1.0; record.len()];
    let problem = Problem::new(&record, &mask).rough();
    let fit = trial::fitted(&problem, &nominal, &[]).fit;
    let expected = expected(&nominal, &record);
    let walk = Walk::random(Equation::Torque(0), 20.0 * expected.torque, 200.0 * expected.torque);
    let series = disturbance_of(&run_beside(&problem, &fit.model, &expected, walk).unwrap());
    let blocks = Blocks::of_series(&vec![true; record.len()], &series);
    let left: f64 = blocks.squares(&series).iter().sum();
    let white = white(&problem, &fit, walk, [&expected; 2], &blocks).unwrap();
    assert!((0.5..2.0).contains(&(white / left)), "{white} {left}");
}

#[test]
fn a_free_run_is_told_by_signal_and_by_the_geometric_mean_of_its_factors() {
    let (nominal, record) = (trial::motor(), hidden(1.0));
    let mask = vec![1.0; record.len()];
    let problem = Problem::new(&record, &mask).rough();
    let before = trial::fitted(&problem, &nominal, &[]).fit;
    let after = trial::fitted(&problem, &nominal, &[cogging::line(12.0, 0.01, false)]).fit;
    let tested: Vec<bool> = (0..record.len()).map(|k| k < 11 || (100..121).contains(&k)).collect();
    let noise = expected(&nominal, &record);
    let run = FreeRun::of(&record, [&before, &after], &noise, &tested).unwrap();
    assert_eq!(run.signals.keys().collect::<Vec<_>>(), ["i_a", "motor_angle_rad"]);
    assert_eq!((run.mode, run.stretches), ("open loop", 2));
    assert!((run.longest_s - 20.0 * (record.time_s[1] - record.time_s[0])).abs() < 1e-12);
    let signals = [("one", [1.0, 8.0]), ("other", [3.0, 1.5])];
    let signals = signals.map(|(name, errors)| (name.to_owned(), errors)).into();
    let made = FreeRun { signals, ..FreeRun::default() };
    assert!((made.factor() - 2.0).abs() < 1e-12);
    assert_eq!(FreeRun::default().factor(), 1.0);
}
