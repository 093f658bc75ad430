//! A soak on the emulated chip: a minute of control periods with a fault in every second, in f32 and in fixed
//! point. The chip's estimates are the host's to the bit, and the host's are finite, with the rotor within its bound.
//!
//! `cargo test --release -p joint-tests --test soak -- --ignored --nocapture` runs it; ten seconds of it are in
//! every build, on the host alone.

use std::fs;
use std::path::PathBuf;

use firmware::block::{PAGE_BYTES, encode};
use firmware::observing::{
    fixed_from_bytes, fixed_row, fixed_to_bytes, from_bytes, row, row_numbers, to_bytes,
};
use joint_core::fixed::Fixed;
use joint_core::joint::{Drive, Joint, Settings};
use joint_core::number::Number;
use joint_core::observer::{Observer, Sample, Status, Track, Turn};
use joint_core::params::Load;
use joint_core::scalar::Real;
use joint_core::telemetry::frame::CRC32;
use joint_tests::drive::{COUNTS, PERIOD_S, motor, observer, plain_gear};
use joint_tests::qemu::{self, Board};
use joint_tests::random::Random;

/// Updates in a second.
const RATE: usize = 20_000;
/// Seconds of one run: the emulator has two minutes for each.
const SECONDS: usize = 10;
const RUNS: u64 = 6;
/// A fault lasts from the tenth part of its second on, for at most a quarter of a second.
const BEGIN: usize = RATE / 10;
const LONGEST: usize = RATE / 4;

/// What the observer's gains are for: beyond it resistance and flux are learned too fast.
const VOLTS: f64 = 0.7;
const LOAD_NM: f64 = 0.004;

/// The observer starts anew beyond a rotor's speed of a hundred units, and may pass them in one step. What its other
/// estimates may reach is asked of gains that were designed (`host-harness/tests/observer_attack.rs`); these are put by
/// hand.
const MOST_ROTOR: f64 = 110.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fault {
    MotorLost,
    OutputLost,
    Frozen,
    Swapped,
    MotorJumps,
    MotorNoise,
    CurrentLost,
    CurrentEnds,
    DriveNone,
    DriveHuge,
    TimeJumps,
}

impl Fault {
    const ALL: [Fault; 11] = [
        Fault::MotorLost,
        Fault::OutputLost,
        Fault::Frozen,
        Fault::Swapped,
        Fault::MotorJumps,
        Fault::MotorNoise,
        Fault::CurrentLost,
        Fault::CurrentEnds,
        Fault::DriveNone,
        Fault::DriveHuge,
        Fault::TimeJumps,
    ];

    fn seen(
        self,
        mut sample: Sample<f32>,
        before: Sample<f32>,
        random: &mut Random,
    ) -> Sample<f32> {
        match self {
            Fault::MotorLost => sample.motor = None,
            Fault::OutputLost => sample.output = None,
            Fault::Frozen => sample = Sample { drive: sample.drive, ..before },
            Fault::Swapped => (sample.motor, sample.output) = (sample.output, sample.motor),
            Fault::MotorJumps => {
                sample.motor = sample.motor.map(|turn| Turn(turn.0.wrapping_add(1 << 30)));
            }
            Fault::MotorNoise => sample.motor = Some(Turn(random.bits() as u32)),
            Fault::CurrentLost => sample.current = None,
            Fault::CurrentEnds => sample.current = Some(f32::MAX),
            Fault::DriveNone => sample.drive = f32::NAN,
            Fault::DriveHuge => sample.drive = f32::INFINITY,
            Fault::TimeJumps => {}
        }
        sample
    }

    /// The flag that tells it at once, where there is one; fixed point has no such number.
    fn told(self, has_none: bool) -> Status {
        match self {
            Fault::MotorLost => Status::COASTING,
            Fault::CurrentLost => Status::NO_CURRENT,
            Fault::CurrentEnds if has_none => Status::NO_CURRENT,
            Fault::DriveNone | Fault::DriveHuge if has_none => Status::NO_DRIVE,
            _ => Status::OK,
        }
    }
}

