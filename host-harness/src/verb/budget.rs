//! `joint budget`: what the step costs on a chip, and whether that is within its budget.
//!
//! The firmware is built, run in QEMU where instructions are counted exactly, and its ELF files are
//! measured; `budgets.toml` in the workspace's root holds the limits.

mod model;
mod observer;
mod period;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use joint_core::fixed::Fixed;
use joint_core::joint::{Drive, Joint, Settings};
use serde::Deserialize;
use serde_json::json;

use super::{Common, Failure, Outcome, read_model};
use crate::scenario;

/// Count instructions and memory of the step on a chip against `budgets.toml`
///
/// Builds the firmware and runs it in QEMU (qemu-system-arm); exit 1 past a budget. With --model it counts
/// the step of that model instead, with its effects and without.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint budget --json
  joint budget --model found/model.toml")]
pub struct Args {
    /// Limits
    #[arg(long, value_name = "FILE", conflicts_with = "model")]
    pub budgets: Option<PathBuf>,
    /// Model whose step is counted
    #[arg(short = 'm', long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// Length of its step, µs
    #[arg(long, value_name = "T", default_value_t = 50.0, requires = "model", value_parser = super::positive)]
    pub period_us: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    budget: u64,
}

const HARD: &str = "thumbv7em-none-eabihf";
const SOFT: &str = "thumbv7em-none-eabi";

/// Runs the verb.
///
/// # Errors
/// The limits cannot be read, or the firmware cannot be built or run.
pub fn run(args: &Args, common: &Common) -> Result<Outcome, Failure> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    source_in(&root)?;
    if let Some(path) = &args.model {
        let (model, step_s) = (read_model(path)?, 1e-6 * args.period_us);
        let bar = common.progress(0, "building and counting");
        let rows = model::measure(&root, &model, step_s)?;
        bar.finish_and_clear();
        let text = model::told(&rows, step_s);
        return Ok(Outcome::done(json!(rows), text));
    }
    let path = args.budgets.clone().unwrap_or_else(|| root.join("budgets.toml"));
    let limits = limits(&path)?;
    let bar = common.progress(0, "building and counting");
    let measured = measure(&root)?;
    bar.finish_and_clear();
    let mut text = format!("{:<34} {:>9} {:>9}\n", "row", "measured", "budget");
    let mut passed = true;
    for (name, limit) in &limits {
        let found = measured.get(name.as_str()).copied();
        let holds = found.is_some_and(|found| found <= *limit);
        passed &= holds;
        let shown = found.map_or_else(|| "-".to_owned(), |found| found.to_string());
        let mark = if holds { "" } else { "  PAST ITS BUDGET" };
        let _ = writeln!(text, "{name:<34} {shown:>9} {limit:>9}{mark}");
    }
    if let Some(tick) = measured.get("tick_f32_instructions") {
        let frame = measured.get("frame_instructions").copied().unwrap_or(0);
        let [tick, both] =
            [*tick, tick + frame].map(|count| 100.0 * period::share(count, period::PERIOD_S));
        let _ = writeln!(
            text,
            "the control interrupt is {tick:.0} % of a period at 20 kHz and 170 MHz, {both:.0} % with \
             a report's frame in every one, were an instruction a cycle"
        );
    }
    let json = json!(measured);
    Ok(Outcome { json, text: text.trim_end().to_owned(), passed })
}

/// What is counted is built from source, which a program that was installed from a package has not beside it.
fn source_in(root: &Path) -> Result<(), Failure> {
    if root.join("firmware/Cargo.toml").is_file() {
        return Ok(());
    }
    Err(Failure::input(format!(
        "there is no source of the firmware in {}, where `joint` was built\n  help: in a copy of the repository: \
         cargo run --release --package host-harness -- budget",
        root.display()
    )))
}

fn limits(path: &Path) -> Result<BTreeMap<String, u64>, Failure> {
    let failed =
        |error: &dyn std::fmt::Display| Failure::input(format!("{}: {error}", path.display()));
    let text = fs::read_to_string(path).map_err(|error| failed(&error))?;
    let rows: BTreeMap<String, Row> =
        toml_edit::de::from_str(&text).map_err(|error| failed(&error))?;
    Ok(rows.into_iter().map(|(name, row)| (name, row.budget)).collect())
}

