//! What the step costs on a chip stays within `budgets.toml`.

use std::process::Command;

use joint_tests::qemu;

#[test]
fn no_row_is_past_its_budget() {
    if !qemu::available("no_row_is_past_its_budget") {
        return;
    }
    let output = Command::new(env!("CARGO_BIN_EXE_joint")).arg("budget").output().unwrap();
    let table = String::from_utf8_lossy(&output.stdout);
    println!("{table}");
    assert!(output.status.success(), "{table}{}", String::from_utf8_lossy(&output.stderr));
}
