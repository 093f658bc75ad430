//! Maps of drives that many have.
//!
//! A preset is a map file like a user's own; docs/import.md says where its names come from and what
//! the drive's numbers mean. Where a signal stands more than once, firmware versions call it
//! differently, and the first name that a recording has counts.

use std::path::Path;

use clap::ValueEnum;

use super::map::Map;
use super::map_file;
use super::settings::Settings;
use crate::fault::InputError;

/// A drive whose recordings are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Preset {
    /// ODrive: property paths of firmware 0.5 and 0.6
    Odrive,
    /// moteus: telemetry channels and register names
    Moteus,
    /// SimpleFOC: the serial monitor
    Simplefoc,
    /// VESC Tool: its CSV log
    Vesc,
}

impl Preset {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Preset::Odrive => "odrive",
            Preset::Moteus => "moteus",
            Preset::Simplefoc => "simplefoc",
            Preset::Vesc => "vesc",
        }
    }

    /// Its map file.
    pub fn text(self) -> &'static str {
        match self {
            Preset::Odrive => include_str!("presets/odrive.toml"),
            Preset::Moteus => include_str!("presets/moteus.toml"),
            Preset::Simplefoc => include_str!("presets/simplefoc.toml"),
            Preset::Vesc => include_str!("presets/vesc.toml"),
        }
    }

    /// Its map and how its recordings are read.
    ///
    /// # Errors
    /// None: a test reads every preset.
    pub fn map(self) -> Result<(Map, Settings), InputError> {
        let (mut map, settings) = map_file::parse(self.text(), Path::new(self.name()))?;
        map.entries.iter_mut().for_each(|entry| entry.optional = true);
        Ok((map, settings))
    }
}

#[cfg(test)]
mod tests {
    use super::super::signal::Signal;
    use super::*;

    #[test]
    fn every_preset_is_a_map_that_finds_the_rotor_and_an_input() {
        for preset in Preset::value_variants() {
            let (map, _) = preset.map().unwrap_or_else(|error| panic!("{error}"));
            for signal in [Signal::Time, Signal::Motor, Signal::Current] {
                assert!(map.entries.iter().any(|entry| entry.signal == signal), "{preset:?}");
            }
        }
    }

    /// √3/2 and √3, the factors from peak phase values that docs/import.md derives.
    #[test]
    fn phase_values_become_dc_equivalents_by_the_documented_factors() {
        for preset in Preset::value_variants() {
            for entry in preset.map().unwrap().0.entries {
                let Some(scaling) = entry.scaling else { continue };
                let milli = if scaling.text().starts_with('m') { 1e-3 } else { 1.0 };
                let expected = match entry.signal {
                    Signal::Voltage => 3.0_f64.sqrt(),
                    Signal::Current => 3.0_f64.sqrt() / 2.0 * milli,
                    _ => continue,
                };
                let factor = scaling.si(1.0);
                // One rounding each of the literal, the product and the division.
                assert!(
                    (factor / expected - 1.0).abs() < 4.0 * f64::EPSILON,
                    "{preset:?}: {factor}"
                );
            }
        }
    }
}