fn measure(root: &Path) -> Result<BTreeMap<String, u64>, Failure> {
    let target = folder_of(root);
    build(
        root,
        &target,
        HARD,
        &["--bin", "count", "--bin", "replay", "--bin", "hil", "--bin", "observe"],
    )?;
    build(root, &target, SOFT, &["--bin", "count_fixed", "--bin", "observe_fixed"])?;
    let elf = |triple: &str, program: &str| target.join(triple).join("release").join(program);
    let folder = tempfile::tempdir().map_err(|error| Failure::check(error.to_string()))?;
    let [observer, log] = observer::files()?;
    let [fixed_observer, fixed_log] = observer::fixed_files()?;
    let files = [
        ("parameters.bin", observer),
        ("log.bin", log),
        ("fixed.bin", fixed_observer),
        ("fixed_log.bin", fixed_log),
        ("joint.bin", fixed_block()?),
        ("page.bin", period::parameters()?),
        ("samples.bin", period::samples()?),
        ("commands.bin", Vec::new()),
    ];
    for (name, contents) in files {
        fs::write(folder.path().join(name), contents)
            .map_err(|error| Failure::check(error.to_string()))?;
    }
    let mut rows = values(&emulate(&elf(HARD, "count"), folder.path(), "count", false)?);
    let arguments = "count_fixed,arg=joint.bin";
    rows.extend(values(&emulate(&elf(SOFT, "count_fixed"), folder.path(), arguments, false)?));
    let arguments = "observe,arg=parameters.bin,arg=log.bin,arg=estimates.bin";
    let observed = values(&emulate(&elf(HARD, "observe"), folder.path(), arguments, false)?);
    let update = observed.get("update_instructions").copied();
    rows.extend(update.map(|count| ("observer_f32_instructions".to_owned(), count)));
    let arguments = "observe_fixed,arg=fixed.bin,arg=fixed_log.bin";
    let observed = values(&emulate(&elf(SOFT, "observe_fixed"), folder.path(), arguments, false)?);
    let update = observed.get("update_instructions").copied();
    rows.extend(update.map(|count| ("observer_fixed_instructions".to_owned(), count)));
    let arguments = "hil,arg=samples.bin,arg=commands.bin,arg=frames.bin";
    let said = emulate(&elf(HARD, "hil"), folder.path(), arguments, true)?;
    if !said.contains("parameters=accepted") {
        return Err(Failure::check(format!("the emulated drive refuses its parameters: {said}")));
    }
    let drive = values(&said);
    for (row, name) in [
        ("tick_f32_instructions", "tick_instructions"),
        ("frame_instructions", "frame_instructions"),
        ("tick_stack_bytes", "tick_stack_bytes"),
        ("start_stack_bytes", "start_stack_bytes"),
    ] {
        rows.extend(drive.get(name).map(|count| (row.to_owned(), *count)));
    }
    rows.retain(|name, _| name.ends_with("_instructions") || name.ends_with("_bytes"));
    rows.insert("flash_bytes".to_owned(), flash(&elf(HARD, "replay"))?);
    rows.insert("flash_fixed_bytes".to_owned(), flash(&elf(SOFT, "count_fixed"))?);
    Ok(rows)
}

/// Where the firmware is built.
fn folder_of(root: &Path) -> PathBuf {
    match std::env::var_os("CARGO_TARGET_DIR") {
        Some(folder) => root.join(folder).join("qemu"),
        None => root.join("target/qemu"),
    }
}

fn build(root: &Path, target: &Path, triple: &str, what: &[&str]) -> Result<(), Failure> {
    let status = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()))
        .current_dir(root)
        .args(["build", "--quiet", "--release", "--package", "firmware", "--target", triple])
        .args(what)
        .arg("--target-dir")
        .arg(target)
        .status();
    match status {
        Ok(status) if status.success() => Ok(()),
        Ok(_) => Err(Failure::check(format!("the firmware does not build for {triple}"))),
        Err(error) => Err(Failure::check(format!("cargo: {error}"))),
    }
}

