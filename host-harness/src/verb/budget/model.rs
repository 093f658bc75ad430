//! What a model of one's own costs: its f32 step with its effects on the emulated chip, beside the same
//! joint without them.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use firmware::replay::ReplayedJoint;
use firmware::samples::Sample;
use joint_core::joint::{Drive, Settings};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::{HARD, build, emulate, folder_of, period, values};
use crate::model::Model;
use crate::synthetic::excitation;
use crate::verb::Failure;

/// Steps that are counted, of which the most costly tells.
const STEPS: usize = 4_000;
/// The excitation is the same every time.
const SEED: u64 = 1;
/// Room for a block.
const BLOCK_BYTES: usize = 2048;

/// Instructions of a step of this length, most and least over a run with reversals and rest, and its
/// micro-steps, with the model's effects and without.
pub(super) fn measure(
    root: &Path,
    model: &Model,
    step_s: f64,
) -> Result<BTreeMap<String, u64>, Failure> {
    let target = folder_of(root);
    let plain = Model { effects: Vec::new(), ..model.clone() };
    let blocks = [("", block(model, step_s)?), ("_without_effects", block(&plain, step_s)?)];
    build(root, &target, HARD, &["--bin", "replay"])?;
    let elf = target.join(HARD).join("release/replay");
    let folder = tempfile::tempdir().map_err(failed)?;
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let inputs = excitation(model, STEPS, step_s, &mut random);
    let log = inputs.iter().map(|input| Sample { input: *input as f32, load: 0.0 });
    let log: Vec<u8> = log.flat_map(Sample::to_bytes).collect();
    fs::write(folder.path().join("log.bin"), log).map_err(failed)?;
    let mut rows = BTreeMap::new();
    for (which, block) in blocks {
        fs::write(folder.path().join("block.bin"), block).map_err(failed)?;
        let arguments = "replay,arg=block.bin,arg=log.bin,arg=states.bin";
        let counted = values(&emulate(&elf, folder.path(), arguments, false)?);
        for name in ["step_instructions", "step_instructions_least", "micro_steps"] {
            rows.extend(counted.get(name).map(|count| (format!("{name}{which}"), *count)));
        }
    }
    Ok(rows)
}

/// The rows in words.
pub(super) fn told(rows: &BTreeMap<String, u64>, step_s: f64) -> String {
    let of = |name: &str| rows.get(name).copied().unwrap_or(0);
    let line = |what: &str, which: &str| {
        let most = of(&format!("step_instructions{which}"));
        let least = of(&format!("step_instructions_least{which}"));
        let steps = of(&format!("micro_steps{which}"));
        let share = 100.0 * period::share(most, step_s);
        format!(
            "{what:<16} {most} instructions a step (least {least}), {steps} micro-steps, {share:.0} % of a \
             period at 170 MHz were an instruction a cycle"
        )
    };
    format!("{}\n{}", line("with effects", ""), line("without", "_without_effects"))
}

/// The joint's f32 step as a parameter block.
fn block(model: &Model, step_s: f64) -> Result<Vec<u8>, Failure> {
    match model.stages.len() {
        0 => encoded::<0>(model, step_s),
        1 => encoded::<1>(model, step_s),
        2 => encoded::<2>(model, step_s),
        3 => encoded::<3>(model, step_s),
        more => {
            Err(Failure::input(format!("the model has {more} stages; the firmware takes three")))
        }
    }
}

fn encoded<const N: usize>(model: &Model, step_s: f64) -> Result<Vec<u8>, Failure> {
    let stages: [_; N] = std::array::from_fn(|k| model.stages[k]);
    // A model without a winding is driven by its current.
    let winding = model.motor.phase_resistance_ohm > 0.0;
    let drive = if winding { Drive::Voltage } else { Drive::Current };
    let settings = Settings { effects: &model.effects, ..Settings::new(drive, step_s) };
    let joint = ReplayedJoint::<N>::new(&model.motor, &stages, &model.load, &settings)
        .map_err(|error| Failure::input(error.to_string()))?;
    let mut bytes = vec![0; BLOCK_BYTES];
    let length = firmware::block::encode(&joint, N as u8, &mut bytes).map_err(failed)?;
    bytes.truncate(length);
    Ok(bytes)
}

fn failed(error: impl std::fmt::Display) -> Failure {
    Failure::check(error.to_string())
}
