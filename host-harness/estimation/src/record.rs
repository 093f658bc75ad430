//! A log as the estimator sees it: inputs, measurements, and the grid of its intervals.

use std::borrow::Cow;
use std::ops::Range;

use joint_core::joint::Drive;

use super::motion::moves_at_once;
use super::scatter::Scatter;
use joint_simulation::grid::{GAP, Grid};
use joint_simulation::log::Log;
use joint_simulation::model::Model;

/// The measured channels, in the order of the residuals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Channel {
    /// Motor current.
    Current,
    /// Rotor angle.
    Motor,
    /// Angle behind the last stage.
    Output,
}

/// Number of channels.
pub const CHANNELS: usize = 3;

impl Channel {
    /// All of them, in order.
    pub const ALL: [Channel; CHANNELS] = [Channel::Current, Channel::Motor, Channel::Output];

    /// The log's column.
    pub fn column(self) -> &'static str {
        match self {
            Channel::Current => "i_a",
            Channel::Motor => "motor_angle_rad",
            Channel::Output => "output_angle_rad",
        }
    }
}

/// One log, ready to be predicted.
#[derive(Clone, Debug)]
pub struct Record {
    /// Sample times, s.
    pub time_s: Vec<f64>,
    /// What the drive imposes.
    pub drive: Drive,
    /// Volts or amperes, held from a sample, or a little before it, for an interval.
    pub drive_values: Vec<f64>,
    /// Known load at the output, Nm.
    pub load_nm: Vec<f64>,
    /// Measurements by sample and channel; NaN where there is none.
    pub measured: Vec<[f64; CHANNELS]>,
    /// Bus voltage, V, where every log has it: never fitted to.
    pub bus_v: Option<Vec<f64>>,
    /// Temperature, °C, where every log has it: never fitted to.
    pub temperature_c: Option<Vec<f64>>,
    /// The intervals.
    pub grid: Grid,
    /// Samples at which a log begins, or goes on after a gap.
    pub starts: Vec<usize>,
    /// Those of them before which something was cut out: the joint may be in motion there.
    pub cuts: Vec<usize>,
    /// How the joint moves there, as far as somebody has followed it.
    pub motions: Vec<Motion>,
    /// Whether the output is taken to feel a disturbance of its own.
    pub output_disturbed: bool,
    /// White noise of its drive, V, where that is more than one expects; zero where nothing says so.
    pub drive_noise: f64,
    /// What its encoders scatter by, told from their readings.
    pub(super) scatter: [Option<Scatter>; CHANNELS],
    /// By sample: variance that the clock's jitter adds to a reading, rad²; empty where it adds none.
    pub(super) jitter: Vec<[f64; CHANNELS]>,
}

/// How a joint moves at a sample, as a filter had it.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Which sample.
    pub sample: usize,
    /// The joint's state, without what effects remember.
    pub state: Vec<f64>,
    /// What the filter's constants beside it were.
    pub constants: Vec<f64>,
    /// Whether the stretch before is of the same log: its constants are, and are known by then.
    pub goes_on: bool,
}

/// Stretches into which a record too long is thinned.
const STRETCHES: usize = 4;

/// Why logs cannot be put together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum JoinError {
    /// There is none.
    #[error("there is no log")]
    NoLog,
    /// One imposes a voltage, another a current.
    #[error(
        "log number {0} imposes another quantity than the first: u_v in all of them, or in none"
    )]
    Mixed(usize),
}

impl Record {
    /// Of several logs of one joint, one after the other; `micro_steps` of every interval, `None`
    /// takes what the parameters ask for.
    ///
    /// # Errors
    /// No log, or logs that impose different things.
    pub fn join(logs: &[Log], micro_steps: Option<u32>) -> Result<Self, JoinError> {
        let mut parts = logs.iter().map(|log| Self::unasked(log, micro_steps));
        let mut whole = parts.next().ok_or(JoinError::NoLog)?;
        let mut firsts = Vec::new();
        for (number, part) in parts.enumerate() {
            if part.drive != whole.drive {
                return Err(JoinError::Mixed(number + 2));
            }
            let gap = whole.grid.interval(whole.len());
            let shift = whole.time_s.last().copied().unwrap_or(0.0) + gap
                - part.time_s.first().copied().unwrap_or(0.0);
            let before = whole.len();
            firsts.push(before);
            whole.starts.extend(part.starts.iter().map(|start| start + before));
            whole.cuts.extend(part.cuts.iter().map(|cut| cut + before));
            whole.time_s.extend(part.time_s.iter().map(|t| t + shift));
            whole.drive_values.extend(part.drive_values);
            whole.load_nm.extend(part.load_nm);
            whole.measured.extend(part.measured);
            whole.bus_v = joined(whole.bus_v, part.bus_v);
            whole.temperature_c = joined(whole.temperature_c, part.temperature_c);
        }
        let log_of = |k: usize| firsts.partition_point(|first| *first <= k) as u32;
        let grid = Grid::new(&whole.time_s, micro_steps);
        whole.grid = grid.of_logs(log_of);
        whole.ask_encoders();
        Ok(whole)
    }

