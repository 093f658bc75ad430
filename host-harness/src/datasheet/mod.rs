//! A starting model from a datasheet.
//!
//! A datasheet states terminals where the model has phases, rpm and g cm² where it has SI units, a
//! no-load point where it has friction, and nothing at all of stiffness and bristles. What is
//! stated is converted, what is not is assumed by a rule of thumb and marked so in the file: a
//! model without friction, or with half its resistance, is answered with effects that are not there.

pub mod ask;
mod checks;
mod draft;
mod gear;
pub mod quantity;
mod table;

pub use checks::checks;
pub use draft::{Draft, Line, Table};

/// What a datasheet states, in SI units. Gears are from the motor on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Datasheet {
    /// Name of the joint.
    pub name: String,
    /// Resistance between two terminals, ohm.
    pub terminal_resistance_ohm: Option<f64>,
    /// Inductance between two terminals, henry.
    pub terminal_inductance_h: Option<f64>,
    /// Torque constant, Nm/A.
    pub torque_constant_nm_per_a: Option<f64>,
    /// Speed constant, rad/s/V.
    pub speed_constant_rad_per_s_v: Option<f64>,
    /// Rotor inertia, kg m².
    pub rotor_inertia_kg_m2: Option<f64>,
    /// No-load current, A.
    pub no_load_current_a: Option<f64>,
    /// No-load speed, rad/s.
    pub no_load_speed_rad_per_s: Option<f64>,
    /// Nominal voltage, V.
    pub nominal_voltage_v: Option<f64>,
    /// Mechanical time constant, s.
    pub mechanical_time_constant_s: Option<f64>,
    /// Pole pairs.
    pub pole_pairs: Option<u32>,
    /// Whether the drive is field-oriented, and the constants those of block commutation.
    pub field_oriented: bool,
    /// Ratio of each elastic stage, input over output turns.
    pub gears: Vec<f64>,
    /// Number of meshes in a row in the whole gear.
    pub gear_meshes: Option<u32>,
    /// Largest efficiency of the whole gear.
    pub gear_efficiency: Option<f64>,
    /// Backlash at the output, rad.
    pub gear_backlash_rad: Option<f64>,
    /// Inertia of the gear at the motor shaft, kg m².
    pub gear_inertia_kg_m2: Option<f64>,
    /// Continuous torque at the output, Nm.
    pub gear_torque_nm: Option<f64>,
    /// Torsional stiffness at the output, Nm/rad.
    pub gear_stiffness_nm_per_rad: Option<f64>,
    /// Inertia at the output, kg m².
    pub load_inertia_kg_m2: Option<f64>,
    /// Amplitude of the gravity torque at the output, Nm.
    pub load_gravity_nm: Option<f64>,
    /// Counts per turn of the motor's encoder.
    pub motor_encoder_counts: Option<f64>,
    /// Counts per turn of the output's encoder.
    pub output_encoder_counts: Option<f64>,
    /// Sample time of the logs, s.
    pub sample_time_s: Option<f64>,
}

impl Datasheet {
    /// Flags of what a model cannot do without, with what they are; empty where all is there.
    pub fn missing(&self) -> Vec<(&'static str, &'static str)> {
        let constant = self.torque_constant_nm_per_a.or(self.speed_constant_rad_per_s_v);
        let lacks = [
            (
                self.terminal_resistance_ohm.is_none(),
                ("--terminal-resistance", "resistance between two terminals, ohm"),
            ),
            (
                constant.is_none(),
                ("--torque-constant", "torque constant, mNm/A (or --speed-constant, rpm/V)"),
            ),
            (self.rotor_inertia_kg_m2.is_none(), ("--rotor-inertia", "rotor inertia, g cm²")),
        ];
        lacks.into_iter().filter(|(lacks, _)| *lacks).map(|(_, what)| what).collect()
    }

    /// The model's torque constant, Nm/A, with where it comes from.
    pub fn torque_constant(&self) -> Option<(f64, String)> {
        let (value, from) = match (self.torque_constant_nm_per_a, self.speed_constant_rad_per_s_v) {
            (Some(constant), _) => (constant, "torque constant".to_owned()),
            (None, Some(constant)) => (1.0 / constant, "one over the speed constant".to_owned()),
            (None, None) => return None,
        };
        // The mean over a sixth of a turn of a sine about its peak is 3/pi of the peak.
        Some(match self.field_oriented {
            true => (
                value * std::f64::consts::FRAC_PI_3,
                format!("{from}, times pi/3 for field-oriented control"),
            ),
            false => (value, from),
        })
    }
}
