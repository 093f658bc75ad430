//! Says where this is built: the shared library of an FMU is built there too, and a `joint` that was
//! copied or installed finds it.

use std::path::Path;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    // OUT_DIR is target/PROFILE/build/PACKAGE/out.
    let out = std::env::var("OUT_DIR").unwrap_or_default();
    let built = Path::new(&out).ancestors().nth(3).unwrap_or(Path::new(""));
    println!("cargo:rustc-env=JOINT_BUILT_IN={}", built.display());
}