    /// From a log, without the stretches in which nothing says what drove the joint; `micro_steps` of every
    /// interval, `None` takes what the parameters ask for.
    pub fn new(log: &Log, micro_steps: Option<u32>) -> Self {
        let mut record = Self::unasked(log, micro_steps);
        record.ask_encoders();
        record
    }

    /// The same before its encoders are asked what they scatter by.
    fn unasked(log: &Log, micro_steps: Option<u32>) -> Self {
        let log = &driven(log);
        let n = log.time_s.len();
        let (drive, values) = match (&log.voltage_v, &log.current_a) {
            (Some(voltage), _) => (Drive::Voltage, voltage.clone()),
            (None, Some(current)) => (Drive::Current, current.clone()),
            (None, None) => (Drive::Voltage, vec![0.0; n]),
        };
        let at = |column: &Option<Vec<f64>>, k: usize| {
            column.as_ref().map_or(f64::NAN, |values| values[k])
        };
        let measured = (0..n)
            .map(|k| {
                let current =
                    if drive == Drive::Voltage { at(&log.current_a, k) } else { f64::NAN };
                [current, log.motor_angle_rad[k], at(&log.output_angle_rad, k)]
            })
            .collect();
        let grid = Grid::new(&log.time_s, micro_steps);
        let gap = GAP * grid.typical_interval();
        let gaps = (1..n).filter(|k| log.time_s[*k] - log.time_s[k - 1] > gap);
        let starts: Vec<usize> = std::iter::once(0).chain(gaps).collect();
        let rests = !moves_at_once(&log.motor_angle_rad);
        let cuts = starts[usize::from(rests)..].to_vec();
        Self {
            time_s: log.time_s.clone(),
            drive,
            drive_values: held(values),
            load_nm: held(log.load_torque_nm.clone().unwrap_or_else(|| vec![0.0; n])),
            measured,
            bus_v: log.bus_v.clone(),
            temperature_c: log.temperature_c.clone(),
            grid,
            starts,
            cuts,
            motions: Vec::new(),
            output_disturbed: false,
            drive_noise: 0.0,
            scatter: [None; CHANNELS],
            jitter: Vec::new(),
        }
    }

    /// A record of at most so many samples: whole if it is short enough, else stretches spread evenly
    /// over it.
    pub fn thinned(self, most: usize) -> Self {
        let samples = self.len();
        if samples <= most {
            return self;
        }
        let length = most / STRETCHES;
        let first = |number: usize| number * (samples - length) / (STRETCHES - 1);
        let kept: Vec<_> =
            (0..STRETCHES).map(|number| first(number)..first(number) + length).collect();
        self.stretches(&kept)
    }

    /// Some stretches of it, one after the other: the joint is in motion where one begins, unless a log
    /// does.
    pub(super) fn stretches(&self, kept: &[Range<usize>]) -> Self {
        let (mut starts, mut cuts) = (Vec::new(), Vec::new());
        let samples = || kept.iter().cloned().flatten();
        let begins = |sample: &usize| kept.iter().any(|stretch| stretch.start == *sample);
        for (place, sample) in samples().enumerate() {
            let logged = self.starts.contains(&sample);
            if logged || begins(&sample) {
                starts.push(place);
            }
            if self.cuts.contains(&sample) || begins(&sample) && !logged {
                cuts.push(place);
            }
        }
        let of = |values: &[f64]| samples().map(|k| values[k]).collect::<Vec<f64>>();
        let time_s = of(&self.time_s);
        let logs: Vec<u32> = samples().map(|k| self.grid.log(k)).collect();
        Self {
            grid: self.grid.over(&time_s).of_logs(|place| logs[place]),
            time_s,
            drive: self.drive,
            drive_values: of(&self.drive_values),
            load_nm: of(&self.load_nm),
            measured: samples().map(|k| self.measured[k]).collect(),
            bus_v: self.bus_v.as_deref().map(of),
            temperature_c: self.temperature_c.as_deref().map(of),
            starts,
            cuts,
            motions: Vec::new(),
            output_disturbed: self.output_disturbed,
            drive_noise: self.drive_noise,
            scatter: self.scatter,
            jitter: match self.jitter.is_empty() {
                true => Vec::new(),
                false => samples().map(|k| self.jitter[k]).collect(),
            },
        }
    }

