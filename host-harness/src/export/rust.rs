//! The parameters as a Rust source file, for firmware that is built with its joint.

use std::fmt::{self, Write};

use firmware::block::Block;
use joint_core::joint::Drive;

use super::{DriveOptions, ExportError, block, identifier};
use crate::model::Model;
use crate::observe::run::settings;

/// A module with the SI parameters, the observer built from them, and the block's bytes.
///
/// # Errors
/// The joint cannot run in the firmware with these options.
pub fn source(model: &Model, options: &DriveOptions) -> Result<String, ExportError> {
    let bytes = block::block(model, options)?;
    let design = match model.stages.len() {
        0 => design::<0>(model, options),
        1 => design::<1>(model, options),
        2 => design::<2>(model, options),
        3 => design::<3>(model, options),
        more => Err(ExportError::Stages(more)),
    }?;
    let mut text = String::new();
    // Writing into a string does not fail.
    let _ = head(&mut text, model, options);
    let _ = observer(&mut text, model, options, &design);
    let _ = contents(&mut text, &bytes);
    Ok(text)
}

fn head(text: &mut String, model: &Model, options: &DriveOptions) -> fmt::Result {
    let input = match options.drive {
        Drive::Voltage => "voltage",
        Drive::Current => "current",
    };
    let (name, stages) = (identifier(model), model.stages.len());
    let row = if stages == 0 { "" } else { ", StageRow" };
    let effects = if model.effects.is_empty() {
        ""
    } else {
        "use joint_core::effect::{EffectParameters, EffectSet, Kind, Knots};\n"
    };
    let location = if effects.is_empty() { "" } else { "Location, " };
    write!(
        text,
        "//! The joint `{name}`, written by `joint export --format rust`: a control period of {} µs\n\
         //! with the {input} as input. It needs joint-core and nothing else. Do not edit.\n\n\
         {effects}use joint_core::joint::{{Drive, Joint, Settings}};\n\
         use joint_core::observer::{{Column, Design, Gains, Level, Observer, Spread{row}}};\n\
         use joint_core::params::{{Friction, Load, {location}Motor, ParameterError, Stage}};\n\n",
        (options.period_s * 1e9).round() / 1e3,
    )?;
    let sensing = block::sensing(model, options);
    write!(
        text,
        "/// Control period, s.\npub const PERIOD_S: f64 = {:?};\n\
         /// What the joint takes as its input.\npub const DRIVE: Drive = Drive::{:?};\n\
         /// Counts in a turn of the motor encoder.\npub const MOTOR_COUNTS: i32 = {};\n\
         /// Counts in a turn of the output encoder, zero where there is none.\n\
         pub const OUTPUT_COUNTS: i32 = {};\n\
         /// The motor, in SI units.\npub const MOTOR: Motor = {:?};\n\
         /// The gear stages, in SI units.\npub const STAGES: [Stage; {stages}] = {:?};\n\
         /// The load, in SI units.\npub const LOAD: Load = {:?};\n",
        options.period_s,
        options.drive,
        sensing.motor_counts_per_turn,
        sensing.output_counts_per_turn,
        model.motor,
        model.stages,
        model.load,
    )
}

/// The observer's design as source, which is how it is printed.
fn design<const N: usize>(model: &Model, options: &DriveOptions) -> Result<String, ExportError> {
    let text = format!("{:?}", block::designed::<N>(model, options)?);
    Ok(text
        .replace("inf", "f64::INFINITY")
        .replace("}], [Column", "}],\n    [Column")
        .replace("}, Spread", "},\n    Spread"))
}

fn observer(text: &mut String, model: &Model, options: &DriveOptions, design: &str) -> fmt::Result {
    let stages = model.stages.len();
    let effects = &model.effects;
    let (own, given) = match effects.is_empty() {
        true => (format!("f32, {stages}"), ""),
        false => (format!("f32, {stages}, EffectSet<f32>"), " effects: &EFFECTS,"),
    };
    if !effects.is_empty() {
        write!(
            text,
            "/// What the plain joint misses.\npub const EFFECTS: [EffectParameters; {}] = [\n",
            effects.len()
        )?;
        for effect in effects {
            let (kind, place, values) = (effect.kind, effect.location, effect.values);
            let table = match (effect.table.forward(), effect.table.backward()) {
                ([], _) => "Knots::NONE".to_owned(),
                (forward, backward) => format!(
                    "match Knots::new(&{forward:?}, &{backward:?}) {{ Some(knots) => knots, None => \
                     Knots::NONE }}"
                ),
            };
            writeln!(
                text,
                "    EffectParameters {{ kind: Kind::{kind:?}, location: Location::{place:?}, \
                 values: {values:?}, table: {table} }},"
            )?;
        }
        text.push_str("];\n");
    }
    let micro_steps = settings(model, options.drive, options.period_s).micro_steps;
    write!(
        text,
        "/// The observer's gains, in SI units.\npub const DESIGN: Design<{stages}> = {design};\n\
         /// The observer of this joint.\npub type OwnObserver = Observer<{own}>;\n\n\
         /// Builds the observer: once, at the start, since it takes double precision.\n///\n\
         /// # Errors\n/// None with these parameters; with others, what the equations cannot take.\n\
         pub fn observer() -> Result<OwnObserver, ParameterError> {{\n    \
         let settings = Settings {{ micro_steps: {micro_steps:?},{given} \
         ..Settings::new(DRIVE, PERIOD_S) }};\n    \
         let joint = Joint::<{own}>::new(&MOTOR, &STAGES, &LOAD, &settings)?;\n    \
         let gains = Gains::new(&DESIGN, &MOTOR, &STAGES, DRIVE, PERIOD_S);\n    \
         Ok(Observer {{ joint, gains }})\n}}\n\n"
    )
}

fn contents(text: &mut String, bytes: &[u8]) -> fmt::Result {
    let crc = Block::check(bytes).map_or(0, |block| block.crc);
    write!(
        text,
        "/// The same as a parameter block: for `firmware::session::Session::start`, or \
         `joint_init` of the C library.\npub const BLOCK: [u8; {}] = [",
        bytes.len()
    )?;
    for (k, byte) in bytes.iter().enumerate() {
        write!(text, "{}{byte:#04x},", if k % 16 == 0 { "\n    " } else { " " })?;
    }
    writeln!(text, "\n];\n/// Checksum of the block.\npub const BLOCK_CRC: u32 = {crc:#010x};")
}
