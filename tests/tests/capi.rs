//! The C library: its header is the one that its source gives, and a C program that links it computes
//! what Rust computes, bit for bit.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use firmware::any_control::AnyControl;
use firmware::block::Block;
use joint_core::telemetry::{Report, Sample, Status};
use joint_tests::drive::{block, parameters, plant};
use joint_tests::qemu::{self, Board};

const SAMPLES: usize = 3_001;

fn capi() -> PathBuf {
    qemu::workspace().join("firmware/capi")
}

#[test]
fn the_header_is_current() {
    let config = cbindgen::Config::from_file(capi().join("cbindgen.toml")).unwrap();
    let source = capi().join("src/lib.rs");
    let bindings =
        cbindgen::Builder::new().with_config(config).with_src(source).generate().unwrap();
    let fresh = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("joint.h");
    bindings.write_to_file(&fresh);
    let (stored, fresh) =
        (fs::read_to_string(capi().join("joint.h")).unwrap(), fs::read_to_string(&fresh).unwrap());
    assert!(
        stored == fresh,
        "firmware/capi/joint.h is not what its source gives: copy target/tmp/joint.h over it"
    );
}

/// Builds the example in C.
fn program(folder: &Path) -> PathBuf {
    qemu::built(&qemu::cargo_build(qemu::TARGET, &["--package", "joint-capi"]));
    let (example, elf) = (capi().join("example"), folder.join("example"));
    let output = Command::new("arm-none-eabi-gcc")
        .args(["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"])
        .args(["-std=c11", "-O2", "-Wall", "-Wextra", "-Werror", "-Wl,--gc-sections"])
        .args(["--specs=rdimon.specs", "-T"])
        .arg(example.join("mps2.ld"))
        .args([example.join("main.c"), example.join("startup.c")])
        .arg(qemu::target_folder().join(qemu::TARGET).join("release/libjoint.a"))
        .arg("-o")
        .arg(&elf)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    elf
}

/// An estimate as the C program writes its struct.
fn bytes(report: &Report) -> Vec<u8> {
    let mut bytes = report.tick.to_le_bytes().to_vec();
    bytes.extend([report.status.0, report.health].map(u16::to_le_bytes).concat());
    for own in [&report.estimates, &report.deviations] {
        let numbers = [
            own.motor_velocity_rad_per_s,
            own.total_friction_at_motor_nm,
            own.output_angle_rad,
            own.output_velocity_rad_per_s,
            own.load_torque_nm,
        ];
        bytes.extend(numbers.iter().chain(&own.windup_rad).flat_map(|number| number.to_le_bytes()));
    }
    bytes
}

#[test]
fn a_c_program_estimates_what_rust_estimates_to_the_bit() {
    let name = "a_c_program_estimates_what_rust_estimates_to_the_bit";
    if !qemu::available(name) || !qemu::c_compiler(name) {
        return;
    }
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).unwrap();
    let (page, samples) = (block(&parameters()), plant(SAMPLES));
    fs::write(folder.join("parameters.bin"), &page).unwrap();
    let log: Vec<u8> = samples.iter().flat_map(|sample| Sample::to_bytes(*sample)).collect();
    fs::write(folder.join("samples.bin"), log).unwrap();
    let elf = program(&folder);
    let run = qemu::run_elf(&elf, Board::Mps2An386, &folder, &[], None);
    assert_eq!(run.code, Some(0), "{run:?}");
    assert_eq!(run.value("samples"), SAMPLES.to_string());

    let mut control = AnyControl::NotStarted;
    control.read(&Block::check(&page).unwrap(), Status::default()).unwrap();
    let chip = fs::read(folder.join("estimates.bin")).unwrap();
    let host: Vec<Vec<u8>> =
        samples.iter().map(|sample| bytes(&control.tick(*sample, 0))).collect();
    assert_eq!(chip.len(), host.len() * host[0].len());
    for (k, (host, chip)) in host.iter().zip(chip.chunks(host[0].len())).enumerate() {
        assert_eq!(host, chip, "sample {k}");
    }
    println!(
        "{SAMPLES} estimates, {} bytes, equal; a joint_t is {} bytes",
        chip.len(),
        run.value("joint_bytes")
    );

    let mut damaged = page;
    damaged[50] ^= 4;
    fs::write(folder.join("parameters.bin"), damaged).unwrap();
    let run = qemu::run_elf(&elf, Board::Mps2An386, &folder, &[], None);
    assert!(run.stdout.contains("joint_init: 5"), "{run:?}");
}
