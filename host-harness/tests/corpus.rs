//! The entries for bytes from anywhere, over the fuzzers' corpora and what becomes of them: a short run of
//! `cargo fuzz` without its toolchain. A panic is a failure, and so is a promise of `tests/fuzz` that does not
//! hold.

#[path = "../../tests/fuzz/drive.rs"]
mod drive;
#[path = "../../tests/fuzz/entry.rs"]
mod entry;

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use host_harness::export::{self, DriveOptions};
use host_harness::observe::counted;
use joint_core::joint::Drive;
use joint_core::telemetry::frame::Reader;

/// SplitMix64 (G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014).
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % end.max(1) as u64) as usize
    }
}

/// What a number, a key or a separator is exchanged for.
const PIECES: [&str; 24] = [
    "0",
    "-1",
    "1e300",
    "-1e-300",
    "1e999",
    "nan",
    "inf",
    "-inf",
    "9223372036854775808",
    "0x7fffffff",
    "\"",
    "'",
    "[",
    "]]",
    "=",
    ",",
    ";",
    "\t",
    "\n",
    "\r\n",
    "\u{feff}",
    "ä",
    "[[effect]]\n",
    "\0",
];

fn mutated(seeds: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut bytes = seeds[random.below(seeds.len())].clone();
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len() + 1);
        let end = at + random.below((bytes.len() - at).min(40) + 1);
        match random.below(6) {
            0 => drop(bytes.drain(at..end)),
            1 => bytes.truncate(at),
            2 => {
                if let Some(byte) = bytes.get_mut(at) {
                    *byte ^= 1 << random.below(8);
                }
            }
            3 => {
                let piece = PIECES[random.below(PIECES.len())].bytes();
                bytes.splice(at..(at + random.below(8)).min(bytes.len()), piece).for_each(drop);
            }
            4 => {
                let other = &seeds[random.below(seeds.len())];
                let from = random.below(other.len() + 1);
                bytes.splice(at..end, other[from..].iter().take(60).copied()).for_each(drop);
            }
            _ => {
                let again: Vec<u8> = bytes[at..end].to_vec();
                bytes.splice(at..at, again).for_each(drop);
            }
        }
    }
    bytes
}

fn seeds(target: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fuzz/corpus").join(target);
    let files = fs::read_dir(&folder).into_iter().flatten();
    let mut paths: Vec<_> = files.map(|file| file.unwrap().path()).collect();
    paths.sort();
    let mut seeds: Vec<Vec<u8>> = paths.iter().map(|path| fs::read(path).unwrap()).collect();
    if target == "block" {
        seeds.push(block());
    }
    assert!(!seeds.is_empty(), "{}: no seeds", folder.display());
    seeds
}

/// The assumed joint's observer, as the drive reads it.
fn block() -> Vec<u8> {
    let options = DriveOptions {
        period_s: counted::STEP_S,
        drive: Drive::Voltage,
        bus_v: 6.0,
        current_limit_a: 1.0,
    };
    export::block::block(&counted::model(counted::STEP_S), &options).unwrap()
}

/// One input may take so long; more is a hang.
const MOST: Duration = Duration::from_secs(60);

fn run(target: &str, entry: fn(&[u8]), seed: u64, mutations: u32) {
    let seeds = seeds(target);
    let met = |bytes: &[u8], which: &str| {
        let begun = Instant::now();
        let result = std::panic::catch_unwind(|| entry(bytes));
        let text = String::from_utf8_lossy(bytes);
        assert!(result.is_ok(), "{target}, {which}: a panic, of {text:?}");
        assert!(begun.elapsed() < MOST, "{target}, {which}: {:?}, of {text:?}", begun.elapsed());
    };
    for (k, bytes) in seeds.iter().enumerate() {
        met(bytes, &format!("seed {k}"));
    }
    let mut random = Random(seed);
    for k in 0..mutations {
        met(&mutated(&seeds, &mut random), &format!("mutation {k} of {seed}"));
    }
}

fn run_all(seed: u64, times: u32) {
    let entries: [(&str, Entry, u32); 8] = [
        ("model", entry::model, 20_000),
        ("log", entry::log, 40_000),
        ("import_map", entry::import_map, 20_000),
        ("recording", entry::recording, 10_000),
        ("block", drive::block, 5_000),
        ("frames", drive::frames, 40_000),
        ("capi", drive::capi, 1_000),
        ("fmu", drive::fmu, 4_000),
    ];
    for (target, entry, mutations) in entries {
        let begun = Instant::now();
        run(target, entry, seed, times * mutations);
        println!("{target}: {} mutations in {:?}", times * mutations, begun.elapsed());
    }
}

/// What takes bytes from anywhere.
type Entry = fn(&[u8]);

#[test]
fn no_file_block_frame_or_call_is_met_by_a_panic() {
    run_all(1, 1);
}

#[test]
#[ignore = "ten minutes"]
fn nor_are_a_hundred_times_as_many() {
    run_all(2, 100);
}

/// What `frame::encode` made of one message of each kind, so that a fuzzer begins behind the checksums.
#[test]
fn the_seed_of_frames_has_every_kind_of_message_and_command() {
    let mut reader = Reader::default();
    let seed = &seeds("frames")[0];
    let found: Vec<_> = seed.iter().filter_map(|byte| reader.push(*byte)).collect();
    let found = format!("{found:?}");
    for kind in ["Hello(", "Report(", "CaptureHead(", "Samples(", "Dropped(", "Command("] {
        assert!(found.contains(&format!("message: {kind}")), "{kind}");
    }
    for command in ["Hello", "Rate", "Arm", "Fetch", "Disarm", "Duty"] {
        assert!(found.contains(&format!("Command({command}")), "{command}");
    }
    assert_eq!(reader.skipped, 0);
}

/// An entry with one defect is found out.
#[test]
#[should_panic(expected = "a panic, of")]
fn a_defect_is_found() {
    fn crooked(bytes: &[u8]) {
        assert!(!bytes.windows(7).any(|it| it == b"= 1e999"));
    }
    run("model", crooked, 1, 100_000);
}
