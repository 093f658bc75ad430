//! `joint simulate`: runs a model on a log's inputs.
//!
//! What comes out is a log again, with the simulation in the place of the measurements and every
//! state beside them, so that whatever reads the one reads the other.

use std::path::PathBuf;

use clap::ValueEnum;
use serde_json::json;

use super::{Common, Failure, Outcome, Scalar, read_log, read_model};
use crate::inputs::Missing;
use crate::log::{Log, MOTOR_ANGLE, Need, write_columns};
use crate::model::Model;
use crate::plant::{Inputs, Options, Snapshot, simulate_from};
use crate::reference::{self, ReferenceError};
use crate::simulated;
use crate::start::Measured;

/// Relative tolerance of the adaptive reference.
const REFERENCE_TOLERANCE: f64 = 1e-8;

/// Run a model on a log's inputs; the CSV has the log's columns and every state
///
/// The voltage is imposed where the log has one, else the current; a known load is applied. The
/// simulation starts at the log's first state: its first angle, the speed of its first samples and the
/// wind-up between its encoders. Single samples without an input hold the last value; where more than
/// twenty follow each other the winding is open and the joint swings freely. Simulated current and
/// angles take the place of the measured ones, the current as its sensor would show it without noise.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint simulate --model arm.toml --input arm.csv --out simulated.csv
  joint simulate --model arm.toml --input arm.csv --out single.csv --scalar f32 --step-us 50")]
pub struct Args {
    /// Model file
    #[arg(short = 'm', long, value_name = "TOML")]
    pub model: PathBuf,
    /// Log whose inputs drive the model; - is standard input
    #[arg(short = 'i', long, value_name = "CSV")]
    pub input: PathBuf,
    /// File to write, compressed where it ends in .gz; - is standard output
    #[arg(short = 'o', long, value_name = "CSV")]
    pub out: PathBuf,
    /// How the equations are solved
    #[arg(long, value_enum, default_value_t = Method::Embedded)]
    pub method: Method,
    /// Number to compute in, for the embedded method
    #[arg(long, value_enum, default_value_t = Scalar::F64)]
    pub scalar: Scalar,
    /// Longest step, microseconds; where left out, one step a sample (embedded) or as the
    /// tolerance asks (reference)
    #[arg(long, value_name = "N", value_parser = super::positive)]
    pub step_us: Option<f64>,
    /// Start at rest with every angle zero, whatever the log's first samples
    #[arg(long)]
    pub from_rest: bool,
}

/// How the equations are solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// The large step that runs on the drive
    Embedded,
    /// In double precision, sharing no code with the embedded method: implicit and adaptive, or
    /// explicit (Bogacki-Shampine 3) where --step-us is given
    Reference,
}

/// Runs the verb.
///
/// # Errors
/// A file that cannot be read or written, or a model that cannot be run.
pub fn run(args: &Args, common: &Common) -> Result<Outcome, Failure> {
    let out = common.file(&args.out)?.apart_from([&args.model, &args.input])?;
    let model = read_model(&args.model)?;
    let log = read_log(&args.input, Need::Drive)?;
    let bar = common.progress(0, "simulating");
    let columns = simulated(args, &model, &log, &mut |note| {
        bar.suspend(|| eprintln!("note: {}: {note}", args.input.display()));
    })?;
    bar.finish_and_clear();
    let path = out.write_table(write_columns(&columns))?;
    let samples = log.len();
    Ok(Outcome::done(
        json!({"out": path, "model": model.name, "samples": samples}),
        format!("{}: {samples} samples of {}", path.display(), model.name),
    ))
}

/// Runs a model on a log's inputs, as the arguments say; their files are only named in errors. Gives the
/// log's columns and every state, and tells what it notes of missing inputs.
///
/// # Errors
/// A model that cannot be run, or a first row without an angle.
pub fn simulated(
    args: &Args,
    model: &Model,
    log: &Log,
    note: &mut dyn FnMut(&str),
) -> Result<Vec<(String, Vec<f64>)>, Failure> {
    let (inputs, missing) = match args.method {
        Method::Embedded => Inputs::swinging(log),
        // Its equations have no open winding.
        Method::Reference => (Inputs::from_log(log), Missing::default()),
    };
    for told in missing.told(&log.time_s) {
        note(&told);
    }
    if args.method == Method::Reference && !Inputs::swinging(log).1.free.is_empty() {
        note("where the input is missing the reference holds the last value");
    }
    let start = match args.from_rest {
        true => None,
        false => Some(first_state(args, model, log)?),
    };
    let snapshots = solve(args, model, &inputs, start)?;
    if let Some(k) = snapshots.iter().position(|snapshot| !is_finite(snapshot)) {
        let (model, time) = (args.model.display(), log.time_s[k]);
        return Err(Failure::check(format!(
            "{model}: the simulation is not finite from t_s = {time} on\n  help: give a shorter step with --step-us, or use --method reference"
        )));
    }
    Ok(simulated::columns(model, log, &snapshots))
}

