//! What the host knows of a kind of effect beside its law.

use joint_core::effect::EffectParameters;
use joint_core::params::Location;
use rand::{Rng, RngExt};

use super::Scene;
use super::hypothesis::Hypothesis;
use super::rules::Rules;

/// One kind of effect, as discovery, benchmark and report know it.
#[derive(Clone, Copy, Debug)]
pub struct EffectCard {
    /// What it is, in half a sentence.
    pub words: &'static str,
    /// The residual in which it shows.
    pub residual: Residual,
    /// What that residual varies with.
    pub axis: Axis,
    /// The experiment that tells it from what looks like it, as an instruction.
    pub experiment: &'static str,
    /// The key of a parameter that it shares its size with: only the size over its square shows.
    pub reference: Option<&'static str>,
    /// What checks ask of it alone.
    pub rules: Rules,
    /// How the blind benchmark hides it.
    pub benchmark: Benchmark,
    /// Proposes hypotheses.
    pub propose: fn(&Scene<'_>) -> Vec<Hypothesis>,
}

/// What an equation of the joint misses without an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Residual {
    /// Voltage in the winding's equation.
    Voltage,
    /// Torque on the rotor or on a mass behind it.
    Torque,
    /// Wind-up of a stage: its output's angle less its input's over the reduction.
    Windup,
    /// Measured less true current.
    MeasuredCurrent,
    /// Measured less true angle.
    MeasuredAngle,
}

impl Residual {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Residual::Voltage => "the voltage that the winding misses",
            Residual::Torque => "the torque that is missing",
            Residual::Windup => "the wind-up that the stage's spring does not explain",
            Residual::MeasuredCurrent => "the error of the measured current",
            Residual::MeasuredAngle => "the error of the measured angle",
        }
    }
}

/// What a residual is drawn against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Angle of the rotor, rad.
    MotorAngle,
    /// Speed of the rotor, rad/s.
    MotorSpeed,
    /// Current, A.
    Current,
    /// Time, s.
    Time,
    /// Angle behind the last stage, rad; of the rotor where there is no stage.
    OutputAngle,
    /// Wind-up of the last stage, rad at its output.
    OutputWindup,
}

impl Axis {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Axis::MotorAngle => "the rotor's angle",
            Axis::MotorSpeed => "the speed",
            Axis::Current => "the current",
            Axis::Time => "time",
            Axis::OutputAngle => "the angle behind the gear",
            Axis::OutputWindup => "the wind-up of the gear",
        }
    }

    /// Its name, as a column of a log has it, on a joint with that many stages.
    pub fn column(self, stages: usize) -> &'static str {
        match self {
            Axis::OutputAngle if stages == 0 => Axis::MotorAngle.column(stages),
            Axis::MotorAngle => "motor_angle_rad",
            Axis::MotorSpeed => "motor_speed_rad_per_s",
            Axis::Current => "i_a",
            Axis::Time => "t_s",
            Axis::OutputAngle => "output_angle_rad",
            Axis::OutputWindup => "output_windup_rad",
        }
    }
}

/// How the blind benchmark hides an effect.
#[derive(Clone, Copy, Debug)]
pub enum Benchmark {
    /// With a size that a user of the joint would care about; `None` where the joint has no place for
    /// it.
    Hidden(fn(&mut Bench<'_>) -> Option<EffectParameters>),
    /// The same in wide draws alone.
    Wide(fn(&mut Bench<'_>) -> Option<EffectParameters>),
    /// Not at all, for a reason.
    Left(&'static str),
}

/// The joint that an effect is hidden in: what the effect's size follows from.
pub struct Bench<'a> {
    /// Number of stages.
    pub stages: usize,
    /// Length of the log, s.
    pub duration_s: f64,
    /// How large the effect is to be, in typical sizes.
    pub size: f64,
    /// A phase drawn at random, rad.
    pub phase_rad: f64,
    /// A sign drawn at random.
    pub sign: f64,
    /// Breakaway torque of the whole joint at the motor, Nm.
    pub motor_torque_nm: f64,
    /// The same at the output, Nm.
    pub output_torque_nm: f64,
    /// Stiffness of the last stage, Nm/rad; infinite where there is none.
    pub stiffness_nm_per_rad: f64,
    /// Amplitude of the voltage that excites the joint, V.
    pub voltage_v: f64,
    /// The winding's 2R, ohm.
    pub resistance_ohm: f64,
    /// The speed whose back-EMF that voltage is, rad/s.
    pub speed_rad_per_s: f64,
    /// Electrical periods per turn.
    pub pole_pairs: f64,
    /// Standard deviation of the measured current, A.
    pub current_noise_a: f64,
    /// Sample time of the log, s.
    pub sample_time_s: f64,
    /// Draws what else is drawn.
    pub random: &'a mut dyn Rng,
}

impl Bench<'_> {
    /// The last stage.
    pub fn gear(&self) -> Option<Location> {
        let last = u8::try_from(self.stages).ok()?;
        (last > 0).then_some(Location::Stage(last))
    }

    /// Wind-up of the last stage under the breakaway torque, rad at the output.
    pub fn windup_rad(&self) -> f64 {
        self.output_torque_nm / self.stiffness_nm_per_rad
    }

    /// The current that the voltage drives through the winding at rest, A.
    pub fn current_a(&self) -> f64 {
        self.voltage_v / self.resistance_ohm
    }

    /// So much of a whole for a typical size; never nearly all of it.
    pub fn share(&self, typical: f64) -> f64 {
        (typical * self.size).min(0.9)
    }

    /// One of these values, drawn at random.
    pub fn one_of<const N: usize>(&mut self, values: [f64; N]) -> f64 {
        values[self.random.random_range(0..N)]
    }
}