    /// The same record with that many micro-steps in every interval.
    pub fn refined(&self, micro_steps: u32) -> Self {
        Self { grid: self.grid.clone().refined(micro_steps), ..self.clone() }
    }

    /// The same record of a joint whose output feels a disturbance of its own.
    pub fn disturbed(&self) -> Self {
        Self { output_disturbed: true, ..self.clone() }
    }

    /// The same record with every drive value in the middle of the interval that it stands for.
    pub fn centred(&self) -> Self {
        self.leading(0.5 * self.grid.typical_interval())
    }

    /// The same record with every drive value held from its sample on.
    pub fn commanded(&self) -> Self {
        self.leading(0.0)
    }

    fn leading(&self, lead_s: f64) -> Self {
        Self { grid: self.grid.clone().leading(lead_s), ..self.clone() }
    }

    /// How many logs it is of.
    pub fn logs(&self) -> usize {
        self.grid.logs()
    }

    /// How long before its sample a drive value begins to act, s.
    pub fn lead_s(&self) -> f64 {
        self.grid.lead_s
    }

    /// A model that was fitted to this record, which says how a current that is the input was taken.
    pub fn timed(&self, mut model: Model) -> Model {
        if self.drive == Drive::Current {
            model.sensor.current_is_measured = self.lead_s() > 0.0;
        }
        model
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Whether a channel is measured at all.
    pub fn has(&self, channel: Channel) -> bool {
        self.measured.iter().any(|row| row[channel as usize].is_finite())
    }

    /// Noise that a channel's sensor adds, one sigma in its unit: what rounding to a count, as the model
    /// says it, or to the last printed digit leaves, and where readings plainly scatter by more, that.
    pub fn sensor_sigma(&self, model: &Model, channel: Channel) -> f64 {
        let rounding = Self::count_sigma(model, channel).max(self.digit_sigma(channel));
        let found = self.scatter[channel as usize].filter(|scatter| scatter.exceeds(rounding));
        found.map_or(rounding, |scatter| scatter.sigma_rad)
    }

    /// Variance that the clock's jitter adds to what a channel shows at a sample.
    #[inline]
    pub(super) fn jitter(&self, k: usize, channel: Channel) -> f64 {
        self.jitter.get(k).map_or(0.0, |row| row[channel as usize])
    }

    /// The same as far as the model tells; zero where it does not.
    pub(super) fn count_sigma(model: &Model, channel: Channel) -> f64 {
        let counts = match channel {
            Channel::Current => return model.sensor.current_noise_a,
            Channel::Motor => model.sensor.motor_encoder_counts_per_rev,
            Channel::Output => model.sensor.output_encoder_counts_per_rev,
        };
        if counts > 0.0 { std::f64::consts::TAU / counts / 12.0_f64.sqrt() } else { 0.0 }
    }

    /// The same as far as the record's digits tell.
    pub(super) fn digit_sigma(&self, channel: Channel) -> f64 {
        self.digit(channel) / 12.0_f64.sqrt()
    }

    /// Smallest change that a channel shows.
    pub(super) fn digit(&self, channel: Channel) -> f64 {
        let steps = self
            .measured
            .windows(2)
            .map(|pair| (pair[1][channel as usize] - pair[0][channel as usize]).abs());
        let smallest = steps.filter(|step| *step > 1e-12).fold(f64::INFINITY, f64::min);
        if smallest.is_finite() { smallest } else { 1e-6 }
    }
}

/// A channel of two records one after the other, if both have it.
fn joined(before: Option<Vec<f64>>, after: Option<Vec<f64>>) -> Option<Vec<f64>> {
    let mut whole = before?;
    whole.extend(after?);
    Some(whole)
}

/// A log without the stretches in which its input is missing for longer than a gap lasts: a drive that lets
/// go of a joint logs nothing, and a joint that is let go is neither held nor shorted. What stands between
/// two of them for no longer goes as well.
fn driven(log: &Log) -> Cow<'_, Log> {
    let Some(input) = log.voltage_v.as_ref().or(log.current_a.as_ref()) else {
        return Cow::Borrowed(log);
    };
    let known: Vec<bool> = input.iter().map(|value| value.is_finite()).collect();
    let long = |known: &[bool]| known.len() > GAP as usize;
    let mut kept = Vec::with_capacity(known.len());
    for stretch in known.chunk_by(|a, b| a == b) {
        kept.extend(stretch.iter().map(|known| *known || !long(stretch)));
    }
    if kept.iter().all(|kept| *kept) {
        return Cow::Borrowed(log);
    }
    let mut whole = Vec::with_capacity(kept.len());
    for stretch in kept.chunk_by(|a, b| a == b) {
        whole.extend(stretch.iter().map(|kept| *kept && long(stretch)));
    }
    if whole.contains(&true) { Cow::Owned(log.only(&whole)) } else { Cow::Borrowed(log) }
}

