//! Linker arguments of the boards; a host build takes none.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    // Not in a package, whose users have their own: what is not there would count as changed on every build.
    if std::path::Path::new("../memory.x").exists() {
        println!("cargo:rerun-if-changed=../memory.x");
    }
    for of in ["bins", "examples"] {
        println!("cargo:rustc-link-arg-{of}=--nmagic");
        println!("cargo:rustc-link-arg-{of}=-Tlink.x");
    }
    if std::env::var_os("CARGO_FEATURE_DRIVE").is_some() {
        println!("cargo:rustc-link-arg-bin=drive=-Tdefmt.x");
    }
    if std::env::var_os("CARGO_FEATURE_STM32G431").is_some() {
        println!("cargo:rustc-link-arg-bins=--defsym=_board_g431=1");
    }
    if std::env::var_os("CARGO_FEATURE_MPS2").is_some() {
        println!("cargo:rustc-link-arg-bins=--defsym=_board_mps2=1");
    }
}
