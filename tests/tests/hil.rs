//! The drive in the loop: what its interrupt makes of a simulated plant's samples is what the host
//! makes of them, bit for bit, from the parameter page to the frames.

use std::fs;
use std::path::PathBuf;

use firmware::block::{BlockError, PAGE_BYTES, VERSION, encode_as};
use firmware::parameters::Parameters;
use joint_core::effect::{EffectParameters, Kind};
use joint_core::observer::Status as Health;
use joint_core::params::Location;
use joint_core::telemetry::{Command, Hello, Message, Mode, Report, Sample, Status, Trigger};
use joint_tests::drive::{block, command_bytes, frames, parameters, parameters_with, plant, run};
use joint_tests::qemu::{self, Board, Run};

const SAMPLES: usize = 4_003;

/// The emulated drive with this page in its flash.
fn emulated(
    name: &str,
    board: Board,
    page: &[u8],
    samples: &[Sample],
    commands: &[(u32, Command)],
) -> (Run, Vec<u8>) {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{board:?}"));
    fs::create_dir_all(&folder).unwrap();
    let file = |name: &str, bytes: &[u8]| {
        fs::write(folder.join(name), bytes).unwrap();
        folder.join(name)
    };
    let page = file("page.bin", page);
    let bytes: Vec<u8> = samples.iter().flat_map(|sample| sample.to_bytes()).collect();
    file("samples.bin", &bytes);
    file("commands.bin", &command_bytes(commands));
    let arguments = ["samples.bin", "commands.bin", "frames.bin"];
    let elf = qemu::firmware("hil", board);
    let run = qemu::run_elf(&elf, board, &folder, &arguments, Some(&page));
    assert_eq!(run.code, Some(0), "{run:?}");
    (run, fs::read(folder.join("frames.bin")).unwrap())
}

fn messages(bytes: &[u8]) -> Vec<Message> {
    frames(bytes).into_iter().map(|frame| frame.message).collect()
}

fn hello(bytes: &[u8]) -> Hello {
    let found = messages(bytes).into_iter().find_map(|message| match message {
        Message::Hello(hello) => Some(hello),
        _ => None,
    });
    found.expect("a drive says who it is")
}

fn reports(bytes: &[u8]) -> Vec<Report> {
    let found = messages(bytes).into_iter();
    found
        .filter_map(|message| match message {
            Message::Report(report) => Some(report),
            _ => None,
        })
        .collect()
}

#[test]
fn interrupt_to_frame_gives_the_hosts_bits_on_every_board() {
    if !qemu::available("interrupt_to_frame_gives_the_hosts_bits_on_every_board") {
        return;
    }
    let (page, samples) = (block(&parameters()), plant(SAMPLES));
    let commands = [(1_000, Command::Rate(3)), (2_500, Command::Hello), (3_000, Command::Rate(50))];
    let host = run(&page, &samples, &commands);
    let seen = reports(&host);
    assert!(seen.iter().all(|report| report.status == Status::default()), "a clean record");
    assert_eq!(seen.len(), 1_000 / 20 + 2_000 / 3 + 1_003 / 50);
    for board in Board::ALL {
        let (run, chip) = emulated("hil", board, &page, &samples, &commands);
        assert_eq!(run.value("parameters"), "accepted");
        let pairs = frames(&host).into_iter().zip(frames(&chip));
        for (host, chip) in pairs {
            assert_eq!(host, chip, "{}", board.machine());
        }
        assert!(host == chip, "{}: {} for {} bytes", board.machine(), chip.len(), host.len());
    }
}

#[test]
fn a_capture_comes_back_as_the_samples_that_went_in() {
    if !qemu::available("a_capture_comes_back_as_the_samples_that_went_in") {
        return;
    }
    let (page, samples) = (block(&parameters()), plant(SAMPLES));
    let arm = Command::Arm { trigger: Trigger::Reversal, after: 200 };
    let commands = [(0, Command::Rate(0)), (1_100, arm), (3_000, Command::Fetch)];
    let host = run(&page, &samples, &commands);
    for board in Board::ALL {
        let (_, chip) = emulated("capture", board, &page, &samples, &commands);
        assert!(chip == host, "{}", board.machine());
    }
    let (mut head, mut record) = (None, vec![]);
    for message in messages(&host) {
        match message {
            Message::CaptureHead(own) => head = Some(own),
            Message::Samples(first, samples) => {
                assert_eq!(first as usize, record.len());
                record.extend(samples);
            }
            _ => {}
        }
    }
    let head = head.unwrap();
    let (first, trigger) = (head.first_tick as usize, head.first_tick + head.trigger_at);
    assert_eq!((first, head.samples as usize), (1_100, record.len()));
    // The same run with every period told shows where the speed turns first.
    let told = reports(&run(&page, &samples, &[(0, Command::Rate(1))]));
    let speed = |tick: u32| told[tick as usize].estimates.motor_velocity_rad_per_s;
    let turns = (1_100..).find(|tick| speed(*tick) * speed(*tick - 1) < 0.0);
    assert_eq!(Some(trigger), turns);
    assert_eq!(head.samples - head.trigger_at, 200);
    assert_eq!(record, samples[first..first + record.len()]);
}

