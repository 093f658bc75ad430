//! What the release firmware for the boards cannot do: panic, allocate, compute in double
//! precision, or outgrow its chip.

use std::path::PathBuf;
use std::process::Output;

use joint_tests::elf::Program;
use joint_tests::qemu::{self, Board};

/// A board's features, what its firmware may take of flash and RAM with every effect, and the RAM
/// that there is, all in KiB.
struct Budget {
    features: &'static str,
    flash: u64,
    ram: u64,
    all_ram: u64,
}

const fn budget(features: &'static str, flash: u64, ram: u64, all_ram: u64) -> Budget {
    Budget { features, flash, ram, all_ram }
}

/// The STM32G431 has 120 KiB beside the parameters and runs up to two stages, the F405 three. A table, a limit of the
/// current and gear losses take five of the KiB, two more what acts beside the limit, which was up to
/// 8 % off, and one friction of another shape.
const BUDGETS: [Budget; 4] = [
    budget("stm32g431", 118, 18, 32),
    budget("stm32g431,output", 119, 18, 32),
    budget("stm32f405", 164, 20, 64),
    budget("stm32f405,output", 164, 20, 64),
];
/// An interrupt on top of the start: its frame with the FPU's registers.
const INTERRUPT_FRAME: u64 = 104;

/// What the start and a control period of two stages may take of the stack, by `budgets.toml`.
fn stack_budgets() -> (u64, u64) {
    let text = std::fs::read_to_string(qemu::workspace().join("budgets.toml")).unwrap();
    let row = |name: &str| {
        let (_, rest) = text.split_once(&format!("[{name}]")).unwrap();
        let (_, value) = rest.split_once("budget =").unwrap();
        value.lines().next().unwrap().trim().parse::<u64>().unwrap()
    };
    (row("start_stack_bytes"), row("tick_stack_bytes"))
}

fn build(features: &str) -> (Output, PathBuf) {
    let target = qemu::target_folder().join("boards").join(features.replace(',', "-"));
    let drive = ["--package", "firmware", "--bin", "drive", "--no-default-features"];
    let output = qemu::cargo_build(qemu::TARGET, &[&drive[..], &["--features", features]].concat());
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
    let (start, tick) = stack_budgets();
    for Budget { features, flash: most_flash, ram: most_ram, all_ram } in BUDGETS {
        let (output, elf) = build(features);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{features}: {said}");
        let program = Program::read(&elf);
        let (flash, ram) = (program.flash_bytes, program.ram_bytes);
        println!("{features}: {flash} bytes of flash, {ram} of RAM besides the stack");
        assert!(program.soft_float().is_empty(), "{features}: {:?}", program.soft_float());
        assert!(program.allocator().is_empty(), "{features}: {:?}", program.allocator());
        assert!(flash <= most_flash * 1024, "{features}: {flash}");
        assert!(ram <= most_ram * 1024, "{features}: {ram}");
        let stack = start + INTERRUPT_FRAME + tick;
        assert!(ram + stack <= all_ram * 1024, "{features}: no room for the stack");
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
    let (most_start, most_tick) = stack_budgets();
    assert!(start <= most_start, "{start}");
    assert!(tick <= most_tick, "{tick}");
}
