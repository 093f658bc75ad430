//! The starting model, value by value, each with where it comes from.

use std::fmt::Write;

use super::Datasheet;

/// Share of the no-load torque that is Coulomb friction: bearings and hysteresis of the iron against
/// eddy currents, of which a datasheet gives the sum.
const COULOMB_SHARE: f64 = 0.5;
/// Deceleration by its own friction of a motor whose datasheet gives no no-load current: 600 to 2,500
/// on small brushless and coreless motors.
const COASTING_RAD_PER_S2: f64 = 1000.0;
/// Excess of the breakaway torque over the Coulomb level, and the speed at which it has gone.
const STRIBECK_SHARE: f64 = 0.3;
const STRIBECK_RAD_PER_S: f64 = 3.0;
/// Angle by which the bristles of a rotor's bearings bend before they slip.
const PRESLIDING_RAD: f64 = 1e-3;
/// Electrical time constant where the inductance is not stated.
const ELECTRICAL_S: f64 = 2e-4;

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

/// A starting model.
#[derive(Clone, Debug, PartialEq)]
pub struct Draft {
    /// Name of the joint.
    pub name: String,
    /// Its tables in the file's order.
    pub tables: Vec<Table>,
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

impl Draft {
    /// The model of a datasheet; `None` where [`Datasheet::missing`] lists something.
    pub fn of(sheet: &Datasheet) -> Option<Self> {
        let (torque_constant, from) = sheet.torque_constant()?;
        let resistance = sheet.terminal_resistance_ohm?;
        let rotor = sheet.rotor_inertia_kg_m2?;
        let inertia = rotor + sheet.gear_inertia_kg_m2.unwrap_or(0.0);
        let mut motor = vec![stated(
            "phase_resistance_ohm",
            resistance / 2.0,
            "half of the terminal resistance: two phases in series",
        )];
        motor.push(match sheet.terminal_inductance_h {
            Some(value) => {
                stated("phase_inductance_h", value / 2.0, "half of the terminal inductance")
            }
            None => assumed(
                "phase_inductance_h",
                resistance / 2.0 * ELECTRICAL_S,
                "an electrical time constant of 0.2 ms",
            ),
        });
        motor.push(stated("torque_constant_nm_per_a", torque_constant, from));
        let whole = |key, value: u32, note: &str, assumed| Line {
            key,
            value: value.to_string(),
            note: note.to_owned(),
            assumed,
        };
        motor.push(match sheet.pole_pairs {
            Some(pairs) => whole("pole_pairs", pairs, "pole pairs", false),
            None => whole("pole_pairs", 1, "only the three-phase motor asks for it", true),
        });
        motor.push(stated(
            "rotor_inertia_kg_m2",
            inertia,
            match sheet.gear_inertia_kg_m2 {
                Some(_) => "rotor inertia and the gear's at the motor shaft",
                None => "rotor inertia",
            },
        ));
        let slip = rotor_slip(sheet, torque_constant, inertia);
        let coulomb_nm = slip.coulomb_nm;
        let mut tables = vec![
            Table { header: "[motor]", lines: motor },
            Table { header: "[motor.friction]", lines: slip.lines() },
        ];
        tables.extend(super::gear::tables(sheet, inertia, coulomb_nm));
        tables.push(Table { header: "[load]", lines: load(sheet) });
        let sensor = sensor(sheet);
        if !sensor.is_empty() {
            tables.push(Table { header: "[sensor]", lines: sensor });
        }
        tables.extend(super::gear::backlash(sheet));
        Some(Self { name: sheet.name.clone(), tables })
    }

    /// As the text of a model file, with where each value comes from.
    pub fn to_toml(&self) -> String {
        let mut text = format!(
            "# A starting model from a datasheet. Refit it on a log before you rely on it: `joint identify`.\nname = {}\n",
            toml_edit::Value::from(self.name.as_str())
        );
        for Table { header, lines } in &self.tables {
            // Writing to a text does not fail.
            let _ = writeln!(text, "\n{header}");
            let pairs: Vec<String> =
                lines.iter().map(|line| format!("{} = {}", line.key, line.value)).collect();
            let width = pairs.iter().map(String::len).max().unwrap_or(0);
            for (line, pair) in lines.iter().zip(pairs) {
                let mark = if line.assumed { "assumed: " } else { "" };
                let _ = writeln!(text, "{pair:width$}  # {mark}{}", line.note);
            }
        }
        text
    }

