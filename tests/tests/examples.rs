//! joint-core in someone else's firmware: what the RTIC program sends is what the host computes.

use std::fs;
use std::path::PathBuf;

use joint_core::telemetry::{Message, Report};
use joint_examples::REPORT_EVERY;
use joint_examples::estimator::{Estimator, HELLO};
use joint_examples::stand_in::StandIn;
use joint_tests::drive::frames;
use joint_tests::qemu::{self, Board};

/// 0.2 s at 20 kHz: every voltage, with and without the load.
const REPORTS: usize = 200;

fn on_host() -> Vec<Report> {
    let (mut sensors, mut estimator) = (StandIn::start().unwrap(), Estimator::start().unwrap());
    let reports = (0..REPORTS as u32 * REPORT_EVERY).map(|_| {
        let (current_a, motor_counts) = sensors.read();
        estimator.period(current_a, motor_counts)
    });
    reports.step_by(REPORT_EVERY as usize).collect()
}

#[test]
fn the_stand_in_moves_and_is_followed() {
    let reports = on_host();
    let most = reports.iter().map(|own| own.sample.motor_counts.abs()).max().unwrap();
    assert!(most > 40_960, "{most} counts, less than ten turns");
    let load = |range: std::ops::Range<usize>| {
        let count = range.len() as f32;
        let own = reports[range].iter().map(|own| own.estimates.load_torque_nm);
        own.sum::<f32>() / count
    };
    // At 6 V under 4 mNm, then at 3 V without: within a quarter of the load.
    for (range, exact) in [(90..100, 0.004), (110..120, 0.0)] {
        let found = load(range);
        assert!((found - exact).abs() < 0.001, "{found} for {exact}");
    }
}

#[test]
fn an_rtic_program_sends_what_the_host_estimates_to_the_bit() {
    let name = "an_rtic_program_sends_what_the_host_estimates_to_the_bit";
    if !qemu::available(name) {
        return;
    }
    let what = ["--package", "joint-examples", "--bin", "rtic", "--features", "rtic"];
    qemu::built(&qemu::cargo_build(qemu::TARGET, &what));
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).unwrap();
    let host = on_host();
    let length = |message: &Message| joint_core::telemetry::frame::encode(message, 0).len();
    let bytes = length(&Message::Hello(HELLO)) + REPORTS * length(&Message::Report(host[0]));
    let elf = qemu::target_folder().join(qemu::TARGET).join("release/rtic");
    let mut sent = qemu::run_serial(&elf, Board::NetduinoPlus2, &folder, bytes);
    sent.truncate(bytes);
    let mut chip = frames(&sent).into_iter().map(|frame| frame.message);
    assert_eq!(chip.next(), Some(Message::Hello(HELLO)));
    for (k, host) in host.into_iter().enumerate() {
        assert_eq!(chip.next(), Some(Message::Report(host)), "report {k}");
    }
}