#[test]
fn a_block_is_accepted_migrated_or_refused_by_name_and_a_refusal_listens_with_the_defaults() {
    let name = "a_block_is_accepted_migrated_or_refused_by_name";
    if !qemu::available(name) {
        return;
    }
    let samples = plant(200);
    let good = block(&parameters());
    let as_version = |version| {
        let mut bytes = vec![0; PAGE_BYTES];
        let length = encode_as(version, &parameters(), 2, &mut bytes).unwrap();
        bytes.truncate(length);
        bytes
    };
    let old = {
        let mut bytes = vec![0; PAGE_BYTES];
        let length = encode_as(1, &parameters().observer, 2, &mut bytes).unwrap();
        bytes.truncate(length);
        bytes
    };
    let mut damaged = good.clone();
    damaged[40] ^= 1;
    let mut long = good.clone();
    long[9] = 0xff;
    let many = {
        let mut bytes = vec![0; PAGE_BYTES];
        let length = encode_as(VERSION, &parameters(), 9, &mut bytes).unwrap();
        bytes.truncate(length);
        bytes
    };
    // What version 2 calls this effect is another one now.
    let renumbered = {
        let cogging = EffectParameters::new(Kind::Cogging, Location::Motor)
            .with("order", 6.0)
            .with("amplitude_nm", 1e-3);
        let mut bytes = vec![0; PAGE_BYTES];
        let length = encode_as(2, &parameters_with(&[cogging]), 2, &mut bytes).unwrap();
        bytes.truncate(length);
        bytes
    };
    let wrong = {
        let Parameters { observer, mut sensing } = parameters();
        sensing.sample_time_s = f32::NAN;
        block(&Parameters { observer, sensing })
    };
    let cases: [(&[u8], &str, u8, u16); 11] = [
        (&good, "accepted", 0, VERSION),
        (&old, "accepted", 0, 1),
        (&as_version(2), "accepted", 0, 2),
        (&renumbered, "version 2 with effects", BlockError::Effects(2).code(), VERSION),
        (&[0xff; 64], "no parameter block", BlockError::Empty.code(), VERSION),
        (&[0x11; 64], "not a parameter block", BlockError::Magic.code(), VERSION),
        (&as_version(99), "version 99", BlockError::Version(0).code(), VERSION),
        (&damaged, "damaged", BlockError::Crc { stored: 0, found: 0 }.code(), VERSION),
        (&long, "wrong length", BlockError::Length.code(), VERSION),
        (&many, "9 stages", BlockError::Stages(9).code(), VERSION),
        (&wrong, "sample_time_s", BlockError::Inadmissible("").code(), VERSION),
    ];
    for (page, said, code, version) in cases {
        let board = Board::NetduinoPlus2;
        let (run, chip) = emulated(name, board, page, &samples, &[]);
        assert!(run.value("parameters").contains(said), "{said}: {run:?}");
        assert!(chip == joint_tests::drive::run(page, &samples, &[]), "{said}");
        let hello = hello(&chip);
        assert_eq!((hello.refusal, hello.block_version), (code, version), "{said}");
        let defaults = said != "accepted";
        assert_eq!(hello.mode == Mode::Defaults, defaults, "{said}");
        let reports = reports(&chip);
        assert_eq!(reports.len(), 10);
        for report in reports {
            assert_eq!(report.status.meets(Status::DEFAULTS), defaults, "{said}");
            assert_eq!(report.stages, if defaults { 0 } else { 2 });
        }
    }
}

#[test]
fn faults_are_flagged_where_they_are_and_no_estimate_is_lost_to_them() {
    if !qemu::available("faults_are_flagged_where_they_are") {
        return;
    }
    let page = block(&parameters());
    let mut samples = plant(SAMPLES);
    // No number, beyond the sensor, and a jump of the encoder there and back.
    samples[100].current_a = f32::NAN;
    samples[200].voltage_v = f32::INFINITY;
    samples[250].current_a = 50.0;
    // Not a whole number of turns.
    samples[300].motor_counts += 100_000;
    let commands = [(0, Command::Rate(1))];
    let host = run(&page, &samples, &commands);
    let (_, chip) = emulated("faults", Board::Mps2An386, &page, &samples, &commands);
    let reports = reports(&chip);
    assert!(chip == host && reports.len() == SAMPLES);
    for report in &reports {
        let tick = report.tick;
        let own = &report.estimates;
        assert!(own.motor_velocity_rad_per_s.is_finite() && own.output_angle_rad.is_finite());
        let expected = match tick {
            100 | 200 | 250 => Status::MEASUREMENT,
            300 | 301 => Status::ENCODER_JUMP,
            _ => Status::default(),
        };
        assert_eq!(report.status, expected, "tick {tick}");
        let health = |flag: Health| report.health & flag.bits() != 0;
        // What is flagged is not believed either.
        assert_eq!(health(Health::NO_CURRENT), tick == 100 || tick == 250, "tick {tick}");
        assert_eq!(health(Health::NO_DRIVE), tick == 200, "tick {tick}");
        assert!(health(Health::GLITCH) || tick != 300, "tick {tick}");
        assert!(!health(Health::LOST) || tick < 100, "tick {tick}");
    }
}

#[test]
fn what_nobody_takes_is_dropped_and_counted() {
    let (page, samples) = (block(&parameters()), plant(1_000));
    let mut session = firmware::session::Session::new();
    session.start(&page).unwrap();
    session.command(Command::Rate(1));
    let messages = firmware::link::messages();
    for sample in &samples[..900] {
        session.tick(*sample, 0, Status::default(), &messages);
    }
    let mut taken = 0;
    while messages.dequeue().is_some() {
        taken += 1;
    }
    session.command(Command::Rate(0));
    let mut said = None;
    for sample in &samples[900..910] {
        session.tick(*sample, 0, Status::default(), &messages);
        if let Some(Message::Dropped(count)) = messages.dequeue() {
            said = Some(count);
        }
    }
    assert_eq!(said, Some(900 - taken));
}
