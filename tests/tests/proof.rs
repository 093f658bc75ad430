//! What the release firmware for the boards cannot do: panic, allocate, compute in double
//! precision, or outgrow its chip.

use std::path::PathBuf;
use std::process::{Command, Output};

use firmware::block::PAGE_BYTES;
use joint_tests::elf::Program;
use joint_tests::qemu::{self, Board};

/// Flash of the smaller chip, but for the pages of the parameters.
const FLASH: u64 = 128 * 1024 - PAGE_BYTES as u64;
/// Its RAM.
const RAM: u64 = 32 * 1024;
/// What the firmware may take of both, with every effect and up to three stages.
const FLASH_BUDGET: u64 = 104 * 1024;
const RAM_BUDGET: u64 = 23 * 1024;
/// What the start and a control period may take of the stack.
const START_STACK_BUDGET: u64 = 9 * 1024;
const TICK_STACK_BUDGET: u64 = 1024;

fn build(features: &str) -> (Output, PathBuf) {
    let target = qemu::target_folder().join("boards").join(features.replace(',', "-"));
    let output = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()))
        .current_dir(qemu::workspace())
        .args(["build", "--release", "--package", "firmware", "--bin", "drive"])
        .args(["--no-default-features", "--features", features])
        .args(["--target", qemu::TARGET, "--target-dir"])
        .arg(qemu::target_folder())
        .output()
        .unwrap();
    let built = qemu::target_folder().join(qemu::TARGET).join("release/drive");
    if output.status.success() {
        std::fs::create_dir_all(&target).unwrap();
        std::fs::copy(built, target.join("drive")).unwrap();
    }
    (output, target.join("drive"))
}

/// One test, since all of them build into one place.
#[test]
fn firmware_links_only_without_a_panic_and_has_no_heap_no_soft_float_and_room_to_spare() {
    for features in ["stm32g431", "stm32g431,output", "stm32f405", "stm32f405,output"] {
        let (output, elf) = build(features);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{features}: {said}");
        let program = Program::read(&elf);
        let (flash, ram) = (program.flash_bytes, program.ram_bytes);
        println!("{features}: {flash} bytes of flash, {ram} of RAM besides the stack");
        assert!(program.soft_float().is_empty(), "{features}: {:?}", program.soft_float());
        assert!(program.allocator().is_empty(), "{features}: {:?}", program.allocator());
        assert!(flash <= FLASH_BUDGET && FLASH_BUDGET <= FLASH, "{features}: {flash}");
        assert!(ram <= RAM_BUDGET, "{features}: {ram}");
        assert!(ram + START_STACK_BUDGET <= RAM, "{features}: no room for the stack");
    }
    let (output, _) = build("stm32g431,planted-panic");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success(), "a planted panic links");
    assert!(said.contains("undefined symbol: a_panic_can_be_reached"), "{said}");
}

#[test]
fn the_stack_of_start_and_control_period_stays_within_its_budget() {
    if !qemu::available("the_stack_of_start_and_control_period_stays_within_its_budget") {
        return;
    }
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("stack");
    std::fs::create_dir_all(&folder).unwrap();
    for name in ["samples.bin", "commands.bin"] {
        std::fs::write(folder.join(name), []).unwrap();
    }
    let page = folder.join("page.bin");
    let block = joint_tests::drive::block(&joint_tests::drive::parameters());
    std::fs::write(&page, block).unwrap();
    let board = Board::NetduinoPlus2;
    let files = ["samples.bin", "commands.bin", "frames.bin"];
    let run = qemu::run_elf(&qemu::firmware("hil", board), board, &folder, &files, Some(&page));
    let bytes = |key: &str| run.value(key).parse::<u64>().unwrap();
    let (start, tick) = (bytes("start_stack_bytes"), bytes("tick_stack_bytes"));
    println!("stack: {start} bytes at the start, {tick} for a control period of two stages");
    assert!(start <= START_STACK_BUDGET, "{start}");
    assert!(tick <= TICK_STACK_BUDGET, "{tick}");
}
