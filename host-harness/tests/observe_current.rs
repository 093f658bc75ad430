//! The observer of a drive in torque mode: the current is the input, and no voltage is known.

use host_harness::log::Log;
use host_harness::model::Model;
use host_harness::observe::bound::{Known, bounds};
use host_harness::observe::counted;
use host_harness::observe::design::Tuning;
use host_harness::observe::judge::shown;
use host_harness::observe::over::Samples;
use host_harness::observe::rating::Rating;
use host_harness::observe::run::Found;
use host_harness::observe::twin::{Felt, Motion, Style, Twin};
use host_harness::plant::ScalarKind;
use joint_core::joint::Drive;
use joint_core::observer::Status;

const STEP_S: f64 = 1e-4;
const SAMPLES: usize = 6000;
const LOAD_NM: f64 = 0.02;
/// Samples at the start that do not count.
const START: usize = 600;

/// The paper's joint with a winding that nobody knows.
fn model() -> Model {
    let mut model = counted::model(STEP_S);
    model.motor.phase_resistance_ohm = 0.0;
    model.motor.phase_inductance_h = 0.0;
    model
}

/// A motion in torque mode and what a drive logs of it: current, rotor and, where asked for, output.
fn recorded(output: bool) -> (Twin, Log) {
    let model = model();
    let rating = rating();
    let motion = Motion {
        truth: &model,
        kind: Drive::Current,
        step_s: STEP_S,
        rating: &rating,
        felt: felt(&rating),
        style: Style::Creep,
        samples: SAMPLES,
        seed: 11,
    };
    let motion = motion.run().unwrap();
    let seen = shown(&model, Drive::Current, &motion, output, 1);
    let log = Log {
        time_s: (0..SAMPLES).map(|k| k as f64 * STEP_S).collect(),
        current_a: Some(seen.iter().map(|seen| seen.drive).collect()),
        motor_angle_rad: seen.iter().map(|seen| seen.motor).collect(),
        output_angle_rad: output.then(|| seen.iter().map(|seen| seen.output).collect()),
        ..Log::default()
    };
    (motion, log)
}

/// RMS error of the load of the best full filter on the motion, share of the rating.
fn full_filter(motion: &Twin, output: bool) -> f64 {
    let (model, rating) = (model(), rating());
    let felt = felt(&rating);
    let (kind, step_s) = (Drive::Current, STEP_S);
    let known = Known { truth: &model, kind, step_s, rating: &rating, motion, felt, output };
    let peak = motion.load.iter().fold(0.0_f64, |most, load| most.max(load.abs()));
    bounds(&known).unwrap().filter.load * peak / LOAD_NM
}

fn rating() -> Rating {
    let of_voltage = Rating::of(&counted::model(STEP_S), Drive::Current);
    Rating { load_nm: LOAD_NM, drive: 0.3 * of_voltage.drive, ..of_voltage }
}

fn felt(rating: &Rating) -> Felt {
    Felt { drive: 1e-3 * rating.drive, torque: 1e-7 }
}

fn found(log: &Log, scalar: ScalarKind) -> Vec<Found<2>> {
    let samples = Samples::of(log);
    assert_eq!(samples.kind, Drive::Current);
    let (model, rating) = samples.sensed::<2>(&model(), Some(LOAD_NM)).unwrap();
    samples.observed::<2>(&model, &rating, &Tuning::default(), scalar).unwrap()
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, n), v| (sum + v * v, n + 1.0));
    f64::sqrt(sum / count)
}

/// RMS errors of speed, share of its RMS, and of the load, share of its rating.
fn errors(found: &[Found<2>], motion: &Twin) -> [f64; 2] {
    let rows = || found.iter().zip(&motion.states).skip(START);
    let speed = rms(rows().map(|(f, x)| f.estimate.motor_velocity - x[4]));
    let loads = found.iter().zip(&motion.load).skip(START);
    let load = rms(loads.map(|(f, load)| f.estimate.load - load));
    [speed / rms(rows().map(|(_, x)| x[4])), load / LOAD_NM]
}

fn bounded(name: &str, found: &[Found<2>]) {
    for (k, f) in found.iter().enumerate() {
        let e = &f.estimate;
        let all = [e.load, e.motor_velocity, e.total_friction, e.windup[0], e.windup[1]];
        assert!(all.iter().all(|v| v.is_finite()), "{name} at {k}: {e:?}");
        // Four times the rating is where the design holds the load; the last place is an f32's.
        assert!(e.load.abs() <= 4.0001 * LOAD_NM, "{name} at {k}: load {}", e.load);
    }
}

