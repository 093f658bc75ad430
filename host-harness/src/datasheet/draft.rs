//! The starting model, value by value, each with where it comes from.

use std::fmt::Write;

use super::Datasheet;
pub use super::table::{Line, Table};
use super::table::{Slip, assumed, digits, no_load_speed, stated};

/// Share of the no-load torque that is Coulomb friction: bearings and hysteresis of the iron against
/// eddy currents, of which a datasheet gives the sum.
const COULOMB_SHARE: f64 = 0.5;
/// Deceleration by its own friction of a motor whose datasheet gives no no-load current: 600 to 2,500
/// on small brushless and coreless motors.
const COASTING_RAD_PER_S2: f64 = 1000.0;
/// Speed at which the excess of the breakaway torque has gone.
const STRIBECK_RAD_PER_S: f64 = 3.0;
/// Angle by which the bristles of a rotor's bearings bend before they slip.
const PRESLIDING_RAD: f64 = 1e-3;
/// Electrical time constant where the inductance is not stated.
const ELECTRICAL_S: f64 = 2e-4;

/// A starting model.
#[derive(Clone, Debug, PartialEq)]
pub struct Draft {
    /// Name of the joint.
    pub name: String,
    /// Its tables in the file's order.
    pub tables: Vec<Table>,
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
