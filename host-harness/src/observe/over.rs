//! A log as an observer is given it: samples on the drive's clock, and what they show of a rating.

use joint_core::fixed::Fixed;
use joint_core::joint::Drive;
use joint_core::per_unit::Bases;

use super::design::{Tuning, design, gains};
use super::rating::Rating;
use super::run::{Found, Seen, observer, run, run_fixed};
use crate::log::Log;
use crate::model::Model;
use crate::plant::{BuildError, ScalarKind};

/// A log's samples and the steps between them.
#[derive(Clone, Debug)]
pub struct Samples {
    /// What the drive imposes.
    pub kind: Drive,
    /// The typical interval, s.
    pub step_s: f64,
    /// Steps from the sample before.
    pub steps: Vec<u32>,
    /// What the observer is given.
    pub seen: Vec<Seen>,
}

impl Samples {
    /// Of a log.
    pub fn of(log: &Log) -> Self {
        let kind = imposed(log);
        let mut intervals: Vec<f64> = log.time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let steps = |step_s: f64| {
            let pairs = log.time_s.windows(2);
            let counts = pairs.map(|pair| ((pair[1] - pair[0]) / step_s).round().clamp(1.0, 1e5));
            std::iter::once(1).chain(counts.map(|count| count as u32)).collect()
        };
        intervals.sort_by(f64::total_cmp);
        let step_s = intervals.get(intervals.len() / 2).copied().unwrap_or(1e-4);
        Self { kind, step_s, steps: steps(step_s), seen: seen(log, kind) }
    }

    /// The same with its output encoder withheld.
    #[must_use]
    pub fn motor_only(&self) -> Self {
        let mut samples = self.clone();
        samples.seen.iter_mut().for_each(|seen| seen.output = f64::NAN);
        samples
    }

    /// For what the log shows an observer has to be designed; `load_nm` where the load is known.
    ///
    /// # Errors
    /// The model cannot be built.
    pub fn rating<const N: usize>(
        &self,
        model: &Model,
        load_nm: Option<f64>,
    ) -> Result<Rating, BuildError> {
        let values = self.seen.iter().map(|seen| seen.drive.abs());
        let drive = values.filter(|value| value.is_finite()).fold(0.0, f64::max);
        let mut rating = Rating::of(model, self.kind);
        if drive > 0.0 {
            rating.drive = drive;
            rating.load_nm = Rating::holds(model, self.kind, drive);
        }
        let speed = self.speed();
        if speed > 0.0 {
            rating.speed = speed;
        }
        match load_nm {
            Some(load_nm) => Ok(Rating { load_nm, ..rating }),
            None => self.shown::<N>(model, rating),
        }
    }

    /// The rotor speed that 98 % of the log stays below, rad/s.
    fn speed(&self) -> f64 {
        let pairs = self.seen.windows(2).zip(self.steps.iter().skip(1));
        let speeds = pairs.map(|(pair, steps)| {
            (pair[1].motor - pair[0].motor).abs() / (f64::from(*steps) * self.step_s)
        });
        let mut speeds: Vec<f64> = speeds.filter(|speed| speed.is_finite()).collect();
        speeds.sort_by(f64::total_cmp);
        speeds.get(speeds.len() * 98 / 100).copied().unwrap_or(0.0)
    }

    /// The largest load that the log shows: from one that friction holds upwards, as an observer
    /// that expects far too much sees it in every count of the encoder.
    fn shown<const N: usize>(
        &self,
        model: &Model,
        mut rating: Rating,
    ) -> Result<Rating, BuildError> {
        let most = rating.load_nm;
        rating.load_nm = Rating::held(model).min(most);
        for _ in 0..6 {
            let design = gains::<N>(model, self.kind, self.step_s, &rating, &Tuning::default())?;
            let observer = observer::<f64, N>(model, self.kind, self.step_s, &design)?;
            let found = run(&observer, &self.seen, &self.steps);
            let mut loads: Vec<f64> = found.iter().map(|f| f.estimate.load.abs()).collect();
            loads.sort_by(f64::total_cmp);
            let shown = loads.get(loads.len() * 98 / 100).copied().unwrap_or(0.0);
            if shown < 1.2 * rating.load_nm {
                rating.load_nm = rating.load_nm.min(shown.max(0.5 * rating.load_nm));
                break;
            }
            rating.load_nm = shown.min(10.0 * most);
        }
        Ok(rating)
    }

    /// What an observer of a model, designed for this rating, finds.
    ///
    /// # Errors
    /// The model cannot be observed.
    pub fn observed<const N: usize>(
        &self,
        model: &Model,
        rating: &Rating,
        tuning: &Tuning,
        scalar: ScalarKind,
    ) -> Result<Vec<Found<N>>, BuildError> {
        let (kind, step_s) = (self.kind, self.step_s);
        let design = design::<N>(model, kind, step_s, rating, tuning)?;
        let (seen, steps) = (&self.seen, &self.steps);
        Ok(match scalar {
            ScalarKind::F64 => run(&observer::<f64, N>(model, kind, step_s, &design)?, seen, steps),
            ScalarKind::F32 => run(&observer::<f32, N>(model, kind, step_s, &design)?, seen, steps),
            ScalarKind::Fixed => {
                let observer = observer::<Fixed, N>(model, kind, step_s, &design)?;
                let bases = Bases::of(&model.motor, &model.stages, step_s);
                run_fixed(&observer, &bases, seen, steps)
            }
        })
    }
}

/// What stands for the drive: the voltage, or the current where there is none or where most of it is
/// missing and the current has more. A drive in torque mode logs its current alone, which then is the
/// input and corrects nothing.
fn imposed(log: &Log) -> Drive {
    let values = |column: &Option<Vec<f64>>| {
        column.as_deref().unwrap_or_default().iter().filter(|value| value.is_finite()).count()
    };
    let (voltage, current) = (values(&log.voltage_v), values(&log.current_a));
    if 2 * voltage >= log.len().max(1) || voltage > current {
        Drive::Voltage
    } else {
        Drive::Current
    }
}

fn seen(log: &Log, kind: Drive) -> Vec<Seen> {
    let at = |column: &Option<Vec<f64>>, k: usize| {
        column.as_ref().and_then(|values| values.get(k)).copied().unwrap_or(f64::NAN)
    };
    (0..log.len())
        .map(|k| Seen {
            drive: match kind {
                Drive::Voltage => at(&log.voltage_v, k),
                Drive::Current => at(&log.current_a, k),
            },
            current: if kind == Drive::Voltage { at(&log.current_a, k) } else { f64::NAN },
            motor: log.motor_angle_rad.get(k).copied().unwrap_or(f64::NAN),
            output: at(&log.output_angle_rad, k),
        })
        .collect()
}
