//! What the observer computes on the chip is what it computes on the host, and what it costs there.

use std::fs;
use std::path::PathBuf;

use firmware::block;
use firmware::observing::{Observing, from_bytes, row, row_numbers, to_bytes};
use host_harness::model::{Model, Sensor};
use host_harness::observe::design::{Tuning, design};
use host_harness::observe::judge::shown;
use host_harness::observe::rating::Rating;
use host_harness::observe::run::Seen;
use host_harness::observe::twin::{Felt, twin};
use host_harness::scenario::paper;
use joint_core::joint::{Drive, Joint, Settings};
use joint_core::observer::{Gains, Observer, Sample, Turn};
use joint_tests::qemu::{self, Board};

const STEP_S: f64 = 50e-6;
const SAMPLES: usize = 3001;

fn model() -> Model {
    let sensor = Sensor {
        sample_time_s: STEP_S,
        motor_encoder_counts_per_rev: 3000.0,
        output_encoder_counts_per_rev: 65536.0,
        current_noise_a: 1.5e-3,
    };
    Model { sensor, ..paper() }
}

fn observer(model: &Model, rating: &Rating) -> Observing<2> {
    let design = design::<2>(model, Drive::Voltage, STEP_S, rating, &Tuning::default()).unwrap();
    let stages = [model.stages[0], model.stages[1]];
    let settings = Settings { micro_steps: Some(1), ..Settings::new(Drive::Voltage, STEP_S) };
    let joint = Joint::<f32, 2>::new(&model.motor, &stages, &model.load, &settings).unwrap();
    let gains = Gains::new(&design, &model.motor, &stages, Drive::Voltage, STEP_S);
    Observer { joint, gains }
}

fn sample(seen: &Seen) -> Sample<f32> {
    let turn = |angle: f64| Turn::from_turns(angle / std::f64::consts::TAU);
    Sample {
        drive: seen.drive as f32,
        current: seen.current.is_finite().then_some(seen.current as f32),
        motor: seen.motor.is_finite().then(|| turn(seen.motor)),
        output: seen.output.is_finite().then(|| turn(seen.output)),
    }
}

/// A log with everything in it that a drive may meet.
fn log(model: &Model, rating: &Rating) -> Vec<Sample<f32>> {
    let felt = Felt { drive: 0.005, torque: 1e-7 };
    let motion = twin(model, Drive::Voltage, STEP_S, rating, &felt, SAMPLES, 7).unwrap();
    let mut seen = shown(model, Drive::Voltage, &motion, true, 7);
    for k in (900..1000).step_by(7) {
        seen[k].motor = f64::NAN;
    }
    for k in (1100..1300).step_by(9) {
        seen[k] = seen[k - 1];
    }
    seen[1400].motor += 2.0;
    seen[1500].drive = f64::NAN;
    seen[1600].current = f64::NAN;
    seen[1700].current = 50.0;
    seen.iter().map(sample).collect()
}

#[test]
fn the_observer_gives_the_same_bits_on_every_board_and_keeps_its_budget() {
    if !qemu::available("the_observer_gives_the_same_bits_on_every_board_and_keeps_its_budget") {
        return;
    }
    let model = model();
    let rating = Rating { load_nm: 0.02, ..Rating::of(&model, Drive::Voltage) };
    let observer = observer(&model, &rating);
    let samples = log(&model, &rating);
    let records: Vec<u8> = samples.iter().flat_map(to_bytes).collect();
    let mut track = observer.start(0);
    let mut host: Vec<u8> = Vec::new();
    for record in records.as_chunks().0 {
        observer.update(&mut track, &from_bytes(record));
        let put = |number: f32| {
            host.extend(number.to_le_bytes());
            Ok::<(), std::convert::Infallible>(())
        };
        let Ok(()) = row(&observer.estimate(&track), put);
    }
    assert_eq!(host.len(), SAMPLES * row_numbers(2) * 4);
    assert!(host.as_chunks::<4>().0.iter().all(|&word| f32::from_le_bytes(word).is_finite()));

    let mut bytes = vec![0; 6144];
    let length = block::encode(&observer, 2, &mut bytes).unwrap();
    println!("block_bytes={length}");
    for board in Board::ALL {
        let name = format!("observer-{}", board.machine());
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("parameters.bin"), &bytes[..length]).unwrap();
        fs::write(folder.join("log.bin"), &records).unwrap();
        let files = ["parameters.bin", "log.bin", "estimates.bin"];
        let run = qemu::run("observe", board, &folder, &files);
        assert_eq!(run.code, Some(0), "{run:?}");
        assert_eq!(run.value("samples"), SAMPLES.to_string());
        let chip = fs::read(folder.join("estimates.bin")).unwrap();
        let words = host.as_chunks::<4>().0.iter().zip(chip.as_chunks::<4>().0);
        if let Some(first) = words.clone().position(|(host, chip)| host != chip) {
            let (row, column) = (first / row_numbers(2), first % row_numbers(2));
            panic!("{}: estimate {column} differs first at sample {row}", board.machine());
        }
        assert_eq!(chip.len(), host.len());
        if board == Board::NetduinoPlus2 {
            print!("{}", run.stdout);
            let most: u32 = run.value("update_instructions").parse().unwrap();
            // The aim is 1,100; this only keeps what is reached, 14 of it the step's exact bristle.
            assert!(most <= 1160, "an update takes {most} instructions");
        }
    }
}
