//! `joint new`: a starting model from a datasheet.

use std::cell::RefCell;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use serde_json::json;

use super::{Common, Failure, Outcome};
use crate::datasheet::ask::{Question, ask};
use crate::datasheet::{Datasheet, Draft, checks, quantity};
use crate::model::Model;

/// Make a starting model from a datasheet's numbers
///
/// Numbers are in the datasheet's own units, or carry another one: 181, 181gcm2, 1.81e-5kgm2. Terminal values are
/// halved to one phase, no-load current and speed become friction. What a datasheet does not state, such as stiffness
/// and bristles, is assumed by a rule of thumb and marked `# assumed:` in the file. Numbers that cannot belong
/// to one motor are told. On a terminal, what is missing is asked for. docs/import.md has the rules.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  joint new --terminal-resistance 1.25 --terminal-inductance 0.56 --torque-constant 43.6 --speed-constant 219 \\
    --rotor-inertia 24.2 --no-load-current 145 --no-load-speed 5150 --nominal-voltage 24 \\
    --gear 624/35 --gear-efficiency 75 --gear-backlash 1.0 --motor-encoder 4096 --out arm.toml
  joint new --out arm.toml")]
pub struct Args {
    /// Name of the joint; the file's where left out
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
    /// Resistance between two terminals, ohm
    #[arg(long, value_name = "OHM", value_parser = |text: &str| quantity::RESISTANCE.read(text))]
    pub terminal_resistance: Option<f64>,
    /// Inductance between two terminals, mH
    #[arg(long, value_name = "MH", value_parser = |text: &str| quantity::INDUCTANCE.read(text))]
    pub terminal_inductance: Option<f64>,
    /// Torque constant, mNm/A
    #[arg(long, value_name = "MNM/A", value_parser = |text: &str| quantity::TORQUE_CONSTANT.read(text))]
    pub torque_constant: Option<f64>,
    /// Speed constant, rpm/V
    #[arg(long, value_name = "RPM/V", value_parser = |text: &str| quantity::SPEED_CONSTANT.read(text))]
    pub speed_constant: Option<f64>,
    /// Rotor inertia, g cm²
    #[arg(long, value_name = "GCM2", value_parser = |text: &str| quantity::INERTIA.read(text))]
    pub rotor_inertia: Option<f64>,
    /// No-load current, mA
    #[arg(long, value_name = "MA", value_parser = |text: &str| quantity::CURRENT.read(text))]
    pub no_load_current: Option<f64>,
    /// No-load speed, rpm
    #[arg(long, value_name = "RPM", value_parser = |text: &str| quantity::SPEED.read(text))]
    pub no_load_speed: Option<f64>,
    /// Nominal voltage, V
    #[arg(long, value_name = "V", value_parser = |text: &str| quantity::VOLTAGE.read(text))]
    pub nominal_voltage: Option<f64>,
    /// Mechanical time constant, ms: a check alone
    #[arg(long, value_name = "MS", value_parser = |text: &str| quantity::TIME.read(text))]
    pub mechanical_time_constant: Option<f64>,
    /// Pole pairs
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub pole_pairs: Option<u32>,
    /// The drive is field-oriented, and the constants are those of block commutation: k_t grows by pi/3
    #[arg(long)]
    pub field_oriented: bool,
    /// Gear ratio, input over output turns: 16, 624/35, 4.8:1; again for each further elastic stage
    #[arg(long, value_name = "RATIO", allow_negative_numbers = true, value_parser = quantity::ratio)]
    pub gear: Vec<f64>,
    /// Number of meshes in a row in the whole gear, from which an efficiency is assumed
    #[arg(long, value_name = "N", requires = "gear", value_parser = clap::value_parser!(u32).range(1..=9))]
    pub gear_stages: Option<u32>,
    /// Largest efficiency of the whole gear, percent
    #[arg(long, value_name = "PERCENT", requires = "gear", value_parser = quantity::efficiency)]
    pub gear_efficiency: Option<f64>,
    /// Backlash at the output, degrees
    #[arg(long, value_name = "DEG", requires = "gear", value_parser = |text: &str| quantity::ANGLE.read(text))]
    pub gear_backlash: Option<f64>,
    /// Inertia of the gear at the motor shaft, g cm²
    #[arg(long, value_name = "GCM2", requires = "gear", value_parser = |text: &str| quantity::INERTIA.read(text))]
    pub gear_inertia: Option<f64>,
    /// Continuous torque at the output, Nm
    #[arg(long, value_name = "NM", requires = "gear", value_parser = |text: &str| quantity::TORQUE.read(text))]
    pub gear_torque: Option<f64>,
    /// Torsional stiffness at the output, Nm/rad
    #[arg(long, value_name = "NM/RAD", requires = "gear", value_parser = |text: &str| quantity::STIFFNESS.read(text))]
    pub gear_stiffness: Option<f64>,
    /// Inertia at the output, kg m²
    #[arg(long, value_name = "KGM2", value_parser = |text: &str| quantity::LOAD_INERTIA.read(text))]
    pub load_inertia: Option<f64>,
    /// Gravity torque of a level load at the output, Nm
    #[arg(long, value_name = "NM", value_parser = |text: &str| quantity::TORQUE.read(text))]
    pub load_gravity: Option<f64>,
    /// Counts per turn of the motor's encoder after quadrature, or `1024lines`
    #[arg(long, value_name = "COUNTS", value_parser = |text: &str| quantity::COUNTS.read(text))]
    pub motor_encoder: Option<f64>,
    /// Counts per turn of the output's encoder after quadrature
    #[arg(long, value_name = "COUNTS", value_parser = |text: &str| quantity::COUNTS.read(text))]
    pub output_encoder: Option<f64>,
    /// Sample time of the logs, ms
    #[arg(long, value_name = "MS", value_parser = |text: &str| quantity::TIME.read(text))]
    pub sample_time: Option<f64>,
    /// Model file to write
    #[arg(short = 'o', long, value_name = "TOML")]
    pub out: PathBuf,
}

