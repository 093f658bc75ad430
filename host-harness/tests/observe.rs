//! The observer on joints whose truth is known: how good it is, and what it bears.

use host_harness::model::Model;
use host_harness::observe::baseline::Baseline;
use host_harness::observe::bench::simulated;
use host_harness::observe::counted;
use host_harness::observe::design::{Tuning, design};
use host_harness::observe::judge::shown;
use host_harness::observe::rating::Rating;
use host_harness::observe::run::{Found, Seen, observer, run, run_fixed};
use host_harness::observe::twin::{Felt, Motion, Style, Twin};
use joint_core::fixed::Fixed;
use joint_core::joint::Drive;
use joint_core::observer::Status;
use joint_core::per_unit::Bases;

const STEP_S: f64 = 1e-4;
const SAMPLES: usize = 6000;
const LOAD_NM: f64 = 0.02;

fn model() -> Model {
    counted::model(STEP_S)
}

fn rating(model: &Model) -> Rating {
    Rating { load_nm: LOAD_NM, drive: 4.5, ..Rating::of(model, Drive::Voltage) }
}

fn motion(truth: &Model) -> Twin {
    made(truth, &rating(truth)).run().unwrap()
}

fn made<'a>(truth: &'a Model, rating: &'a Rating) -> Motion<'a> {
    Motion {
        truth,
        kind: Drive::Voltage,
        step_s: STEP_S,
        rating,
        felt: Felt { drive: 0.005, torque: 1e-7 },
        style: Style::Creep,
        samples: SAMPLES,
        seed: 11,
    }
}

fn found(model: &Model, seen: &[Seen]) -> Vec<Found<2>> {
    let design =
        design::<2>(model, Drive::Voltage, STEP_S, &rating(model), &Tuning::default()).unwrap();
    run(&observer::<f32, 2>(model, Drive::Voltage, STEP_S, &design).unwrap(), seen, &[])
}

/// RMS error of the load from a sample on, share of its rating.
fn load_error(found: &[Found<2>], motion: &Twin, from: usize) -> f64 {
    let errors = found.iter().zip(&motion.load).skip(from);
    let squares: f64 = errors.map(|(f, load)| (f.estimate.load - load).powi(2)).sum();
    (squares / (found.len() - from) as f64).sqrt() / LOAD_NM
}

#[test]
fn the_load_is_found_with_an_output_encoder_and_without() {
    let model = model();
    let motion = motion(&model);
    for (output, bound) in [(true, 0.06), (false, 0.15)] {
        let seen = shown(&model, Drive::Voltage, &motion, output, 1);
        let error = load_error(&found(&model, &seen), &motion, 600);
        println!("output encoder {output}: load error {error:.4}");
        assert!(error < bound, "{error} with output encoder {output}");
    }
}

