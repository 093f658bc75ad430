//! `joint observe`: the on-drive observer over a log.

use std::path::{Path, PathBuf};

use joint_core::per_unit::Bases;
use serde_json::json;

use super::{Common, Failure, Outcome, Scalar, read_log, read_model};
use crate::log::{Log, Need};
use crate::model::Model;
use crate::observe::design::Tuning;
use crate::observe::drive;
use crate::observe::over::Samples;
use crate::observe::table;
use crate::plant::{BuildError, by_stages};

/// Run the on-drive observer over a log
///
/// Writes motor speed, friction, wind-up, output motion and load torque with one standard deviation
/// of each, and a status. Gains are designed from the model, its effects and its sensors. A log
/// without `output_angle_rad` is observed from the motor alone. With `--block` it is what the drive
/// would report with these very parameters, to the bit.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint observe --model refit/model.toml --log arm.csv --out observed.csv --scalar f32
  joint observe --block joint.block --log arm.csv --out observed.csv
  joint identify --model arm.toml --log calibration.csv --out refit   (before it)")]
pub struct Args {
    /// Model file
    #[arg(
        short = 'm',
        long,
        value_name = "TOML",
        required_unless_present = "block",
        conflicts_with = "block"
    )]
    pub model: Option<PathBuf>,
    /// Parameter block of a drive, in place of a model
    #[arg(long, value_name = "F", conflicts_with_all = ["scalar", "rated_load_nm"])]
    pub block: Option<PathBuf>,
    /// With a block: also write what the drive's sensors would show, as the program `hil` reads it
    #[arg(long, value_name = "F", requires = "block")]
    pub samples: Option<PathBuf>,
    /// Log to observe; - is standard input
    #[arg(short = 'l', long, value_name = "CSV")]
    pub log: PathBuf,
    /// File to write, compressed where it ends in .gz; - is standard output
    #[arg(short = 'o', long, value_name = "CSV")]
    pub out: PathBuf,
    /// Number to compute in
    #[arg(long, value_enum, default_value_t = Scalar::F32)]
    pub scalar: Scalar,
    /// Largest load expected at the output, Nm; where left out, from the log's voltages
    #[arg(long, value_name = "NM")]
    pub rated_load_nm: Option<f64>,
}

/// Runs the verb.
///
/// # Errors
/// A file that cannot be read or written, or a model or block that cannot be observed.
pub fn run(args: &Args, common: &Common) -> Result<Outcome, Failure> {
    let inputs = [Some(&args.log), args.model.as_ref(), args.block.as_ref()];
    let out = common.file(&args.out)?.apart_from(inputs.into_iter().flatten())?;
    let (name, text, samples) = match (&args.block, &args.model) {
        (Some(block), _) => in_drive(args, block, common)?,
        (None, Some(model)) => designed(args, model, common)?,
        (None, None) => return Err(Failure::input("a --model or a --block is needed")),
    };
    let path = out.write_table(text)?;
    Ok(Outcome::done(
        json!({"out": path, "model": name, "samples": samples}),
        format!("{}: {samples} samples of {name}", path.display()),
    ))
}

/// Name, table and number of samples.
type Observed = (String, String, usize);

fn designed(args: &Args, path: &Path, common: &Common) -> Result<Observed, Failure> {
    let model = read_model(path)?;
    let log = read_log(&args.log, Need::Drive)?;
    let bar = common.progress(0, "observing");
    let text = observed(&model, &log, args.rated_load_nm, args.scalar)
        .map_err(|error| Failure::input(format!("{}: {error}", path.display())))?;
    bar.finish_and_clear();
    Ok((model.name, text, log.len()))
}

/// As the drive itself reports it.
fn in_drive(args: &Args, path: &Path, common: &Common) -> Result<Observed, Failure> {
    let shown = args.samples.as_ref().map(|path| common.file(path)).transpose()?;
    let refused = |place: &Path, error: &dyn std::fmt::Display| {
        Failure::input(format!("{}: {error}", place.display()))
    };
    let block = std::fs::read(path).map_err(|error| refused(path, &error))?;
    let mut control = drive::control(&block).map_err(|error| refused(path, &error))?;
    let log = read_log(&args.log, Need::Drive)?;
    let samples =
        drive::samples(&log, &control.sensing()).map_err(|error| refused(&args.log, &error))?;
    let reports: Vec<_> = samples.iter().map(|sample| control.tick(*sample, 0)).collect();
    if let Some(shown) = shown {
        let bytes: Vec<u8> = samples.iter().flat_map(|sample| sample.to_bytes()).collect();
        shown.write(bytes)?;
    }
    Ok((path.display().to_string(), drive::table(&log.time_s, &reports), log.len()))
}

/// What the observer that is designed for a model finds in a log, as the text of a CSV file;
/// `rated_load_nm` is the largest load expected at the output, from the log's voltages where it is left out.
///
/// # Errors
/// The model cannot be observed.
pub fn observed(
    model: &Model,
    log: &Log,
    rated_load_nm: Option<f64>,
    scalar: Scalar,
) -> Result<String, BuildError> {
    by_stages!(model.stages.len(), N => observed_by::<N>(model, log, rated_load_nm, scalar))
}

fn observed_by<const N: usize>(
    model: &Model,
    log: &Log,
    rated_load_nm: Option<f64>,
    scalar: Scalar,
) -> Result<String, BuildError> {
    let samples = Samples::of(log);
    let (model, rating) = samples.sensed::<N>(model, rated_load_nm)?;
    let tuning = Tuning::default();
    let found = samples.observed::<N>(&model, &rating, &tuning, scalar.into())?;
    let bases = Bases::si(&model.motor, &model.stages);
    let shafts = std::array::from_fn(|k| bases.shaft(k + 1));
    Ok(format!("{}\n{}", table::header(N), table::rows(&log.time_s, &found, &shafts)))
}