    /// Keys that are assumed, each with its table.
    pub fn assumed(&self) -> Vec<String> {
        let lines = self.tables.iter().flat_map(|table| {
            table.lines.iter().filter(|line| line.assumed).map(move |line| (table.header, line.key))
        });
        lines.map(|(header, key)| format!("{header} {key}")).collect()
    }
}

/// The rotor's friction from the no-load point.
fn rotor_slip(sheet: &Datasheet, torque_constant: f64, inertia_kg_m2: f64) -> Slip {
    let speed = no_load_speed(sheet, torque_constant);
    let (coulomb_nm, coulomb, viscous) = match (sheet.no_load_current_a, speed) {
        (Some(current), Some(speed)) => {
            let torque = torque_constant * current;
            let coulomb_nm = COULOMB_SHARE * torque;
            let note = format!("half of the no-load torque {} Nm", digits(torque));
            (
                coulomb_nm,
                assumed("coulomb_nm", coulomb_nm, note),
                assumed(
                    "sigma2_nm_s_per_rad",
                    (torque - coulomb_nm) / speed,
                    format!("the other half, at the no-load speed of {} rad/s", digits(speed)),
                ),
            )
        }
        (Some(current), None) => {
            let coulomb_nm = torque_constant * current;
            (
                coulomb_nm,
                stated("coulomb_nm", coulomb_nm, "torque constant times no-load current"),
                assumed("sigma2_nm_s_per_rad", 0.0, "no no-load speed is given"),
            )
        }
        (None, _) => {
            let coulomb_nm = COASTING_RAD_PER_S2 * inertia_kg_m2;
            let note = "no no-load current is given; brakes the rotor at 1000 rad/s²";
            (
                coulomb_nm,
                assumed("coulomb_nm", coulomb_nm, note),
                assumed("sigma2_nm_s_per_rad", 0.0, "no no-load current is given"),
            )
        }
    };
    Slip {
        coulomb,
        coulomb_nm,
        viscous,
        presliding_rad: PRESLIDING_RAD,
        stribeck_rad_per_s: STRIBECK_RAD_PER_S,
        inertia_kg_m2,
    }
}

/// The no-load speed, rad/s: as stated, or what the nominal voltage gives.
pub(super) fn no_load_speed(sheet: &Datasheet, torque_constant: f64) -> Option<f64> {
    sheet.no_load_speed_rad_per_s.or_else(|| {
        let drop = sheet.terminal_resistance_ohm? * sheet.no_load_current_a.unwrap_or(0.0);
        Some((sheet.nominal_voltage_v? - drop) / torque_constant).filter(|speed| *speed > 0.0)
    })
}

fn load(sheet: &Datasheet) -> Vec<Line> {
    let mut lines = vec![match sheet.load_inertia_kg_m2 {
        Some(inertia) => stated("inertia_kg_m2", inertia, "load inertia"),
        None => assumed(
            "inertia_kg_m2",
            0.0,
            "nothing is mounted at the output; a refit leaves a zero as it is",
        ),
    }];
    if let Some(gravity) = sheet.load_gravity_nm {
        lines.push(stated("gravity_nm", gravity, "gravity torque with the load level"));
        lines.push(assumed("gravity_phase_rad", 0.0, "the load hangs straight down at angle 0"));
    }
    lines
}

fn sensor(sheet: &Datasheet) -> Vec<Line> {
    let line = |key, value: Option<f64>, note| value.map(|value| stated(key, value, note));
    [
        line("sample_time_s", sheet.sample_time_s, "sample time"),
        line("motor_encoder_counts_per_rev", sheet.motor_encoder_counts, "after quadrature"),
        line("output_encoder_counts_per_rev", sheet.output_encoder_counts, "after quadrature"),
    ]
    .into_iter()
    .flatten()
    .collect()
}
