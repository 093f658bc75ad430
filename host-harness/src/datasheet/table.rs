//! Lines and tables of a starting model, and the friction that each inertia has.

use super::Datasheet;

/// Excess of the breakaway torque over the Coulomb level.
const STRIBECK_SHARE: f64 = 0.3;

/// A line of the model file.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Its key.
    pub key: &'static str,
    /// Its value as TOML.
    pub value: String,
    /// Where it comes from.
    pub note: String,
    /// Whether it is assumed instead of stated.
    pub assumed: bool,
}

/// A table of the model file.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Its header, `[motor]`.
    pub header: &'static str,
    /// Its lines.
    pub lines: Vec<Line>,
}

/// A line that a datasheet states.
pub(super) fn stated(key: &'static str, value: f64, note: impl Into<String>) -> Line {
    Line { key, value: digits(value), note: note.into(), assumed: false }
}

/// A line that a rule of thumb gives.
pub(super) fn assumed(key: &'static str, value: f64, note: impl Into<String>) -> Line {
    Line { key, value: digits(value), note: note.into(), assumed: true }
}

/// Six digits: no datasheet has more.
pub(super) fn digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    format!("{rounded:?}")
}

/// Friction on one inertia, with the bristles that it asks for.
pub(super) struct Slip {
    pub(super) coulomb: Line,
    pub(super) coulomb_nm: f64,
    pub(super) viscous: Line,
    pub(super) presliding_rad: f64,
    pub(super) stribeck_rad_per_s: f64,
    pub(super) inertia_kg_m2: f64,
}

impl Slip {
    pub(super) fn lines(self) -> Vec<Line> {
        let breakaway = self.coulomb_nm * (1.0 + STRIBECK_SHARE);
        let sigma0 = breakaway / self.presliding_rad;
        let mrad = self.presliding_rad * 1e3;
        vec![
            self.coulomb,
            self.viscous,
            assumed(
                "stribeck_nm",
                STRIBECK_SHARE * self.coulomb_nm,
                format!("{STRIBECK_SHARE} of the Coulomb level"),
            ),
            assumed("stribeck_velocity_rad_per_s", self.stribeck_rad_per_s, "usual for bearings"),
            assumed("sigma0_nm_per_rad", sigma0, format!("breaks away after {mrad} mrad")),
            assumed(
                "sigma1_nm_s_per_rad",
                (sigma0 * self.inertia_kg_m2).sqrt(),
                "root of sigma0 times the inertia: damping ratio 0.5 in stick",
            ),
        ]
    }
}

/// The no-load speed, rad/s: as stated, or what the nominal voltage gives.
pub(super) fn no_load_speed(sheet: &Datasheet, torque_constant: f64) -> Option<f64> {
    sheet.no_load_speed_rad_per_s.or_else(|| {
        let drop = sheet.terminal_resistance_ohm? * sheet.no_load_current_a.unwrap_or(0.0);
        Some((sheet.nominal_voltage_v? - drop) / torque_constant).filter(|speed| *speed > 0.0)
    })
}