impl Args {
    fn sheet(&self) -> Datasheet {
        let stem = self.out.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Datasheet {
            name: self.name.clone().unwrap_or(stem),
            terminal_resistance_ohm: self.terminal_resistance,
            terminal_inductance_h: self.terminal_inductance,
            torque_constant_nm_per_a: self.torque_constant,
            speed_constant_rad_per_s_v: self.speed_constant,
            rotor_inertia_kg_m2: self.rotor_inertia,
            no_load_current_a: self.no_load_current,
            no_load_speed_rad_per_s: self.no_load_speed,
            nominal_voltage_v: self.nominal_voltage,
            mechanical_time_constant_s: self.mechanical_time_constant,
            pole_pairs: self.pole_pairs,
            field_oriented: self.field_oriented,
            gears: self.gear.clone(),
            gear_meshes: self.gear_stages,
            gear_efficiency: self.gear_efficiency,
            gear_backlash_rad: self.gear_backlash,
            gear_inertia_kg_m2: self.gear_inertia,
            gear_torque_nm: self.gear_torque,
            gear_stiffness_nm_per_rad: self.gear_stiffness,
            load_inertia_kg_m2: self.load_inertia,
            load_gravity_nm: self.load_gravity,
            motor_encoder_counts: self.motor_encoder,
            output_encoder_counts: self.output_encoder,
            sample_time_s: self.sample_time,
        }
    }
}

/// Runs the verb.
///
/// # Errors
/// A number that a model needs is missing, or the file cannot be written.
pub fn run(args: &Args, common: &Common) -> Result<Outcome, Failure> {
    let out = common.file(&args.out)?;
    let mut sheet = args.sheet();
    if !sheet.missing().is_empty() && std::io::stdin().is_terminal() {
        questions(&mut sheet)
            .map_err(|error| Failure::input(format!("the questions ended: {error}")))?;
    }
    let (draft, text) = written(&sheet, &args.out)?;
    let path = out.write(&text)?;
    let warnings = checks(&sheet);
    for warning in &warnings {
        eprintln!("warning: {}: {warning}", path.display());
    }
    let assumed = draft.assumed();
    let told = format!(
        "{}: a starting model of {}; {} values are assumed and marked so in the file",
        path.display(),
        draft.name,
        assumed.len()
    );
    let json = json!({
        "out": path, "model": draft.name, "assumed": assumed, "warnings": warnings,
    });
    Ok(Outcome::done(json, told))
}

/// The model and its text, which the model's own reader has taken.
fn written(sheet: &Datasheet, path: &Path) -> Result<(Draft, String), Failure> {
    let missing: Vec<String> =
        sheet.missing().iter().map(|(flag, what)| format!("\n  {flag}  {what}")).collect();
    let draft = Draft::of(sheet).ok_or_else(|| {
        Failure::input(format!(
            "a model needs more of the datasheet:{}\n  help: give these flags; on a terminal they are asked for",
            missing.concat()
        ))
    })?;
    let text = draft.to_toml();
    Model::parse(&text, path)?;
    Ok((draft, text))
}

