//! `joint export`: a model for the firmware, or for other tools.

use std::path::PathBuf;

use clap::ValueEnum;
use firmware::block::Block;
use joint_core::joint::Drive;
use joint_fmu::Version;
use serde_json::json;

use super::{Common, Failure, Outcome, read_model};
use crate::export::{self, DriveOptions};
use crate::model::Model;

/// Turn a model into parameters for the firmware, or into another tool's model
///
/// `block` is what the drive's flash page holds, `rust` the same as a source file; `fmu` and `fmu3` are units
/// of FMI 2.0 and 3.0 for co-simulation that step this very joint, `mjcf` a MuJoCo model and `urdf` a rigid joint,
/// which say what they had to leave out.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint export --model found/model.toml --format block --out joint.block
  joint export --model found/model.toml --format rust --out src/joint.rs --period-us 100
  joint export --model found/model.toml --format fmu --out joint.fmu
  joint export --model found/model.toml --format fmu3 --out joint.fmu
  joint export --model found/model.toml --format mjcf --out joint.xml --bus-v 24")]
pub struct Args {
    /// Model file
    #[arg(short = 'm', long, value_name = "TOML")]
    pub model: PathBuf,
    /// What to write
    #[arg(short = 'F', long, value_enum)]
    pub format: Format,
    /// File to write; - is standard output
    #[arg(short = 'o', long, value_name = "F")]
    pub out: PathBuf,
    /// Control period of the drive, microseconds
    #[arg(long, value_name = "N", default_value_t = 50.0, value_parser = super::positive)]
    pub period_us: f64,
    /// What the drive's joint takes as its input
    #[arg(long, value_enum, default_value_t = DriveInput::Voltage)]
    pub input: DriveInput,
    /// Bus voltage, V: the largest that the drive can put on the motor
    #[arg(long, value_name = "V", default_value_t = 48.0, value_parser = super::positive)]
    pub bus_v: f64,
    /// Largest current that the drive's sensor can show, A
    #[arg(long, value_name = "A", default_value_t = 100.0, value_parser = super::positive)]
    pub current_limit_a: f64,
}

/// What is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Parameter block for the drive's flash page
    Block,
    /// The same as a Rust source file, with the SI parameters
    Rust,
    /// Functional mock-up unit, FMI 2.0 for co-simulation
    Fmu,
    /// Functional mock-up unit, FMI 3.0 for co-simulation
    Fmu3,
    /// MuJoCo model
    Mjcf,
    /// URDF: one rigid joint with friction, damping, limits and transmission
    Urdf,
}

/// Which quantity drives the joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DriveInput {
    /// The voltage on the motor
    Voltage,
    /// The measured current
    Current,
}

impl Args {
    fn options(&self) -> DriveOptions {
        DriveOptions {
            period_s: self.period_us * 1e-6,
            drive: match self.input {
                DriveInput::Voltage => Drive::Voltage,
                DriveInput::Current => Drive::Current,
            },
            bus_v: self.bus_v,
            current_limit_a: self.current_limit_a,
        }
    }
}

/// Runs the verb.
///
/// # Errors
/// A model that cannot be read or expressed, or a file that cannot be written.
pub fn run(args: &Args, common: &Common) -> Result<Outcome, Failure> {
    let out = common.file(&args.out)?.apart_from([&args.model])?;
    let model = read_model(&args.model)?;
    let refused = |error| Failure::input(format!("{}: {error}", args.model.display()));
    let (contents, more) = contents(args, &model).map_err(refused)?;
    let bytes = contents.len();
    let path = out.write(contents)?;
    let text = format!("{}: {bytes} bytes of {}{}", path.display(), model.name, more.text);
    let mut json = json!({"out": path, "model": model.name, "bytes": bytes});
    if let (Some(json), Some(crc)) = (json.as_object_mut(), more.crc) {
        json.insert("crc32".to_owned(), format!("{crc:08x}").into());
    }
    if let (Some(json), Some(lost)) = (json.as_object_mut(), more.lost) {
        json.insert("lost".to_owned(), lost.into());
    }
    Ok(Outcome::done(json, text))
}

#[derive(Default)]
struct More {
    crc: Option<u32>,
    lost: Option<Vec<String>>,
    text: String,
}

impl More {
    /// What another tool's model leaves out.
    fn without(lost: Vec<String>) -> Self {
        let text = lost.iter().map(|own| format!("\nleft out: {own}")).collect();
        Self { lost: Some(lost), text, ..Self::default() }
    }
}

fn unit(
    model: &Model,
    options: &DriveOptions,
    version: Version,
) -> Result<(Vec<u8>, More), export::ExportError> {
    Ok((export::fmu::fmu(model, options, version)?, More::default()))
}

fn contents(args: &Args, model: &Model) -> Result<(Vec<u8>, More), export::ExportError> {
    let options = args.options();
    match args.format {
        Format::Block => {
            let bytes = export::block::block(model, &options)?;
            let crc = Block::check(&bytes).ok().map(|block| block.crc);
            let text = crc.map_or(String::new(), |crc| format!(", CRC {crc:08x}"));
            Ok((bytes, More { crc, text, ..More::default() }))
        }
        Format::Rust => {
            export::rust::source(model, &options).map(|text| (text.into_bytes(), More::default()))
        }
        Format::Fmu => unit(model, &options, Version::Fmi2),
        Format::Fmu3 => unit(model, &options, Version::Fmi3),
        Format::Mjcf => {
            let export::mjcf::Mjcf { text: contents, lost } = export::mjcf::mjcf(model, &options);
            Ok((contents.into_bytes(), More::without(lost)))
        }
        Format::Urdf => {
            let export::urdf::Urdf { text: contents, lost } = export::urdf::urdf(model, &options);
            Ok((contents.into_bytes(), More::without(lost)))
        }
    }
}