/// Missing inputs hold the last value.
fn held(mut values: Vec<f64>) -> Vec<f64> {
    let mut last = 0.0;
    for value in &mut values {
        if value.is_finite() {
            last = *value;
        } else {
            *value = last;
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(samples: usize) -> Log {
        Log {
            time_s: (0..samples).map(|k| k as f64 * 1e-3).collect(),
            voltage_v: Some((0..samples).map(|k| k as f64).collect()),
            motor_angle_rad: vec![0.0; samples],
            ..Log::default()
        }
    }

    #[test]
    fn a_gap_is_a_start_before_which_something_was_cut_out() {
        let mut log = log(1000);
        for time in &mut log.time_s[400..] {
            *time += 0.5;
        }
        let record = Record::new(&log, None);
        assert_eq!((record.starts, record.cuts), (vec![0, 400], vec![400]));
        // A few samples lost are none.
        let mut log = self::log(1000);
        for time in &mut log.time_s[400..] {
            *time += 5e-3;
        }
        assert!(Record::new(&log, None).cuts.is_empty());
    }

    #[test]
    fn samples_of_which_nothing_says_what_drove_the_joint_are_left_out() {
        let mut log = log(1000);
        let silent = |log: &mut Log, from: usize, to: usize| {
            log.voltage_v.iter_mut().for_each(|volts| volts[from..to].fill(f64::NAN));
        };
        // A few are held.
        silent(&mut log, 100, 115);
        let record = Record::new(&log, None);
        assert_eq!((record.len(), record.drive_values[110]), (1000, 99.0));
        // Long ones are a gap each, and the ten samples between two of them are gone as well.
        silent(&mut log, 400, 500);
        silent(&mut log, 510, 600);
        silent(&mut log, 950, 999);
        let record = Record::new(&log, None);
        assert_eq!(record.len(), 400 + 350);
        assert_eq!((record.drive_values[400], record.time_s[400]), (600.0, 0.6));
        assert_eq!((record.starts, record.cuts), (vec![0, 400], vec![400]));
    }

    #[test]
    fn a_log_that_begins_in_motion_is_told_from_one_that_begins_to_move() {
        let begins = |angle: &dyn Fn(f64) -> f64| {
            let mut log = log(1000);
            log.motor_angle_rad =
                (0..1000).map(|k| (angle(f64::from(k)) * 1e4).round() / 1e4).collect();
            Record::new(&log, None).cuts == [0]
        };
        assert!(begins(&|k| 3e-4 * k));
        assert!(begins(&|k| 1.0 - 2e-3 * k + 1e-5 * k * k));
        assert!(!begins(&|k| 2e-4 * k * k));
        // Few counts are waited for, fewer are none.
        assert!(begins(&|k| 2e-5 * k));
        assert!(!begins(&|k| 5e-6 * k));
        assert!(!begins(&|_| 0.3));
    }

    #[test]
    fn a_long_record_is_thinned_to_stretches_from_first_sample_to_last() {
        let mut log = log(10_000);
        for time in &mut log.time_s[5_900..] {
            *time += 0.5;
        }
        let record = Record::new(&log, None).thinned(4_000);
        assert_eq!(record.len(), 4_000);
        // The third stretch begins at sample 6,000: the gap before it falls away with its sample.
        assert_eq!(record.cuts, [1_000, 2_000, 3_000]);
        assert_eq!(record.starts, [0, 1_000, 2_000, 3_000]);
        assert_eq!((record.drive_values[0], record.drive_values[3_999]), (0.0, 9_999.0));
        assert_eq!(record.drive_values[1_000], 3_000.0);
        let short = Record::new(&self::log(500), None);
        assert_eq!(short.clone().thinned(500).time_s, short.time_s);
    }

    #[test]
    fn a_stretch_that_begins_with_a_log_begins_as_that_does() {
        let logs = [log(300), log(300)];
        let record = Record::join(&logs, None).unwrap().stretches(&[100..200, 300..400, 450..500]);
        assert_eq!(record.len(), 250);
        assert_eq!((record.starts, record.cuts), (vec![0, 100, 200], vec![0, 200]));
        assert_eq!(record.drive_values[100], 0.0);
    }
}