#[test]
fn a_log_with_a_current_alone_gives_speed_output_and_load() {
    for output in [true, false] {
        let (motion, log) = recorded(output);
        // A guard: gains that are constant within a regime cost a third of the best full filter's error
        // here and under voltage (docs/observer.md). Half is a regression.
        let most = 1.5 * full_filter(&motion, output);
        for scalar in [ScalarKind::F32, ScalarKind::Fixed] {
            let found = found(&log, scalar);
            let name = format!("{scalar:?}, output {output}");
            bounded(&name, &found);
            let [speed, load] = errors(&found, &motion);
            println!("{name}: speed {speed:.4}, load {load:.4} (at most {most:.4})");
            assert!(speed < 0.03, "{name}: speed {speed}");
            assert!(load < most, "{name}: load {load}");
            // Never farther off than the rotor's angle over the ratio, and an encoder's count.
            let shaft = 1.0 / 1024.0;
            let count = std::f64::consts::TAU / 65_536.0;
            let rows = || found.iter().zip(&motion.states).skip(START);
            let own = rms(rows().map(|(f, x)| f.output_angle - (x[1] - x[2] - x[3]) * shaft));
            let rigid = rms(rows().map(|(_, x)| (x[2] + x[3]) * shaft));
            println!("{name}: output {own:.2e} rad off, rigid {rigid:.2e}");
            assert!(own < rigid + count, "{name}: {own} where a rigid gear is {rigid} off");
            // A rotor that leaps free after a rest may look like a glitch for a sample: in one of a
            // hundred at most.
            let flagged = found.iter().skip(START).filter(|f| {
                let flags = [Status::GLITCH, Status::NO_DRIVE, Status::NO_CURRENT];
                flags.iter().any(|flag| f.estimate.status.has(*flag))
            });
            let flagged = flagged.count();
            assert!(flagged < SAMPLES / 100, "{name}: {flagged} samples flagged");
        }
    }
}

#[test]
fn gaps_of_the_current_are_flagged_and_recovered_from() {
    let (motion, mut log) = recorded(true);
    let gap = |k: usize| (2000..3000).contains(&k) && k % 200 < 20;
    let current = log.current_a.as_mut().unwrap();
    (0..SAMPLES).filter(|&k| gap(k)).for_each(|k| current[k] = f64::NAN);
    for scalar in [ScalarKind::F32, ScalarKind::Fixed] {
        let found = found(&log, scalar);
        bounded("gaps", &found);
        for (k, f) in found.iter().enumerate() {
            assert_eq!(f.estimate.status.has(Status::NO_DRIVE), gap(k), "sample {k}");
        }
        let [speed, load] = errors(&found, &motion);
        println!("{scalar:?}, gaps: speed {speed:.4}, load {load:.4}");
        // Over 2 ms of each 20 the last current is held, for a sixth of the record.
        assert!(speed < 0.03 && load < 0.1, "{scalar:?}: speed {speed}, load {load}");
    }
}

/// The torque that moves the rotor is then unknown, and the load that would stand for it ends at its bound:
/// the flag is what a reader goes by, and nothing leaves its range.
#[test]
fn without_a_current_and_a_voltage_every_sample_says_so_and_the_load_stays_bounded() {
    let (_, mut log) = recorded(true);
    log.current_a.as_mut().unwrap().fill(f64::NAN);
    for scalar in [ScalarKind::F32, ScalarKind::Fixed] {
        let found = found(&log, scalar);
        bounded("no drive", &found);
        assert!(found.iter().all(|f| f.estimate.status.has(Status::NO_DRIVE)));
    }
}

#[test]
fn a_voltage_that_is_mostly_missing_gives_way_to_the_current() {
    let (_, mut log) = recorded(false);
    log.voltage_v = Some((0..SAMPLES).map(|k| if k < 10 { 0.0 } else { f64::NAN }).collect());
    assert_eq!(Samples::of(&log).kind, Drive::Current);
    log.voltage_v = Some(vec![0.0; SAMPLES]);
    assert_eq!(Samples::of(&log).kind, Drive::Voltage);
}

/// Behind a stop the angles stay the same while the current goes on: a rest, and no sample that came twice.
#[test]
fn a_shaft_that_runs_into_a_stop_is_seen_at_rest() {
    let (motion, mut log) = recorded(true);
    // Where it is fastest in the middle of the record.
    let speed = |k: &usize| motion.states[*k][4].abs();
    let stop = (2000..4000).max_by(|a, b| speed(a).total_cmp(&speed(b))).unwrap();
    let held = log.motor_angle_rad[stop];
    log.motor_angle_rad[stop..].fill(held);
    let output = log.output_angle_rad.as_mut().unwrap();
    let at = output[stop];
    output[stop..].fill(at);
    for scalar in [ScalarKind::F32, ScalarKind::Fixed] {
        let found = found(&log, scalar);
        bounded("stop", &found);
        let behind = found.iter().skip(stop);
        let left_out = behind.clone().filter(|f| f.estimate.status.has(Status::REPEATED)).count();
        // 20 ms are a new start's. With the encoder left out a quarter of the speed stays.
        let calm = rms(behind.skip(250).map(|f| f.estimate.motor_velocity)) / speed(&stop);
        let off = (found[SAMPLES - 1].output_angle - at).abs();
        println!("{scalar:?}: {left_out} left out, {calm:.4} of the speed, {off:.2e} rad off");
        assert!(left_out == 0 && calm < 0.1 && off < 0.001, "{scalar:?}: {left_out} {calm} {off}");
    }
}
