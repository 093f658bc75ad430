//! The fixed-point step on a chip without a floating-point unit: the host's to the bit, and without a
//! float. What it costs stands in `budgets.toml`.

use std::fs;
use std::path::Path;

use firmware::{block, drill};
use joint_core::fixed::Fixed;
use joint_core::joint::{Drive, Joint, Settings};
use joint_core::params::Load;
use joint_tests::drive::{motor, plain_gear};
use joint_tests::qemu::{self, Board};

fn joint() -> Joint<Fixed, 2> {
    let mut settings = Settings::new(Drive::Voltage, 50e-6);
    settings.micro_steps = Some(1);
    Joint::<Fixed, 2>::new(&motor(), &plain_gear(), &Load::default(), &settings).unwrap()
}

#[test]
fn a_chip_without_floats_steps_as_the_host_does_whatever_the_data() {
    if !qemu::available("a_chip_without_floats_steps_as_the_host_does_whatever_the_data") {
        return;
    }
    let joint = joint();
    let mut bytes = [0; 4096];
    let length = block::encode(&joint, 2, &mut bytes).unwrap();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fixed");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("joint.bin"), &bytes[..length]).unwrap();
    let run = qemu::run("count_fixed", Board::NetduinoPlus2Soft, &folder, &["joint.bin"]);
    assert_eq!(run.code, Some(0), "{run:?}");
    print!("{}", run.stdout);
    assert_eq!(run.value("saturated"), "0");

    let mut state = joint.rest();
    for k in 0..drill::STEPS {
        let (volts, load) = drill::input(k);
        joint.step(&mut state, joint.input(volts, load));
    }
    assert_eq!(run.value("current"), state.current.to_bits().to_string());
    assert_eq!(run.value("turns"), state.angle.whole.to_string());
    assert_eq!(run.value("speed"), state.rotor.speed.to_bits().to_string());
    assert_eq!(run.value("deflection"), state.stages[0].deflection.to_bits().to_string());
}

#[test]
fn the_program_without_floats_holds_no_floating_point_routine() {
    if !qemu::available("the_program_without_floats_holds_no_floating_point_routine") {
        return;
    }
    for program in ["count_fixed", "observe_fixed"] {
        let elf = fs::read(qemu::firmware(program, Board::NetduinoPlus2Soft)).unwrap();
        without_floats(program, &symbols(&elf));
    }
}

fn without_floats(program: &str, symbols: &[String]) {
    assert!(symbols.iter().any(|name| name.contains("micro_step")), "no symbol table");
    let kinds = ["add", "sub", "mul", "div", "cmplt", "cmpgt", "2iz", "2uiz", "2d", "2f"];
    let routines =
        kinds.iter().flat_map(|kind| ["f", "d"].map(|float| format!("__aeabi_{float}{kind}")));
    let conversions = ["i2f", "ui2f", "l2f", "i2d", "ui2d", "l2d"].map(|k| format!("__aeabi_{k}"));
    for name in routines.chain(conversions) {
        assert!(!symbols.contains(&name), "{name} in {program}");
    }
}

/// Names in the symbol table of a 32-bit ELF file.
fn symbols(elf: &[u8]) -> Vec<String> {
    let half = |at: usize| usize::from(u16::from_le_bytes(elf[at..at + 2].try_into().unwrap()));
    let word = |at: usize| u32::from_le_bytes(elf[at..at + 4].try_into().unwrap()) as usize;
    let (start, size, number) = (word(0x20), half(0x2e), half(0x30));
    let section = |k: usize| start + k * size;
    let table = (0..number).map(section).find(|at| word(at + 4) == 2).expect("a symbol table");
    let names = word(section(word(table + 24)) + 16);
    let entries = (0..word(table + 20) / 16).map(|k| word(table + 16) + 16 * k);
    entries
        .map(|entry| {
            let name = &elf[names + word(entry)..];
            let end = name.iter().position(|byte| *byte == 0).unwrap();
            String::from_utf8_lossy(&name[..end]).into_owned()
        })
        .collect()
}