/// The state at the log's first sample.
fn first_state(args: &Args, model: &Model, log: &Log) -> Result<Vec<f64>, Failure> {
    let measured = Measured::new(model, log);
    measured.at(0).ok_or_else(|| {
        let log = args.input.display();
        Failure::input(format!(
            "{log}: the first row has no {MOTOR_ANGLE} to start from\n  help: remove the row, or give --from-rest"
        ))
    })
}

fn solve(
    args: &Args,
    model: &Model,
    inputs: &Inputs,
    start: Option<Vec<f64>>,
) -> Result<Vec<Snapshot>, Failure> {
    let refused = |error: crate::plant::BuildError| {
        Failure::input(format!("{}: {error}", args.model.display()))
    };
    let step_s = args.step_us.map(|step| step * 1e-6);
    match (args.method, args.scalar) {
        (Method::Embedded, scalar) => {
            let options = Options { step_s, start, ..Options::default() };
            simulate_from(&options, model, inputs, scalar.into()).map_err(refused)
        }
        (Method::Reference, Scalar::F64) => {
            let method = match step_s {
                Some(step_s) => reference::Method::BogackiShampine { step_s },
                None => reference::Method::Stiff { tolerance: REFERENCE_TOLERANCE },
            };
            let options = reference::Options { start, ..reference::Options::of(method) };
            let snapshots = reference::simulate(model, inputs, &options)
                .map_err(|error| unsolved(args, &error))?;
            resolved(args, model, inputs, &snapshots)?;
            Ok(snapshots)
        }
        (Method::Reference, Scalar::F32 | Scalar::Fixed) => Err(Failure::input(
            "--method reference computes in f64 only\n  help: leave --scalar out",
        )),
    }
}

/// A model that cannot be run is bad input; a method that fails on it is a failed check.
fn unsolved(args: &Args, error: &ReferenceError) -> Failure {
    let message = format!("{}: {error}", args.model.display());
    match error {
        ReferenceError::Diverged(_) | ReferenceError::Stiff(_) => {
            Failure::check(format!("{message}\n  help: give a shorter step with --step-us"))
        }
        _ => Failure::input(message),
    }
}

/// Checks that an explicit step was short enough: past its limit of stability, about 2.5
/// relaxations of the fastest mode, the explicit method stays bounded here and is plainly wrong.
fn resolved(
    args: &Args,
    model: &Model,
    inputs: &Inputs,
    snapshots: &[Snapshot],
) -> Result<(), Failure> {
    let Some(step_us) = args.step_us else { return Ok(()) };
    let fastest = snapshots.iter().map(|s| s.motor_speed_rad_per_s.abs()).fold(0.0, f64::max);
    let converged = reference::Method::converged(model, inputs.drive, fastest);
    let converged = converged.map_err(|error| unsolved(args, &error))?;
    match converged {
        // A quarter of a relaxation is converged: eight times that is two.
        reference::Method::BogackiShampine { step_s } if step_us * 1e-6 > 8.0 * step_s => {
            Err(Failure::check(format!(
                "{}: a step of {step_us} µs does not resolve this joint\n  help: give --step-us {:.2} or less, or leave it out",
                args.model.display(),
                step_s * 1e6
            )))
        }
        _ => Ok(()),
    }
}

fn is_finite(snapshot: &Snapshot) -> bool {
    let stages = snapshot.stages.iter().flat_map(|stage| {
        [stage.angle_rad, stage.speed_rad_per_s, stage.windup_rad, stage.bristle]
    });
    [
        snapshot.current_a,
        snapshot.measured_current_a,
        snapshot.motor_angle_rad,
        snapshot.motor_speed_rad_per_s,
        snapshot.motor_bristle,
    ]
    .into_iter()
    .chain(stages)
    .all(f64::is_finite)
}
