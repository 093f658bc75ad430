//! What the chip computes is what the host computes, to the bit.

use std::fs;
use std::path::PathBuf;

use firmware::block;
use firmware::replay::{ReplayedJoint, row_numbers, steps};
use firmware::samples::Sample;
use joint_core::effect::{EffectParameters, Kind};
use joint_core::joint::{Drive, Settings};
use joint_core::params::{Load, Location};
use joint_tests::drive::{gear, motor};
use joint_tests::qemu::{self, Board, Run};

/// Not a multiple of the replay's block, so the torn last block is met too.
const SAMPLES: usize = 5_003;

/// Held voltages (or currents) of both signs with stretches of zero in between, and a load that comes and goes:
/// reversals, stick and denormals.
fn inputs() -> Vec<Sample> {
    (0..SAMPLES)
        .map(|k| Sample {
            input: [3.0, -4.5, 0.0, 0.37, -0.02, 6.0][k / 211 % 6],
            load: if k / 1_009 % 2 == 1 { 0.004 } else { 0.0 },
        })
        .collect()
}

fn bytes_on_host<const N: usize>(joint: &ReplayedJoint<N>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut state = joint.rest();
    let put = |number: f32| {
        bytes.extend(number.to_le_bytes());
        Ok::<(), std::convert::Infallible>(())
    };
    let Ok(()) = steps(joint, &mut state, inputs().into_iter(), put);
    bytes
}

fn scratch(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn replay(board: Board, name: &str, parameters: &[u8]) -> (Run, Vec<u8>) {
    let folder = scratch(&format!("{name}-{}", board.machine()));
    fs::write(folder.join("parameters.bin"), parameters).unwrap();
    let log: Vec<u8> = inputs().into_iter().flat_map(Sample::to_bytes).collect();
    fs::write(folder.join("log.bin"), log).unwrap();
    let files = ["parameters.bin", "log.bin", "states.bin"];
    let run = qemu::run("replay", board, &folder, &files);
    (run, fs::read(folder.join("states.bin")).unwrap_or_default())
}

fn encoded<const N: usize>(joint: &ReplayedJoint<N>) -> Vec<u8> {
    let mut bytes = vec![0; 2048];
    let length = block::encode(joint, N as u8, &mut bytes).unwrap();
    bytes.truncate(length);
    bytes
}

fn assert_same_bits<const N: usize>(name: &str, joint: &ReplayedJoint<N>) {
    if !qemu::available(name) {
        return;
    }
    let host = bytes_on_host(joint);
    assert_eq!(host.len(), SAMPLES * row_numbers(N) * 4);
    assert!(host.as_chunks::<4>().0.iter().all(|&word| f32::from_le_bytes(word).is_finite()));
    for board in Board::ALL {
        let (run, chip) = replay(board, name, &encoded(joint));
        assert_eq!(run.code, Some(0), "{run:?}");
        assert_eq!(run.value("samples"), SAMPLES.to_string());
        let words = host.as_chunks::<4>().0.iter().zip(chip.as_chunks::<4>().0);
        if let Some(first) = words.clone().position(|(host, chip)| host != chip) {
            let (row, column) = (first / row_numbers(N), first % row_numbers(N));
            panic!("{}: state {column} differs first at sample {row}", board.machine());
        }
        assert_eq!(chip.len(), host.len());
    }
}

#[test]
fn a_two_stage_joint_gives_the_same_bits_on_every_board() {
    let settings = Settings::new(Drive::Voltage, 50e-6);
    let joint = ReplayedJoint::<2>::new(&motor(), &gear(), &Load::default(), &settings).unwrap();
    assert_same_bits("a_two_stage_joint_gives_the_same_bits_on_every_board", &joint);
}

#[test]
fn every_effect_acts_and_gives_the_same_bits_on_every_board() {
    for &kind in Kind::ALL {
        let effect = EffectParameters::example(kind);
        let drive = match effect.location {
            // What an encoder shows wrong does not move the joint.
            Location::Encoder | Location::OutputEncoder => continue,
            Location::CurrentSensor => Drive::Current,
            _ => Drive::Voltage,
        };
        let joint = |effects: &[EffectParameters]| {
            let settings = Settings { effects, ..Settings::new(drive, 50e-6) };
            ReplayedJoint::<2>::new(&motor(), &gear(), &Load::default(), &settings).unwrap()
        };
        let (plain, joint) = (joint(&[]), joint(&[effect]));
        let name = kind.spec().kind;
        assert!(bytes_on_host(&joint) != bytes_on_host(&plain), "{name} does nothing here");
        assert_same_bits(name, &joint);
    }
}

#[test]
fn a_direct_drive_with_an_imposed_current_gives_the_same_bits_on_every_board() {
    let settings = Settings::new(Drive::Current, 100e-6);
    let mut motor = motor();
    motor.rotor_inertia_kg_m2 = 1e-6;
    let joint = ReplayedJoint::<0>::new(&motor, &[], &Load::default(), &settings).unwrap();
    assert_same_bits("a_direct_drive_gives_the_same_bits_on_every_board", &joint);
}

#[test]
fn a_damaged_block_is_refused_by_name() {
    let name = "a_damaged_block_is_refused_by_name";
    if !qemu::available(name) {
        return;
    }
    let settings = Settings::new(Drive::Voltage, 50e-6);
    let joint = ReplayedJoint::<2>::new(&motor(), &gear(), &Load::default(), &settings).unwrap();
    let mut bytes = encoded(&joint);
    bytes[40] ^= 1;
    let (run, _) = replay(Board::NetduinoPlus2, name, &bytes);
    assert_eq!(run.code, Some(1), "{run:?}");
    assert!(run.stderr.contains("parameter block damaged"), "{run:?}");
}
