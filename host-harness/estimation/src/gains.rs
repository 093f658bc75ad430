//! What a filter is designed with, and what the design gives: pushes and noises, gains and runs.

use std::sync::Arc;

use crate::record::{CHANNELS, Channel};

/// A slow, unknown push on one equation of the joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Equation {
    /// A voltage beside the applied one, V (a current, A, where the current is imposed).
    Voltage,
    /// A torque on one mass, reflected to the motor, Nm; 0 is the rotor.
    Torque(usize),
    /// What a sensor shows beside the truth.
    Sensor(Channel),
    /// What the current's sensor showed a sample ago, A: between that and what it shows now is a current that is late by
    /// parts of a sample.
    CurrentBefore,
}

impl Equation {
    /// Whether it says what a sensor shows, not what the joint does.
    pub fn is_of_a_sensor(self) -> bool {
        matches!(self, Self::Sensor(_) | Self::CurrentBefore)
    }
}

/// A disturbance of one equation, as an extra state of the filter: a random walk, or one that forgets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walk {
    /// Where it acts.
    pub equation: Equation,
    /// Its one sigma at the start.
    pub initial: f64,
    /// Its one sigma per root second.
    pub rate: f64,
    /// Time over which it is correlated, s; infinite of a random walk.
    pub correlation_s: f64,
}

impl Walk {
    /// What the current's sensor showed a sample ago.
    pub const CURRENT_BEFORE: Self = Self {
        equation: Equation::CurrentBefore,
        initial: 0.0,
        rate: 0.0,
        correlation_s: f64::INFINITY,
    };

    /// A random walk; of no rate a constant.
    pub fn random(equation: Equation, initial: f64, rate: f64) -> Self {
        Self { equation, initial, rate, correlation_s: f64::INFINITY }
    }

    /// A stationary disturbance (Ornstein and Uhlenbeck 1930).
    pub fn coloured(equation: Equation, colour: Colour) -> Self {
        let Colour { deviation, correlation_s } = colour;
        let rate = deviation * (2.0 / correlation_s).sqrt();
        Self { equation, initial: deviation, rate, correlation_s }
    }

    /// Share of it that is left after an interval, s.
    pub(super) fn kept(&self, interval: f64) -> f64 {
        (-interval / self.correlation_s).exp()
    }

    /// Variance that it gains over an interval, s.
    pub(super) fn gained(&self, interval: f64) -> f64 {
        let rate = self.rate * self.rate;
        match self.correlation_s.is_finite() {
            true => {
                -0.5 * rate * self.correlation_s * (-2.0 * interval / self.correlation_s).exp_m1()
            }
            false => rate * interval,
        }
    }
}

/// A disturbance that is correlated in time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Colour {
    /// Its one sigma, in the unit of its equation; zero where there is none.
    pub deviation: f64,
    /// Time over which it is correlated, s.
    pub correlation_s: f64,
}

/// An equation that a coloured disturbance may act on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Disturbed {
    /// The drive: V, or A where the current is imposed.
    Drive,
    /// The rotor's torque, Nm.
    Rotor,
    /// The torque on the last mass, reflected to the motor, Nm.
    Output,
}

impl Disturbed {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Drive, Self::Rotor, Self::Output];

    /// The equation of a joint of that many stages.
    pub fn equation(self, stages: usize) -> Equation {
        match self {
            Self::Drive => Equation::Voltage,
            Self::Rotor => Equation::Torque(0),
            Self::Output => Equation::Torque(stages),
        }
    }
}

/// One sigma of every noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Voltage (or imposed current) beside the known one, held for a sample.
    pub drive: f64,
    /// Torque on the rotor beside the known ones, Nm, held for a sample.
    pub torque: f64,
    /// Torque beside the known ones where the joint stands still, Nm at the motor, held for a sample: what a
    /// friction law that is another near the reversal makes. Rotor and last mass feel it as their breakaway torques
    /// are.
    pub reversal: f64,
    /// Torque on the last mass beside the known ones, reflected to the motor, Nm, held for a sample; zero
    /// where the output is taken to feel nothing of its own.
    pub output: f64,
    /// The sensors.
    pub sensors: [f64; CHANNELS],
    /// Disturbances that are correlated in time, by [`Disturbed`].
    pub coloured: [Colour; Disturbed::ALL.len()],
}