/// The assumed joint in fixed point, one micro-step of 50 µs, as a parameter block.
fn fixed_block() -> Result<Vec<u8>, Failure> {
    let failed = |error: &dyn std::fmt::Display| Failure::check(error.to_string());
    let model = scenario::paper();
    let mut settings = Settings::new(Drive::Voltage, 50e-6);
    settings.micro_steps = Some(1);
    let [first, second] = model.stages[..] else {
        return Err(Failure::check("the assumed joint has two stages"));
    };
    let stages = [first, second];
    let joint = Joint::<Fixed, 2>::new(&model.motor, &stages, &model.load, &settings)
        .map_err(|error| failed(&error))?;
    let mut bytes = vec![0; 4096];
    let length = firmware::block::encode(&joint, 2, &mut bytes).map_err(|error| failed(&error))?;
    bytes.truncate(length);
    Ok(bytes)
}

/// Runs a program in that folder, with the file `page.bin` as its parameter page where it has one.
fn emulate(elf: &Path, folder: &Path, arguments: &str, page: bool) -> Result<String, Failure> {
    let mut command = Command::new("qemu-system-arm");
    if page {
        let address = firmware::block::PAGE_ADDRESS_F405;
        let device = format!("loader,file=page.bin,addr={address:#x},force-raw=on");
        command.arg("-device").arg(device);
    }
    let output = command
        .current_dir(folder)
        .args(["-M", "netduinoplus2", "-display", "none", "-monitor", "none", "-serial", "null"])
        .args(["-icount", "shift=0,sleep=off", "-semihosting-config"])
        .arg(format!("enable=on,target=native,arg={arguments}"))
        .arg("-kernel")
        .arg(elf)
        .output()
        .map_err(|error| {
            Failure::check(format!("qemu-system-arm: {error}\n  help: install qemu-system-arm"))
        })?;
    if !output.status.success() {
        let error = String::from_utf8_lossy(&output.stderr);
        return Err(Failure::check(format!("{}: {}", elf.display(), error.trim())));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

fn values(text: &str) -> BTreeMap<String, u64> {
    text.lines()
        .filter_map(|line| line.split_once('='))
        .filter_map(|(name, value)| Some((name.to_owned(), value.trim().parse().ok()?)))
        .collect()
}

/// Bytes of a 32-bit ELF file that are loaded: what a chip's flash holds.
fn flash(path: &Path) -> Result<u64, Failure> {
    let bytes =
        fs::read(path).map_err(|error| Failure::check(format!("{}: {error}", path.display())))?;
    loaded(&bytes).ok_or_else(|| Failure::check(format!("{}: not an ELF file", path.display())))
}

fn loaded(elf: &[u8]) -> Option<u64> {
    let word = |at: usize| Some(u32::from_le_bytes(elf.get(at..at + 4)?.try_into().ok()?));
    let half = |at: usize| Some(u16::from_le_bytes(elf.get(at..at + 2)?.try_into().ok()?));
    let (start, size, number) = (word(0x1c)? as usize, half(0x2a)?, half(0x2c)?);
    let mut sum = 0;
    for k in 0..usize::from(number) {
        let at = start + k * usize::from(size);
        if word(at)? == 1 {
            sum += u64::from(word(at + 16)?);
        }
    }
    Some(sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_key_and_number_are_values_and_others_are_not() {
        let found = values("a=3\nnoise\nb = 4\nc=x\n");
        assert_eq!(found.get("a"), Some(&3));
        assert_eq!(found.len(), 2);
    }

    #[test]
    fn every_budget_row_of_the_workspace_is_read() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let limits = limits(&root.join("budgets.toml")).unwrap();
        assert_eq!(limits.get("step_f32_instructions"), Some(&700));
        assert!(limits.len() >= 8);
    }

    #[test]
    fn a_program_away_from_its_source_says_what_is_not_there() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        assert!(source_in(&root).is_ok());
        let elsewhere = tempfile::tempdir().unwrap();
        let told = format!("{:?}", source_in(elsewhere.path()));
        assert!(told.contains("no source of the firmware"), "{told}");
    }

    #[test]
    fn what_is_no_elf_file_has_no_size() {
        assert_eq!(loaded(b"nothing"), None);
    }
}