/// What the sensors of a joint show under random voltages and loads, and the fault of each second.
fn log(seed: u64) -> (Vec<Sample<f32>>, Vec<Fault>) {
    let mut random = Random(seed);
    let settings = Settings::new(Drive::Voltage, PERIOD_S);
    let joint = Joint::<f64, 2>::new(&motor(), &plain_gear(), &Load::default(), &settings).unwrap();
    let mut state = joint.rest();
    let counted = |turns: f64| {
        let turns = (turns * f64::from(COUNTS)).floor() / f64::from(COUNTS);
        Some(Turn::from_turns(turns.rem_euclid(1.0)))
    };
    let (mut samples, mut faults) = (Vec::new(), Vec::new());
    let (mut volts, mut load, mut before) = (0.0, 0.0, Sample::default());
    for _ in 0..SECONDS {
        let fault = Fault::ALL[random.below(Fault::ALL.len())];
        faults.push(fault);
        let end = BEGIN + 20 + random.below(LONGEST);
        for k in 0..RATE {
            if k % (RATE / 20) == 0 {
                (volts, load) = (VOLTS * random.signed(), LOAD_NM * random.signed());
            }
            let wound = joint.deflection(&state, 0) + joint.deflection(&state, 1);
            let output = state.angle.to_turns() - wound / std::f64::consts::TAU;
            let clean = Sample {
                drive: volts as f32,
                // A converter of 1 mA a step.
                current: Some(((joint.current(&state) * 1e3).round() * 1e-3) as f32),
                motor: counted(state.angle.to_turns()),
                output: counted(output / 1024.0),
            };
            let faulty = (BEGIN..end).contains(&k);
            samples.push(if faulty { fault.seen(clean, before, &mut random) } else { clean });
            if !(faulty && fault == Fault::Frozen) {
                before = clean;
            }
            let late = fault == Fault::TimeJumps && k == BEGIN;
            for _ in 0..=if late { random.below(300) } else { 0 } {
                joint.step(&mut state, joint.input(volts, load));
            }
        }
    }
    (samples, faults)
}

/// What the host makes of the samples: every number finite, the rotor bounded, every fault told that can be, and its
/// flags gone at the second's end.
fn observed<S: Real>(
    samples: impl Iterator<Item = Sample<S>>,
    faults: &[Fault],
    mut put: impl FnMut(&Observer<S, 2>, &Track<S, 2>),
) {
    let observer = observer::<S>();
    let mut track = observer.start(0);
    let flags = [Status::COASTING, Status::NO_CURRENT, Status::NO_DRIVE];
    let mut told = Status::OK;
    for (k, sample) in samples.enumerate() {
        let (fault, at) = (faults[k / RATE], k % RATE);
        let status = observer.update(&mut track, &sample);
        let e = observer.reading(&track);
        let motions =
            [e.motor_velocity, e.output_velocity, e.output_part, e.windup[0], e.windup[1]];
        let torques = [e.motor_friction, e.total_friction, e.load, e.spread.load];
        let mut all = motions.into_iter().chain(torques).map(Number::to_f64);
        let finite = all.all(f64::is_finite);
        let bounded = e.motor_velocity.to_f64().abs() < MOST_ROTOR;
        assert!(finite && bounded, "{fault:?}, update {k}: {e:?}, {status}");
        put(&observer, &track);
        told = match at {
            BEGIN => status,
            _ if (BEGIN..BEGIN + 20).contains(&at) => told.with(status),
            _ => told,
        };
        if at == RATE - 1 {
            let flag = fault.told(S::LARGEST.is_infinite());
            assert!(
                flag == Status::OK || told.has(flag),
                "{fault:?}, update {k}: only {told} told"
            );
            assert!(!flags.iter().any(|flag| status.has(*flag)), "{fault:?}: {status} at its end");
        }
    }
}