impl Noise {
    /// Its coloured disturbances on a joint of that many stages.
    pub fn walks(&self, stages: usize) -> impl Iterator<Item = Walk> {
        self.colours().map(move |(place, colour)| Walk::coloured(place.equation(stages), colour))
    }

    /// Its coloured disturbances and where they act.
    pub fn colours(&self) -> impl Iterator<Item = (Disturbed, Colour)> {
        Disturbed::ALL.into_iter().zip(self.coloured).filter(|(_, colour)| colour.deviation > 0.0)
    }

    /// Whether there is a disturbance beside what is white and alike at all speeds.
    pub fn is_disturbed(&self) -> bool {
        self.reversal > 0.0 || self.colours().next().is_some()
    }

    /// The same without the disturbances that are correlated in time.
    pub fn uncoloured(self) -> Self {
        Self { coloured: Default::default(), ..self }
    }

    /// The same with the model distrusted so many times as much.
    pub fn distrusted(self, times: f64) -> Self {
        Self {
            drive: times * self.drive,
            torque: times * self.torque,
            output: times * self.output,
            ..self
        }
    }

    /// How many times what is expected the drive, the rotor or the output needs, whichever needs most.
    pub fn times(&self, expected: &Noise) -> f64 {
        let felt = (self.torque / expected.torque).max(self.drive / expected.drive);
        felt.max(self.output_times(expected))
    }

    /// The same of the output; zero where it is taken to feel nothing.
    pub fn output_times(&self, expected: &Noise) -> f64 {
        if expected.output > 0.0 { self.output / expected.output } else { 0.0 }
    }
}

/// The filter's gains along a record, and the scale of its innovations.
#[derive(Clone, Debug)]
pub struct Gains {
    pub(super) order: usize,
    /// By sample and channel: gain of the state on the innovation divided by its sigma.
    pub(super) gain: Arc<Vec<f64>>,
    /// By sample and channel: one over the innovation's sigma, zero where nothing is measured.
    pub(super) weight: Arc<Vec<[f64; CHANNELS]>>,
    pub(super) walks: Vec<Walk>,
}

impl Gains {
    /// Sum of the logarithms of the innovations' variances over the samples of a mask.
    pub fn log_variance(&self, mask: &[f64]) -> f64 {
        self.log_variances().zip(mask).map(|(log, mask)| mask * log).sum()
    }

    /// The same sample by sample.
    pub fn log_variances(&self) -> impl Iterator<Item = f64> {
        let log = |weight: &f64| if *weight > 0.0 { -2.0 * weight.ln() } else { 0.0 };
        self.weight.iter().map(move |row| row.iter().map(log).sum())
    }
}

/// What a filter makes of a record.
#[derive(Clone, Debug)]
pub struct Run {
    /// Whitened innovations by sample and channel; zero where nothing is measured.
    pub innovations: Vec<[f64; CHANNELS]>,
    /// State estimates after each sample's measurements, the walks last.
    pub states: Vec<Vec<f64>>,
}

/// How the joint's next state follows from the present one along a record: what a design takes its
/// time for. Designs at other noise or with other walks can share it, as their trajectories differ
/// by noise alone.
#[derive(Clone, Debug, Default)]
pub struct Linearisation {
    /// By sample: derivative of each state with each.
    pub(super) transition: Vec<f64>,
    /// By sample: derivative of each state with the drive.
    pub(super) drive: Vec<f64>,
}

impl Linearisation {
    /// Whether it has still to be made.
    pub fn is_empty(&self) -> bool {
        self.drive.is_empty()
    }

    /// Whether it reaches over that many samples of that many states.
    pub(super) fn covers(&self, samples: usize, states: usize) -> bool {
        self.drive.len() >= samples.saturating_sub(1) * states
    }

    /// Makes room for that many samples of that many states.
    pub(super) fn reserve(&mut self, samples: usize, states: usize) {
        self.transition.reserve(samples * states * states);
        self.drive.reserve(samples * states);
    }

    /// Leaves one sample out, of that many states.
    pub(super) fn skip(&mut self, states: usize) {
        self.transition.extend(std::iter::repeat_n(f64::NAN, states * states));
        self.drive.extend(std::iter::repeat_n(f64::NAN, states));
    }
}
