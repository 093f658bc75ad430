use super::*;
use crate::demo::actuator;
use crate::reference::friction::Family;
use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

fn setting(motion: Motion) -> Setting {
    Setting {
        motion,
        duration_s: 1.0,
        sample_time_s: 2e-4,
        friction: Family::LuGre,
        stribeck_exponent: 2.0,
        disturbance: Disturbances::default(),
        sensing: Sensing::default(),
    }
}

const MOTIONS: [Motion; 7] = [
    Motion::Sequence,
    Motion::Multisine,
    Motion::Trapezoids,
    Motion::MovesPPi,
    Motion::MovesPd,
    Motion::SlowScans,
    Motion::Swings,
];

#[test]
fn every_motion_moves_the_joint_both_ways_and_stays_finite() {
    let mut model = actuator();
    for motion in MOTIONS {
        model.load.gravity_nm = if motion == Motion::Swings { 1.0 } else { 0.0 };
        let log = record_wide(&model, &setting(motion), 3).unwrap().log;
        let angle = &log.motor_angle_rad;
        let steps: Vec<f64> = angle.windows(101).map(|pair| pair[100] - pair[0]).collect();
        let (low, high) = steps.iter().fold((0.0_f64, 0.0_f64), |(l, h), s| (l.min(*s), h.max(*s)));
        // A hundred counts in 20 ms are far beyond what rounding or a creeping bristle shows.
        let count = TAU / model.sensor.motor_encoder_counts_per_rev;
        assert!(low < -20.0 * count && high > 20.0 * count, "{motion:?}: {low} to {high}");
        assert!(angle.iter().all(|q| q.abs() < 1e4), "{motion:?}");
    }
}

#[test]
fn a_controlled_axis_follows_its_reference() {
    let model = actuator();
    for motion in [Motion::MovesPPi, Motion::MovesPd, Motion::SlowScans] {
        let log = record_wide(&model, &setting(motion), 9).unwrap().log;
        let reference = log.reference_angle_rad.unwrap();
        let rms = |values: &mut dyn Iterator<Item = f64>| {
            (values.map(|x| x * x).sum::<f64>() / reference.len() as f64).sqrt()
        };
        let far = rms(&mut reference.iter().copied());
        let pairs = reference.iter().zip(&log.motor_angle_rad);
        let off = rms(&mut pairs.map(|(wanted, angle)| wanted - angle));
        // The PD law lags by its damping, at most v/ω_p: some way of a move that takes a few of
        // its time constants.
        let most = if motion == Motion::MovesPd { 0.8 } else { 0.2 };
        assert!(far > 0.1 && off < most * far, "{motion:?}: {off} of {far}");
    }
}

#[test]
fn an_effect_is_seen_by_how_much_it_changes() {
    let ratio = |amplitude: f64, disturbed: f64| {
        let mut model = actuator();
        let cogging = EffectParameters::new(Kind::Cogging, Location::Motor);
        model.effects.push(cogging.with("order", 42.0).with("amplitude_nm", amplitude));
        let mut setting = setting(Motion::Sequence);
        setting.disturbance.torque = Colour { deviation: disturbed, correlation_s: 0.01 };
        record_wide(&model, &setting, 5).unwrap().signal_to_noise[0]
    };
    let (clear, small, buried) = (ratio(0.02, 1e-3), ratio(0.002, 1e-3), ratio(0.02, 0.3));
    assert!(clear > 1.0 && small < 0.5 * clear && buried < 0.2 * clear, "{clear} {small} {buried}");
    assert!(small > 0.0);
}

#[test]
fn without_misfits_the_run_is_the_narrow_one() {
    // The same joint, motion and method: a voltage that is held steps both alike.
    let model = actuator();
    let log = record_wide(&model, &setting(Motion::Trapezoids), 4).unwrap().log;
    let voltage = log.voltage_v.clone().unwrap();
    let given = Experiment {
        voltage_v: Some(voltage),
        sample_time_s: 2e-4,
        rest_s: [0.1, 0.1],
        ..Experiment::clean(1.0)
    };
    let other = record(&model, &given, 4).unwrap();
    let count = TAU / model.sensor.motor_encoder_counts_per_rev;
    for (own, other) in log.motor_angle_rad.iter().zip(&other.motor_angle_rad) {
        // The step's share is 0.6 here and 0.4 there: below a thousandth of the way, and a count.
        assert!((own - other).abs() < 2.0 * count + 1e-3 * other.abs(), "{own} {other}");
    }
}

#[test]
fn removing_an_effect_with_a_memory_leaves_the_rest_of_the_state() {
    let mut model = actuator();
    let heating = EffectParameters::new(Kind::WindingHeating, Location::Motor)
        .with("relative_rise", 1e-9)
        .with("time_constant_s", 1.0)
        .with("reference_current_a", 1.0);
    let coating = EffectParameters::new(Kind::Coating, Location::Output)
        .with("stiffness_nm_per_rad", 0.5)
        .with("hysteresis_nm", 0.5);
    model.effects = vec![heating, coating];
    let mut own = setting(Motion::Sequence);
    own.friction = Family::MaxwellSlip { elements: 4, attraction: 1.0 };
    let ratios = record_wide(&model, &own, 8).unwrap().signal_to_noise;
    assert!(ratios[0] < 1e-3 && ratios[1] > 1.0, "{ratios:?}");
}

#[test]
fn a_late_current_is_what_flowed_that_long_before() {
    let mut model = actuator();
    // A winding that settles within a sample.
    model.motor.phase_inductance_h = 0.1 * 2e-4 * model.motor.phase_resistance_ohm;
    model.sensor.current_noise_a = 0.0;
    let shown = |reported: Reported| {
        let mut own = setting(Motion::Multisine);
        own.sensing.current = reported;
        record_wide(&model, &own, 4).unwrap().log.current_a.unwrap()
    };
    let [at_once, whole, part] =
        [Reported::AtOnce, Reported::Late(2.0), Reported::Late(2.5)].map(shown);
    let largest = at_once.iter().fold(0.0, |most: f64, i| most.max(i.abs()));
    let near = |a: f64, b: f64, share: f64| (a - b).abs() < share * largest;
    assert!((10..at_once.len()).all(|k| near(whole[k], at_once[k - 2], 1e-4)));
    // Half a sample is five time constants, behind which the winding is where the sample's end finds it.
    assert!((10..at_once.len()).all(|k| near(part[k], at_once[k - 2], 0.02)));
    // Where it changes most that is far from the middle between both samples.
    let step = |k: &usize| (at_once[k - 2] - at_once[k - 3]).abs();
    let k = (10..at_once.len()).max_by(|a, b| step(a).total_cmp(&step(b))).unwrap();
    let middle = 0.5 * (at_once[k - 2] + at_once[k - 3]);
    assert!(
        (part[k] - at_once[k - 2]).abs() < 0.5 * (part[k] - middle).abs(),
        "{} {middle}",
        part[k]
    );
}