/// Asks for what was not given: first what a model needs, then what spares it a rule of thumb.
fn questions(sheet: &mut Datasheet) -> std::io::Result<()> {
    let given = sheet.clone();
    let sheet = RefCell::new(sheet);
    let mut list: Vec<Question<'_>> = Vec::new();
    if given.terminal_resistance_ohm.is_none() {
        let take = |answer: &str| {
            let value = quantity::RESISTANCE.read(answer)?;
            sheet.borrow_mut().terminal_resistance_ohm = Some(value);
            Ok(())
        };
        let what = "Resistance between two terminals, ohm";
        list.push(Question { what, needed: true, take: Box::new(take) });
    }
    if given.torque_constant_nm_per_a.or(given.speed_constant_rad_per_s_v).is_none() {
        let what = "Torque constant, mNm/A, or speed constant with its unit, as 219rpm/V";
        let take = Box::new(|answer: &str| constant(&sheet, answer));
        list.push(Question { what, needed: true, take });
    }
    {
        let mut add = |what, needed, kind: quantity::Kind, set: fn(&mut Datasheet, f64)| {
            let sheet = &sheet;
            let take = Box::new(move |answer: &str| {
                kind.read(answer).map(|value| set(&mut sheet.borrow_mut(), value))
            });
            list.push(Question { what, needed, take });
        };
        if given.rotor_inertia_kg_m2.is_none() {
            let what = "Rotor inertia, g cm²";
            add(what, true, quantity::INERTIA, |s, v| s.rotor_inertia_kg_m2 = Some(v));
        }
        if given.terminal_inductance_h.is_none() {
            let what = "Inductance between two terminals, mH";
            add(what, false, quantity::INDUCTANCE, |s, v| s.terminal_inductance_h = Some(v));
        }
        if given.no_load_current_a.is_none() {
            let what = "No-load current, mA";
            add(what, false, quantity::CURRENT, |s, v| s.no_load_current_a = Some(v));
        }
        if given.no_load_speed_rad_per_s.is_none() {
            let what = "No-load speed, rpm";
            add(what, false, quantity::SPEED, |s, v| s.no_load_speed_rad_per_s = Some(v));
        }
        if given.motor_encoder_counts.is_none() {
            let what = "Counts per turn of the motor's encoder, after quadrature";
            add(what, false, quantity::COUNTS, |s, v| s.motor_encoder_counts = Some(v));
        }
        if given.load_inertia_kg_m2.is_none() {
            let what = "Inertia at the output, kg m²";
            add(what, false, quantity::LOAD_INERTIA, |s, v| s.load_inertia_kg_m2 = Some(v));
        }
    }
    if given.gears.is_empty() {
        list.extend(gear_questions(&sheet));
    }
    let (mut input, mut output) = (std::io::stdin().lock(), std::io::stderr());
    ask(&mut list, &mut input, &mut output)
}

/// Either constant of the motor; the unit tells which.
fn constant(sheet: &RefCell<&mut Datasheet>, answer: &str) -> Result<(), String> {
    match answer.contains("/V") {
        true => {
            let speed = quantity::SPEED_CONSTANT.read(answer)?;
            sheet.borrow_mut().speed_constant_rad_per_s_v = Some(speed);
        }
        false => {
            let torque = quantity::TORQUE_CONSTANT.read(answer)?;
            sheet.borrow_mut().torque_constant_nm_per_a = Some(torque);
        }
    }
    Ok(())
}

fn gear_questions<'a>(sheet: &'a RefCell<&'a mut Datasheet>) -> Vec<Question<'a>> {
    let question = |what, take| Question { what, needed: false, take };
    let is_geared = || match sheet.borrow().gears.is_empty() {
        true => Err("there is no gear: leave it empty".to_owned()),
        false => Ok(()),
    };
    vec![
        question(
            "Gear ratio, as 16 or 624/35; nothing for a direct drive",
            Box::new(|answer: &str| {
                quantity::ratio(answer).map(|ratio| sheet.borrow_mut().gears = vec![ratio])
            }),
        ),
        question(
            "Largest efficiency of the gear, percent",
            Box::new(move |answer: &str| {
                is_geared()?;
                let share = quantity::efficiency(answer)?;
                sheet.borrow_mut().gear_efficiency = Some(share);
                Ok(())
            }),
        ),
        question(
            "Backlash at the output, degrees",
            Box::new(move |answer: &str| {
                is_geared()?;
                let width = quantity::ANGLE.read(answer)?;
                sheet.borrow_mut().gear_backlash_rad = Some(width);
                Ok(())
            }),
        ),
    ]
}