#[test]
fn faults_raise_a_flag_stay_bounded_and_are_recovered_from() {
    let model = model();
    let motion = motion(&model);
    let clean = shown(&model, Drive::Voltage, &motion, true, 1);
    type Fault = (&'static str, Status, fn(&mut Seen));
    let faults: [Fault; 6] = [
        ("lost", Status::COASTING, |s| s.motor = f64::NAN),
        ("jump", Status::GLITCH, |s| s.motor += 1.5),
        ("output jump", Status::GLITCH, |s| s.output += 1.0),
        ("current at its end", Status::NO_CURRENT, |s| s.current = 1e6),
        ("voltage missing", Status::NO_DRIVE, |s| s.drive = f64::NAN),
        ("voltage infinite", Status::NO_DRIVE, |s| s.drive = f64::INFINITY),
    ];
    for (name, flag, fault) in faults {
        let mut seen = clean.clone();
        // Three samples in a row, now and then.
        for k in (1500..2500).filter(|k| k % 100 < 3) {
            fault(&mut seen[k]);
        }
        let found = found(&model, &seen);
        for (k, f) in found.iter().enumerate() {
            let e = &f.estimate;
            let all = [e.load, e.motor_velocity, e.total_friction, e.windup[0], e.windup[1]];
            assert!(all.iter().all(|v| v.is_finite()), "{name} at {k}: {e:?}");
            assert!(e.load.abs() <= 4.1 * LOAD_NM, "{name} at {k}: load {}", e.load);
        }
        assert!(found[1501].estimate.status.has(flag), "{name}: {}", found[1501].estimate.status);
        let after = load_error(&found, &motion, 2700);
        assert!(after < 0.08, "{name}: {after} after it");
    }
}

#[test]
fn repeated_samples_are_noticed_while_the_joint_moves() {
    let model = model();
    let motion = motion(&model);
    let mut seen = shown(&model, Drive::Voltage, &motion, true, 1);
    let fast =
        (1000..SAMPLES).find(|&k| motion.states[k - 5..k + 5].iter().all(|x| x[4].abs() > 1000.0));
    let k = fast.unwrap();
    seen[k] = Seen { drive: seen[k].drive, ..seen[k - 1] };
    let found = found(&model, &seen);
    assert!(found[k].estimate.status.has(Status::REPEATED), "{}", found[k].estimate.status);
}

#[test]
fn it_starts_at_any_speed_and_after_silence_by_itself() {
    let model = model();
    let motion = motion(&model);
    let whole = shown(&model, Drive::Voltage, &motion, true, 1);
    for start in [700, 1300, 2100, 3000] {
        let cut = Twin {
            drive: motion.drive[start..].to_vec(),
            load: motion.load[start..].to_vec(),
            states: motion.states[start..].to_vec(),
            jumps: Vec::new(),
        };
        let error = load_error(&found(&model, &whole[start..]), &cut, 400);
        assert!(error < 0.08, "{error} from sample {start}");
    }
    let mut silent = whole;
    for seen in &mut silent[2000..2800] {
        *seen = Seen { drive: f64::NAN, current: f64::NAN, motor: f64::NAN, output: f64::NAN };
    }
    let found = found(&model, &silent);
    assert!(found[2700].estimate.status.has(Status::LOST), "{}", found[2700].estimate.status);
    assert!(load_error(&found, &motion, 3300) < 0.08);
}

#[test]
fn at_rest_without_an_output_encoder_the_load_is_called_unobservable() {
    let model = model();
    let rest = Twin {
        drive: vec![0.0; 1000],
        load: vec![0.0; 1000],
        states: vec![vec![0.0; 10]; 1000],
        jumps: Vec::new(),
    };
    let found = found(&model, &shown(&model, Drive::Voltage, &rest, false, 1));
    let e = &found[900].estimate;
    assert!(e.status.has(Status::UNOBSERVABLE), "{}", e.status);
    assert!(e.spread.load > 0.2 * LOAD_NM, "{}", e.spread.load);
}

#[test]
fn a_resistance_that_is_off_does_not_pass_for_a_load() {
    let model = model();
    let motion = motion(&model);
    let seen = shown(&model, Drive::Voltage, &motion, true, 1);
    let right = load_error(&found(&model, &seen), &motion, 600);
    let mut wrong = model.clone();
    wrong.motor.phase_resistance_ohm *= 1.15;
    let off = load_error(&found(&wrong, &seen), &motion, 600);
    println!("R +15 %: {off:.4} where {right:.4} is right");
    assert!(off < 2.0 * right, "{off} where {right} is right");
}

#[test]
fn the_bench_judges_baselines_that_find_the_load_and_an_observer_that_finds_it_better() {
    let cases = simulated(2, 1).unwrap();
    let case = &cases[0];
    let load = |wanted| case.baselines.iter().find(|(kind, _)| *kind == wanted).unwrap().1.load;
    for kind in [Baseline::Disturbance, Baseline::Rigid] {
        assert!(load(kind) < 0.5, "{}: {}", kind.name(), load(kind));
        assert!(case.observer.load < load(kind), "{} against {}", case.observer.load, load(kind));
    }
}

/// Every estimate a number, the load within its bound, and its error small from a sample on.
fn bounded_and_back(name: &str, found: &[Found<2>], motion: &Twin, from: usize, back: f64) {
    for (k, f) in found.iter().enumerate() {
        let e = &f.estimate;
        let all = [e.load, e.motor_velocity, e.total_friction, e.windup[0], e.windup[1]];
        assert!(all.iter().all(|v| v.is_finite()), "{name} at {k}: {e:?}");
        assert!(e.load.abs() <= 4.1 * LOAD_NM, "{name} at {k}: load {}", e.load);
    }
    let after = load_error(found, motion, from);
    println!("{name}: {after:.4} after it");
    assert!(after < back, "{name}: {after} after it");
}

fn statuses(found: &[Found<2>]) -> impl Iterator<Item = Status> + '_ {
    found.iter().map(|f| f.estimate.status)
}

