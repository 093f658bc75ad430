//! `joint flash`: a board's program, its parameters, or both.

use std::path::PathBuf;

use serde_json::json;

use super::{Common, Failure, Outcome};
use crate::fault::InputError;
use crate::probe::Chip;

/// Program a board by a debug probe: the firmware, its parameters, or both
///
/// The block is checked as the chip would check it before anything is written. Needs the feature
/// `probe`: cargo run --release -p host-harness --features probe -- flash …
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint flash --chip stm32g431 --params-only --block joint.block
  joint flash --chip stm32f405 --program target/thumbv7em-none-eabihf/release/drive --block joint.block")]
pub struct Args {
    /// The board's chip
    #[arg(long, value_enum)]
    pub chip: Chip,
    /// Firmware to program, an ELF file
    #[arg(long, value_name = "ELF", required_unless_present = "params_only")]
    pub program: Option<PathBuf>,
    /// Parameter block of `joint export --format block`
    #[arg(long, value_name = "FILE", required_unless_present = "program")]
    pub block: Option<PathBuf>,
    /// Leave the program as it is
    #[arg(long, conflicts_with = "program", requires = "block")]
    pub params_only: bool,
    /// Debug probe, where there is more than one: VID:PID[:SERIAL]
    #[arg(long, value_name = "PROBE")]
    pub probe: Option<String>,
    /// Attach and check, and write nothing
    #[arg(long)]
    pub dry_run: bool,
}

/// Runs the verb.
///
/// # Errors
/// A block that the chip would refuse, a program that cannot be read, or a board that cannot be
/// reached.
pub fn run(args: &Args, _common: &Common) -> Result<Outcome, Failure> {
    let block = match &args.block {
        None => None,
        Some(path) => {
            let bytes =
                std::fs::read(path).map_err(|error| InputError::unreadable(path, &error))?;
            let crc = args.chip.takes(&bytes).map_err(|why| {
                let help = "write it anew with `joint export --format block`";
                Failure::input(format!("{}: {why}\n  help: {help}", path.display()))
            })?;
            Some((bytes, crc))
        }
    };
    if let Some(path) = &args.program {
        std::fs::metadata(path).map_err(|error| InputError::unreadable(path, &error))?;
    }
    program(args, block.as_ref().map(|(bytes, _)| &bytes[..]))?;
    let crc = block.map(|(_, crc)| format!("{crc:08x}"));
    let mut text = format!(
        "{}: {}",
        args.chip.name(),
        if args.dry_run { "checked, nothing written" } else { "programmed, verified, started" }
    );
    if let Some(crc) = &crc {
        text.push_str(&format!(", parameters {crc}"));
    }
    let json = json!({
        "chip": args.chip.name(),
        "program": args.program,
        "block": args.block,
        "crc32": crc,
        "written": !args.dry_run,
    });
    Ok(Outcome::done(json, text))
}

#[cfg(feature = "probe")]
fn program(args: &Args, block: Option<&[u8]>) -> Result<(), Failure> {
    use crate::probe::board::{Board, probe};
    probe(args.probe.as_deref())
        .and_then(|probe| Board::attach(probe, args.chip))
        .and_then(|mut board| board.program(args.program.as_deref(), block, args.dry_run))
        .map_err(|why| Failure::check(format!("{}: {why}", args.chip.name())))
}

#[cfg(not(feature = "probe"))]
fn program(_: &Args, _: Option<&[u8]>) -> Result<(), Failure> {
    Err(super::drive::no_probe())
}
