//! What a run of a scenario leaves: speeds and angles of every level, seen from the motor.

/// Interval of the samples kept, s.
pub const SAMPLE_S: f64 = 10e-6;

/// A run, sampled; levels are the motor, then the stages, all on the motor's side.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// Time, s.
    pub time_s: Vec<f64>,
    /// The speed asked for, rad/s.
    pub reference: Vec<f64>,
    /// Load at the output, Nm.
    pub load_nm: Vec<f64>,
    /// Speed of each level, rad/s.
    pub speed: Vec<Vec<f64>>,
    /// Angle of each level, rad.
    pub angle: Vec<Vec<f64>>,
    /// Current of the conducting phases, A; empty where the motor is prescribed.
    pub current_a: Vec<f64>,
    /// Work from the bus and heat in the winding so far, J; empty where the motor is prescribed.
    pub bus_work_j: Vec<f64>,
    /// Heat in the winding so far, J.
    pub winding_heat_j: Vec<f64>,
    /// Work of the motor's torque on the rotor so far, J.
    pub shaft_work_j: Vec<f64>,
}

impl Trace {
    /// An empty trace of so many levels.
    pub fn new(levels: usize) -> Self {
        let series = vec![Vec::new(); levels];
        Self { speed: series.clone(), angle: series, ..Self::default() }
    }

    /// Difference of the first and the last level's angle, rad.
    pub fn windup(&self) -> Vec<f64> {
        match (self.angle.first(), self.angle.last()) {
            (Some(first), Some(last)) => first.iter().zip(last).map(|(a, b)| a - b).collect(),
            _ => Vec::new(),
        }
    }

    /// Speed of the last level.
    pub fn output(&self) -> &[f64] {
        self.speed.last().map_or(&[], Vec::as_slice)
    }

    /// The samples from one time to another.
    pub fn between(&self, from: f64, to: f64) -> std::ops::Range<usize> {
        let at = |t: f64| self.time_s.partition_point(|time| *time < t - 1e-9);
        at(from)..at(to)
    }
}

/// Largest magnitude.
pub fn peak(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| value.abs().max(most))
}
