//! What the observer computes on the chip is what it computes on the host, and what it costs there.

use std::fs;
use std::path::PathBuf;

use firmware::block;
use firmware::observing::{
    fixed_from_bytes, fixed_row, fixed_to_bytes, from_bytes, row, row_numbers, to_bytes,
};
use host_harness::observe::counted::{SAMPLES, log, observer, sample};
use joint_core::fixed::Fixed;
use joint_core::telemetry::frame::CRC32;
use joint_tests::qemu::{self, Board};

#[test]
fn the_observer_gives_the_same_bits_on_every_board() {
    if !qemu::available("the_observer_gives_the_same_bits_on_every_board") {
        return;
    }
    let observer = observer::<f32>().unwrap();
    let records: Vec<u8> = log().unwrap().iter().flat_map(|seen| to_bytes(&sample(seen))).collect();
    let mut track = observer.start(0);
    let mut host: Vec<u8> = Vec::new();
    for record in records.as_chunks().0 {
        observer.update(&mut track, &from_bytes(record));
        let put = |number: f32| {
            host.extend(number.to_le_bytes());
            Ok::<(), std::convert::Infallible>(())
        };
        let Ok(()) = row(&observer.estimate(&track), put);
    }
    assert_eq!(host.len(), SAMPLES * row_numbers(2) * 4);
    assert!(host.as_chunks::<4>().0.iter().all(|&word| f32::from_le_bytes(word).is_finite()));

    let mut bytes = vec![0; 6144];
    let length = block::encode(&observer, 2, &mut bytes).unwrap();
    println!("block_bytes={length}");
    for board in Board::ALL {
        let name = format!("observer-{}", board.machine());
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("parameters.bin"), &bytes[..length]).unwrap();
        fs::write(folder.join("log.bin"), &records).unwrap();
        let files = ["parameters.bin", "log.bin", "estimates.bin"];
        let run = qemu::run("observe", board, &folder, &files);
        assert_eq!(run.code, Some(0), "{run:?}");
        assert_eq!(run.value("samples"), SAMPLES.to_string());
        let chip = fs::read(folder.join("estimates.bin")).unwrap();
        let words = host.as_chunks::<4>().0.iter().zip(chip.as_chunks::<4>().0);
        if let Some(first) = words.clone().position(|(host, chip)| host != chip) {
            let (row, column) = (first / row_numbers(2), first % row_numbers(2));
            panic!("{}: estimate {column} differs first at sample {row}", board.machine());
        }
        assert_eq!(chip.len(), host.len());
        if board == Board::NetduinoPlus2 {
            print!("{}", run.stdout);
        }
    }
}

#[test]
fn a_chip_without_floats_observes_as_the_host_does() {
    if !qemu::available("a_chip_without_floats_observes_as_the_host_does") {
        return;
    }
    let observer = observer::<Fixed>().unwrap();
    let seen = log().unwrap();
    let records: Vec<u8> = seen.iter().flat_map(|seen| fixed_to_bytes(&sample(seen))).collect();
    let mut track = observer.start(0);
    let mut host: Vec<u8> = Vec::new();
    for record in records.as_chunks().0 {
        observer.update(&mut track, &fixed_from_bytes(record));
        fixed_row(&observer.reading(&track), |bits| host.extend(bits.to_le_bytes()));
    }
    let mut bytes = vec![0; 8192];
    let length = block::encode(&observer, 2, &mut bytes).unwrap();
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("observer-fixed");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("parameters.bin"), &bytes[..length]).unwrap();
    fs::write(folder.join("log.bin"), &records).unwrap();
    let files = ["parameters.bin", "log.bin"];
    let run = qemu::run("observe_fixed", Board::NetduinoPlus2Soft, &folder, &files);
    assert_eq!(run.code, Some(0), "{run:?}");
    print!("{}", run.stdout);
    assert_eq!(run.value("samples"), SAMPLES.to_string());
    assert_eq!(run.value("readings_crc32"), format!("{:08x}", CRC32.checksum(&host)));
}