#[test]
fn a_current_sensor_that_saturates_is_left_out_as_long_as_it_does() {
    let model = model();
    let motion = motion(&model);
    let mut seen = shown(&model, Drive::Voltage, &motion, true, 1);
    // A sensor whose end is a third of the largest current.
    let most = seen.iter().map(|s| s.current.abs()).fold(0.0, f64::max);
    let end = most / 3.0;
    seen.iter_mut().for_each(|s| s.current = s.current.clamp(-end, end));
    let rating = Rating { current_a: 0.999 * end, ..rating(&model) };
    let design = design::<2>(&model, Drive::Voltage, STEP_S, &rating, &Tuning::default()).unwrap();
    let observer = observer::<f32, 2>(&model, Drive::Voltage, STEP_S, &design).unwrap();
    let found = run(&observer, &seen, &[]);
    for (k, (seen, f)) in seen.iter().zip(&found).enumerate().skip(20) {
        let flagged = f.estimate.status.has(Status::NO_CURRENT);
        assert_eq!(flagged, seen.current.abs() >= 0.999 * end, "sample {k}: {}", seen.current);
    }
    assert!(statuses(&found).any(|s| s.has(Status::NO_CURRENT)));
    bounded_and_back("current saturated", &found, &motion, 600, 0.06);
}

#[test]
fn halls_alone_give_a_coarse_load_and_say_so() {
    let mut model = model();
    model.sensor.motor_encoder_counts_per_rev = 6.0;
    model.sensor.output_encoder_counts_per_rev = 0.0;
    let motion = motion(&model);
    let seen = shown(&model, Drive::Voltage, &motion, false, 1);
    let found = found(&model, &seen);
    bounded_and_back("halls alone", &found, &motion, 600, 0.35);
    // What is said of it: two deviations hold nine of ten errors, and no sample is called a glitch.
    let inside = found.iter().zip(&motion.load).skip(600);
    let inside =
        inside.filter(|(f, load)| (f.estimate.load - **load).abs() <= 2.0 * f.estimate.spread.load);
    let share = inside.count() as f64 / (SAMPLES - 600) as f64;
    println!("halls alone: {share:.3} within two deviations");
    assert!(share > 0.85, "{share} within two deviations");
    let wrong = statuses(&found).skip(600).filter(|s| s.has(Status::GLITCH)).count();
    assert!(wrong < SAMPLES / 100, "{wrong} samples called a glitch");
}

#[test]
fn the_winding_and_the_magnets_are_found_where_the_model_has_them_wrong() {
    let model = model();
    let motion = motion(&model);
    let seen = shown(&model, Drive::Voltage, &motion, false, 1);
    let mut wrong = model.clone();
    wrong.motor.phase_resistance_ohm *= 1.15;
    wrong.motor.torque_constant_nm_per_a *= 1.02;
    wrong.motor.phase_back_emf_constant_v_s_per_rad = None;
    let found = found(&wrong, &seen);
    let e = &found[SAMPLES - 1].estimate;
    println!("resistance {:.4}, flux {:.4}", e.resistance, e.flux);
    assert!((1.15 * (1.0 + e.resistance) - 1.0).abs() < 0.02, "resistance {}", e.resistance);
    assert!((1.02 * (1.0 + e.flux) - 1.0).abs() < 0.006, "flux {}", e.flux);
}

#[test]
fn fixed_point_finds_the_load_as_single_precision_does() {
    let model = model();
    let motion = motion(&model);
    for output in [false, true] {
        let seen = shown(&model, Drive::Voltage, &motion, output, 1);
        let single = found(&model, &seen);
        let design =
            design::<2>(&model, Drive::Voltage, STEP_S, &rating(&model), &Tuning::default())
                .unwrap();
        let fixed = observer::<Fixed, 2>(&model, Drive::Voltage, STEP_S, &design).unwrap();
        let bases = Bases::of(&model.motor, &model.stages, STEP_S);
        let fixed = run_fixed(&fixed, &bases, &seen, &[]);
        let [a, b] = [&single, &fixed].map(|found| load_error(found, &motion, 600));
        println!("output encoder {output}: f32 {a:.4}, fixed point {b:.4}");
        assert!(b < 1.05 * a + 0.002, "{b} in fixed point where f32 has {a}");
        let friction = |found: &[Found<2>]| -> Vec<f64> {
            found.iter().map(|f| f.estimate.total_friction).collect()
        };
        let (a, b) = (friction(&single), friction(&fixed));
        let square = |values: &mut dyn Iterator<Item = f64>| -> f64 { values.map(|v| v * v).sum() };
        let apart =
            square(&mut a.iter().zip(&b).map(|(a, b)| a - b)) / square(&mut a.iter().copied());
        assert!(apart.sqrt() < 0.05, "friction is {} apart", apart.sqrt());
    }
}

/// A bus that dips for a while, at several times of a motion: the drive puts out less than it is told.
struct Dip {
    share: f64,
    samples: usize,
}

const DIPS: [usize; 3] = [3250, 4050, 4850];
/// Samples that it may take to recover: 50 ms.
const RECOVERY: usize = 500;

impl Dip {
    fn at(&self, k: usize) -> bool {
        DIPS.iter().any(|&from| (from..from + self.samples).contains(&k))
    }

