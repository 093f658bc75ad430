//! The command `joint`.
fn main() {}
