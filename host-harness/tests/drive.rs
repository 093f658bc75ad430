//! From a model to a drive and back: blocks that the firmware accepts, and logs of what it sent.

use std::io::{Read, Write};
use std::net::TcpListener;
use std::path::Path;
use std::process::{Command, Output};

use host_harness::log::{Log, Need};
use joint_core::telemetry::frame::Reader;
use joint_core::telemetry::{self, Message, Trigger};
use joint_tests::drive::{block, parameters, plant, run};

fn joint(folder: &Path, arguments: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_joint"))
        .args(arguments.split_whitespace())
        .current_dir(folder)
        .output()
        .unwrap()
}

fn done(output: &Output) {
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}

fn firmware_folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../firmware")
}

#[test]
fn the_default_block_is_what_its_model_gives_and_the_firmware_accepts_it() {
    let folder = tempfile::tempdir().unwrap();
    let model = firmware_folder().join("default.toml");
    let arguments =
        format!("export --model {} --format block --out d.block --bus-v 80", model.display());
    done(&joint(folder.path(), &arguments));
    let fresh = std::fs::read(folder.path().join("d.block")).unwrap();
    host_harness::export::block::accepted(&fresh).unwrap();
    let stored = std::fs::read(firmware_folder().join("src/default.block")).unwrap();
    assert!(
        fresh == stored,
        "write firmware/src/default.block anew, as firmware/default.toml says"
    );
}

#[test]
fn the_examples_joint_is_what_its_model_gives_as_rust() {
    let folder = tempfile::tempdir().unwrap();
    let examples = firmware_folder().join("examples");
    let model = examples.join("joint.toml");
    let arguments = format!(
        "export --model {} --format rust --input current --current-limit-a 2 --bus-v 12 --out j.rs",
        model.display()
    );
    done(&joint(folder.path(), &arguments));
    let fresh = std::fs::read(folder.path().join("j.rs")).unwrap();
    let stored = std::fs::read(examples.join("src/joint.rs")).unwrap();
    assert!(
        fresh == stored,
        "write firmware/examples/src/joint.rs anew, as firmware/examples/joint.toml says"
    );
}

#[test]
fn exported_rust_holds_the_same_block() {
    let folder = tempfile::tempdir().unwrap();
    let model = firmware_folder().join("default.toml");
    for format in ["block", "rust"] {
        let arguments =
            format!("export --model {} --format {format} --out d.{format}", model.display());
        done(&joint(folder.path(), &arguments));
    }
    let block = std::fs::read(folder.path().join("d.block")).unwrap();
    let source = std::fs::read_to_string(folder.path().join("d.rust")).unwrap();
    let (_, list) = source.split_once("pub const BLOCK: [u8;").unwrap();
    let bytes: Vec<u8> = list
        .split("0x")
        .skip(1)
        .take(block.len())
        .map(|byte| u8::from_str_radix(&byte[..2], 16).unwrap())
        .collect();
    assert_eq!(bytes, block);
    assert!(source.contains("torque_constant_nm_per_a: 0.05"));
}

#[test]
fn a_joint_that_no_drive_can_run_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let stage = "[[stage]]\nreduction = 2\nstiffness_nm_per_rad = 100\n";
    let motor = std::fs::read_to_string(firmware_folder().join("default.toml")).unwrap();
    std::fs::write(folder.path().join("m.toml"), motor + &stage.repeat(4)).unwrap();
    let output = joint(folder.path(), "export --model m.toml --format block --out m.block");
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("4 stages"));
    assert!(!folder.path().join("m.block").exists());
}

#[test]
fn a_recorded_stream_becomes_a_log_of_what_was_measured_and_estimated() {
    let folder = tempfile::tempdir().unwrap();
    let samples = plant(2_000);
    let mut frames = run(&block(&parameters()), &samples, &[]);
    // A damaged byte costs a frame, and is told.
    let middle = frames.len() / 2;
    frames[middle] ^= 0x40;
    std::fs::write(folder.path().join("f.bin"), &frames).unwrap();
    let output = joint(folder.path(), "monitor --stream f.bin --out l.csv --json");
    done(&output);
    let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((told["reports"].as_u64(), told["lost_frames"].as_u64()), (Some(99), Some(1)));
    let log = Log::read(&folder.path().join("l.csv"), Need::Drive).unwrap().log;
    assert_eq!(log.len(), 99);
    assert!((log.time_s[1] - 20.0 * 50e-6).abs() < 1e-12, "{}", log.time_s[1]);
    let first = &samples[19];
    assert_eq!(log.current_a.unwrap()[0], first.current_a.to_string().parse::<f64>().unwrap());
    let turn = std::f64::consts::TAU / f64::from(joint_tests::drive::COUNTS);
    assert_eq!(log.motor_angle_rad[0], f64::from(first.motor_counts) * turn);
}

#[test]
fn a_capture_over_a_debug_server_is_the_samples_that_the_drive_saw() {
    let folder = tempfile::tempdir().unwrap();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let samples = plant(3_000);
    let seen = samples.clone();
    let server = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        let (mut reader, mut asked) = (Reader::default(), vec![]);
        let mut byte = [0];
        // Until the record is asked for: the commands, then what the drive made of them.
        while !asked.contains(&telemetry::Command::Fetch) {
            stream.read_exact(&mut byte).unwrap();
            if let Some(frame) = reader.push(byte[0])
                && let Message::Command(command) = frame.message
            {
                asked.push(command);
            }
        }
        let commands: Vec<_> = asked
            .iter()
            .map(|own| (if *own == telemetry::Command::Fetch { 2_000 } else { 0 }, *own))
            .collect();
        stream.write_all(&run(&block(&parameters()), &seen, &commands)).unwrap();
        asked
    });
    let arguments = format!(
        "capture --connect 127.0.0.1:{port} --trigger current --above-a 0.05 --after 300 --seconds 30 --out c.csv"
    );
    done(&joint(folder.path(), &arguments));
    let arm = telemetry::Command::Arm { trigger: Trigger::CurrentAbove(0.05), after: 300 };
    assert!(server.join().unwrap().contains(&arm));
    let log = Log::read(&folder.path().join("c.csv"), Need::Drive).unwrap().log;
    let trigger = samples.iter().position(|sample| sample.current_a.abs() > 0.05).unwrap();
    let expected = &samples[..trigger + 300];
    assert_eq!(log.len(), expected.len());
    for (k, sample) in expected.iter().enumerate() {
        assert_eq!(
            log.voltage_v.as_ref().unwrap()[k],
            sample.voltage_v.to_string().parse::<f64>().unwrap()
        );
    }
}

#[test]
fn what_holds_no_telemetry_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("f.bin"), [1, 2, 3]).unwrap();
    for verb in ["monitor --out l.csv", "capture --out l.csv"] {
        let output = joint(folder.path(), &format!("{verb} --stream f.bin"));
        assert_eq!(output.status.code(), Some(2), "{verb}");
        assert_eq!(joint(folder.path(), verb).status.code(), Some(2), "{verb}");
    }
    assert!(!folder.path().join("l.csv").exists());
}
