//! Boards at a debug probe, by probe-rs's fake probe: attached to the chip and read, never written.

#![cfg(feature = "probe")]

use std::path::{Path, PathBuf};
use std::process::Command;

use host_harness::probe::board::Board;
use host_harness::probe::{Chip, Recording, Wire};
use joint_tests::drive::{block, parameters, plant, run};
use probe_rs::integration::FakeProbe;

/// An ELF file for Arm whose segments hold these bytes at these addresses.
fn elf(path: &Path, segments: &[(u32, &[u8])]) {
    let (head, entry) = (52, 32);
    let mut bytes = b"\x7fELF\x01\x01\x01\0\0\0\0\0\0\0\0\0".to_vec();
    let half = |bytes: &mut Vec<u8>, value: u16| bytes.extend(value.to_le_bytes());
    let word = |bytes: &mut Vec<u8>, value: u32| bytes.extend(value.to_le_bytes());
    let data = head + entry * segments.len();
    let all: usize = segments.iter().map(|(_, own)| own.len()).sum();
    // The section names stand behind the data: one empty name, and one of all sections.
    let (names, sections) = (data + all, data + all + 4);
    half(&mut bytes, 2);
    half(&mut bytes, 40);
    for value in [1, segments[0].0 | 1, head as u32, sections as u32, 0x0500_0400] {
        word(&mut bytes, value);
    }
    for value in [52, 32, segments.len() as u16, 40, segments.len() as u16 + 2] {
        half(&mut bytes, value);
    }
    half(&mut bytes, segments.len() as u16 + 1);
    let mut at = data;
    for (address, own) in segments {
        let size = own.len() as u32;
        for value in [1, at as u32, *address, *address, size, size, 5, 4] {
            word(&mut bytes, value);
        }
        at += own.len();
    }
    segments.iter().for_each(|(_, own)| bytes.extend(*own));
    bytes.extend(b"\0.x\0");
    bytes.extend([0; 40]);
    let mut at = data;
    for (address, own) in segments {
        for value in [1, 1, 2, *address, at as u32, own.len() as u32, 0, 0, 4, 0] {
            word(&mut bytes, value);
        }
        at += own.len();
    }
    for value in [1, 3, 0, 0, names as u32, 4, 0, 0, 1, 0] {
        word(&mut bytes, value);
    }
    std::fs::write(path, bytes).unwrap();
}

fn fake(chip: Chip) -> Board {
    Board::attach(FakeProbe::with_mocked_core().into_probe(), chip).unwrap()
}

fn block_file(folder: &Path) -> (PathBuf, Vec<u8>) {
    let bytes = block(&parameters());
    let path = folder.join("joint.block");
    std::fs::write(&path, &bytes).unwrap();
    (path, bytes)
}

#[test]
fn parameters_alone_touch_nothing_but_their_page() {
    let own = block(&parameters());
    for (chip, page) in [(Chip::Stm32g431, 0x0801_e000), (Chip::Stm32f405, 0x0804_0000)] {
        let mut board = fake(chip);
        assert_eq!(board.plan(None, Some(&own)).unwrap(), [(page, own.clone())]);
        board.program(None, Some(&own), true).unwrap();
    }
}

#[test]
fn a_program_goes_where_it_is_linked_and_its_parameters_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let (own, program) = (block(&parameters()), folder.path().join("drive"));
    let code = [0x5a; 4096];
    elf(&program, &[(0x0800_0000, &code)]);
    let mut board = fake(Chip::Stm32f405);
    let plan = board.plan(Some(&program), Some(&own)).unwrap();
    assert_eq!(plan, [(0x0800_0000, code.to_vec()), (0x0804_0000, own.clone())]);
    board.program(Some(&program), Some(&own), true).unwrap();
}

#[test]
fn a_program_of_another_chip_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("drive");
    // Room on the F405, and the parameter page of the G431.
    elf(&program, &[(0x0800_0000, &[1; 4096]), (0x0801_e000, &[2; 64])]);
    let error = fake(Chip::Stm32g431).plan(Some(&program), None).unwrap_err();
    assert!(error.contains("parameter page"), "{error}");
    assert!(fake(Chip::Stm32f405).plan(Some(&program), None).is_ok());
    // No flash at all.
    elf(&program, &[(0x0900_0000, &[1; 64])]);
    assert!(fake(Chip::Stm32f405).program(Some(&program), None, true).is_err());
    std::fs::write(&program, "no program").unwrap();
    assert!(fake(Chip::Stm32f405).program(Some(&program), None, true).is_err());
}

/// RAM of a drive that has sent frames and waits for them to be fetched.
fn ram(frames: &[u8]) -> Vec<u8> {
    const START: u32 = 0x2000_0000;
    let (names, rings) = (START + 128, START + 160);
    let mut ram = b"SEGGER RTT\0\0\0\0\0\0".to_vec();
    let channels: [[u32; 6]; 4] = [
        [names, rings, 16, 0, 0, 0],
        [names + 6, rings + 48, frames.len() as u32 + 1, frames.len() as u32, 0, 0],
        [names, rings + 16, 16, 0, 0, 0],
        [names + 6, rings + 32, 16, 0, 0, 0],
    ];
    for word in [2, 2].into_iter().chain(channels.into_iter().flatten()) {
        ram.extend(word.to_le_bytes());
    }
    ram.resize(128, 0);
    ram.extend(b"defmt\0telemetry\0");
    ram.resize(160 + 48, 0);
    ram.extend(frames);
    ram.resize(ram.len().next_multiple_of(4) + 64, 0);
    ram
}

#[test]
fn what_a_drive_has_sent_is_read_from_its_second_channel() {
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("drive");
    let frames = run(&block(&parameters()), &plant(200), &[]);
    elf(&program, &[(0x2000_0000, &ram(&frames))]);
    let probe = FakeProbe::with_mocked_core_and_binary(&program).into_probe();
    let mut live = Board::attach(probe, Chip::Stm32g431).unwrap().live().unwrap();
    let mut buffer = vec![0; frames.len() + 64];
    let count = live.receive(&mut buffer).unwrap().unwrap();
    assert!(buffer[..count] == frames, "{count} of {} bytes", frames.len());
    let mut recording = Recording::default();
    recording.take(&buffer[..count]);
    assert_eq!((recording.reports.len(), recording.lost), (10, 0));
}

#[test]
fn a_board_without_a_running_drive_is_told_from_one_that_is_silent() {
    let error = fake(Chip::Stm32g431).live().unwrap_err();
    assert!(error.contains("is `drive` running?"), "{error}");
}

/// The verb itself, where no probe is connected.
#[test]
fn the_verb_checks_the_block_before_it_looks_for_a_probe() {
    let folder = tempfile::tempdir().unwrap();
    let (path, mut bytes) = block_file(folder.path());
    let flash = |path: &Path| {
        let output = Command::new(env!("CARGO_BIN_EXE_joint"))
            .args(["flash", "--chip", "stm32g431", "--params-only", "--dry-run", "--block"])
            .arg(path)
            .env("PROBE_RS_PROBE", "dead:beef:none")
            .output()
            .unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, said) = flash(&path);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("STM32G431CBUx"), "{said}");
    bytes[20] ^= 1;
    std::fs::write(&path, &bytes).unwrap();
    let (code, said) = flash(&path);
    assert_eq!(code, Some(2));
    assert!(said.contains("damaged") && said.contains("joint export"), "{said}");
}