    /// Within the time that it may take to recover.
    fn near(&self, k: usize) -> bool {
        DIPS.iter().any(|&from| (from..from + self.samples + RECOVERY).contains(&k))
    }

    /// The motion under it, and what sensors show of it to a drive that does not measure its bus.
    fn of(&self, model: &Model, output: bool) -> (Twin, Vec<Seen>) {
        let clean = motion(model);
        let put_out =
            |(k, drive): (usize, &f64)| drive * if self.at(k) { 1.0 - self.share } else { 1.0 };
        let drive = clean.drive.iter().enumerate().map(put_out).collect();
        let rating = rating(model);
        let motion = made(model, &rating).under(drive, clean.load).unwrap();
        let mut seen = shown(model, Drive::Voltage, &motion, output, 1);
        seen.iter_mut().zip(&clean.drive).for_each(|(seen, told)| seen.drive = *told);
        (motion, seen)
    }
}

/// RMS error of the load where `when` says so, share of its rating.
fn error_when(found: &[Found<2>], motion: &Twin, when: impl Fn(usize) -> bool) -> f64 {
    let rows = found.iter().zip(&motion.load).enumerate().skip(600).filter(|(k, _)| when(*k));
    let errors: Vec<f64> = rows.map(|(_, (f, load))| (f.estimate.load - load).powi(2)).collect();
    (errors.iter().sum::<f64>() / errors.len() as f64).sqrt() / LOAD_NM
}

#[test]
fn a_bus_that_dips_unknown_to_the_observer_is_flagged_and_nothing_slow_is_learned_of_it() {
    let model = model();
    let design =
        design::<2>(&model, Drive::Voltage, STEP_S, &rating(&model), &Tuning::default()).unwrap();
    let single = observer::<f32, 2>(&model, Drive::Voltage, STEP_S, &design).unwrap();
    let fixed = observer::<Fixed, 2>(&model, Drive::Voltage, STEP_S, &design).unwrap();
    let bases = Bases::of(&model.motor, &model.stages, STEP_S);
    for (share, samples) in [(0.3, 50), (0.3, 200), (0.5, 50), (0.5, 200)] {
        let dip = Dip { share, samples };
        for output in [false, true] {
            let (motion, unmeasured) = dip.of(&model, output);
            let mut measured = unmeasured.clone();
            measured.iter_mut().zip(&motion.drive).for_each(|(seen, drive)| seen.drive = *drive);
            type Run<'a> = (&'a str, &'a dyn Fn(&[Seen]) -> Vec<Found<2>>);
            let runs: [Run<'_>; 2] = [
                ("f32", &|seen| run(&single, seen, &[])),
                ("fixed", &|seen| run_fixed(&fixed, &bases, seen, &[])),
            ];
            for (scalar, run) in runs {
                let name = format!("{scalar}, {share} for {samples}, output {output}");
                let (right, found) = (run(&measured), run(&unmeasured));
                let bad = |f: &Found<2>| f.estimate.status.has(Status::MISMATCH);
                assert!(!right.iter().any(bad), "{name}: a dip that is measured is none");
                for from in DIPS {
                    // Where hardly any voltage is put out there is none to miss.
                    let told = unmeasured[from..from + samples].iter().map(|s| s.drive.abs());
                    if told.fold(0.0, f64::max) > 1.0 {
                        let flagged = found[from..from + samples].iter().any(bad);
                        assert!(flagged, "{name}: no mismatch at {from}");
                    }
                    let after = found[from + samples + RECOVERY].estimate.status;
                    assert!(!after.has(Status::MISMATCH), "{name}: {after} 50 ms after {from}");
                }
                let near = |k: usize| dip.near(k);
                let [during, right_during] =
                    [&found, &right].map(|found| error_when(found, &motion, near));
                let [after, right_after] =
                    [&found, &right].map(|found| error_when(found, &motion, |k| !near(k)));
                let e = &found[SAMPLES - 1].estimate;
                println!(
                    "{name}: load {during:.4} ({right_during:.4}) about it, {after:.4} \
                     ({right_after:.4}) apart; R {:+.4}, flux {:+.4}, friction {:+.4}",
                    e.resistance, e.flux, e.friction
                );
                assert!(during < 0.25, "{name}: load {during} about a dip");
                assert!(after < 1.1 * right_after, "{name}: load {after} apart from dips");
                let kept = &right[SAMPLES - 1].estimate;
                for (slow, kept, most) in [
                    (e.resistance, kept.resistance, 0.005),
                    (e.flux, kept.flux, 0.003),
                    (e.friction, kept.friction, 0.03),
                ] {
                    assert!((slow - kept).abs() < most, "{name}: {slow} where {kept} is kept");
                }
                bounded_and_back(&name, &found, &motion, 600, 0.25);
            }
        }
    }
}
