//! A log: what was put in and what was measured, sample by sample.

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
