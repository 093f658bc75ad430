//! The instruction counter counts instructions, and the same ones every time.

use std::path::Path;

use joint_tests::qemu::{self, Board};

#[test]
fn the_counter_is_exact_and_two_runs_agree() {
    if !qemu::available("the_counter_is_exact_and_two_runs_agree") {
        return;
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let run = || qemu::run("count", Board::NetduinoPlus2, folder, &[]);
    let (first, second) = (run(), run());
    assert_eq!(first.code, Some(0), "{first:?}");
    assert_eq!(first.value("hundred_nops"), "100");
    assert_eq!(first.stdout, second.stdout);
}