fn host(seed: u64) -> (Vec<u8>, Vec<u8>) {
    let (samples, faults) = log(seed);
    let records: Vec<u8> = samples.iter().flat_map(to_bytes).collect();
    let mut rows = Vec::new();
    observed(records.as_chunks().0.iter().map(from_bytes), &faults, |observer, track| {
        let put = |number: f32| {
            rows.extend(number.to_le_bytes());
            Ok::<(), std::convert::Infallible>(())
        };
        let Ok(()) = row(&observer.estimate(track), put);
    });
    (records, rows)
}

fn host_fixed(seed: u64) -> (Vec<u8>, Vec<u8>) {
    let (samples, faults) = log(seed);
    let fixed = |sample: &Sample<f32>| Sample {
        drive: Fixed::from_f64(sample.drive.into()),
        current: sample.current.map(|current| Fixed::from_f64(current.into())),
        motor: sample.motor,
        output: sample.output,
    };
    let records: Vec<u8> =
        samples.iter().flat_map(|sample| fixed_to_bytes(&fixed(sample))).collect();
    let mut rows = Vec::new();
    observed(records.as_chunks().0.iter().map(fixed_from_bytes), &faults, |observer, track| {
        fixed_row(&observer.reading(track), |bits| rows.extend(bits.to_le_bytes()));
    });
    (records, rows)
}

/// A folder with what a program reads there.
fn folder(name: &str, parameters: &[u8], records: &[u8]) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("parameters.bin"), parameters).unwrap();
    fs::write(folder.join("log.bin"), records).unwrap();
    folder
}

#[test]
fn ten_seconds_with_a_fault_in_each_are_finite_and_told() {
    let (records, rows) = host(1);
    let (fixed, _) = host_fixed(1);
    assert_eq!((records.len(), fixed.len()), (20 * SECONDS * RATE, 20 * SECONDS * RATE));
    assert!(rows.as_chunks().0.iter().all(|word| f32::from_le_bytes(*word).is_finite()));
}

#[test]
#[ignore = "minutes"]
fn a_minute_with_a_fault_in_every_second_gives_the_hosts_bits_on_the_chip() {
    let name = "a_minute_with_a_fault_in_every_second_gives_the_hosts_bits_on_the_chip";
    if !qemu::available(name) {
        return;
    }
    let files = ["parameters.bin", "log.bin", "estimates.bin"];
    let (mut block, mut fixed_block) = ([0; PAGE_BYTES], [0; PAGE_BYTES]);
    let length = encode(&observer::<f32>(), 2, &mut block).unwrap();
    let block = &block[..length];
    let length = encode(&observer::<Fixed>(), 2, &mut fixed_block).unwrap();
    let fixed_block = &fixed_block[..length];
    for seed in 1..=RUNS {
        let (records, rows) = host(seed);
        let place = folder("soak", block, &records);
        let run = qemu::run("observe", Board::NetduinoPlus2, &place, &files);
        assert_eq!(run.code, Some(0), "{run:?}");
        assert_eq!(run.value("samples"), (SECONDS * RATE).to_string());
        let chip = fs::read(place.join("estimates.bin")).unwrap();
        let first = chip.iter().zip(&rows).position(|(chip, host)| chip != host);
        assert_eq!(first.map(|byte| byte / (4 * row_numbers(2))), None, "row that differs first");
        assert_eq!(chip.len(), rows.len());

        let (records, rows) = host_fixed(seed);
        let place = folder("soak-fixed", fixed_block, &records);
        let run = qemu::run("observe_fixed", Board::NetduinoPlus2Soft, &place, &files[..2]);
        assert_eq!(run.code, Some(0), "{run:?}");
        assert_eq!(run.value("samples"), (SECONDS * RATE).to_string());
        assert_eq!(run.value("readings_crc32"), format!("{:08x}", CRC32.checksum(&rows)));
        println!("run {seed}: {} updates each in f32 and fixed point, equal", SECONDS * RATE);
    }
}
