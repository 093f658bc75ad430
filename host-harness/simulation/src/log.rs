//! A log: what was put in and what was measured, sample by sample.
//!
//! Every log that enters or leaves the harness passes here, so that what a column is called, what
//! it means and what a missing value looks like is said once. docs/log-format.md describes the
//! file.

mod read;
mod table;
mod write;

pub use read::{Loaded, Need, line_of_row};
pub use read::{MOST_BYTES, unpacked};
pub use write::{compressed, write_columns};

/// Columns of a log. A missing value is NaN; a missing column is `None`. `time_s` rises strictly
/// and may be uneven.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Log {
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Voltage on the two conducting phases, V, held until the next sample.
    pub voltage_v: Option<Vec<f64>>,
    /// Motor current, A.
    pub current_a: Option<Vec<f64>>,
    /// Rotor angle, rad.
    pub motor_angle_rad: Vec<f64>,
    /// Angle behind the last stage, rad.
    pub output_angle_rad: Option<Vec<f64>>,
    /// Known load at the output, Nm, positive against positive motion.
    pub load_torque_nm: Option<Vec<f64>>,
    /// Bus voltage, V.
    pub bus_v: Option<Vec<f64>>,
    /// Temperature, °C.
    pub temperature_c: Option<Vec<f64>>,
    /// Reference angle, rad.
    pub reference_angle_rad: Option<Vec<f64>>,
}

/// Name of the time column.
pub const TIME: &str = "t_s";
/// Name of the voltage column.
pub const VOLTAGE: &str = "u_v";
/// Name of the current column.
pub const CURRENT: &str = "i_a";
/// Name of the rotor angle's column.
pub const MOTOR_ANGLE: &str = "motor_angle_rad";
/// Name of the output angle's column.
pub const OUTPUT_ANGLE: &str = "output_angle_rad";

/// Every column that a log may have.
pub const KNOWN: [&str; 9] = [
    TIME,
    VOLTAGE,
    CURRENT,
    MOTOR_ANGLE,
    OUTPUT_ANGLE,
    "load_torque_nm",
    "bus_v",
    "temperature_c",
    "reference_angle_rad",
];

impl Log {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// The samples that are marked, of every column; a mark for each sample.
    pub fn only(&self, marked: &[bool]) -> Self {
        let of = |values: &[f64]| -> Vec<f64> {
            values.iter().zip(marked).filter(|(_, marked)| **marked).map(|(v, _)| *v).collect()
        };
        let column = |values: &Option<Vec<f64>>| values.as_deref().map(of);
        Self {
            time_s: of(&self.time_s),
            voltage_v: column(&self.voltage_v),
            current_a: column(&self.current_a),
            motor_angle_rad: of(&self.motor_angle_rad),
            output_angle_rad: column(&self.output_angle_rad),
            load_torque_nm: column(&self.load_torque_nm),
            bus_v: column(&self.bus_v),
            temperature_c: column(&self.temperature_c),
            reference_angle_rad: column(&self.reference_angle_rad),
        }
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// The columns that are there, by name, in the order in which a log is written.
    pub fn columns(&self) -> Vec<(&'static str, &[f64])> {
        [
            Some((TIME, self.time_s.as_slice())),
            named(VOLTAGE, &self.voltage_v),
            named(CURRENT, &self.current_a),
            Some((MOTOR_ANGLE, self.motor_angle_rad.as_slice())),
            named(OUTPUT_ANGLE, &self.output_angle_rad),
            named("load_torque_nm", &self.load_torque_nm),
            named("bus_v", &self.bus_v),
            named("temperature_c", &self.temperature_c),
            named("reference_angle_rad", &self.reference_angle_rad),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

fn named<'a>(
    name: &'static str,
    values: &'a Option<Vec<f64>>,
) -> Option<(&'static str, &'a [f64])> {
    values.as_deref().map(|values| (name, values))
}
