//! The distinct intervals of a record: clocks jitter and samples are lost, but a joint is prepared for
//! the length of its step.

use std::collections::HashMap;

use joint_core::joint::Method;

/// Typical intervals from which on missing samples are a gap, and the joint behind it one that may
/// have done anything.
pub const GAP: f64 = 20.0;

/// The distinct intervals of a record.
#[derive(Clone, Debug)]
pub struct Grid {
    /// Distinct intervals, s.
    pub intervals: Vec<f64>,
    /// Of which log each of them is: the same length of another log is another one, since friction has its own level.
    of_log: Vec<u32>,
    /// Which of them follows a sample.
    pub serves: Vec<u32>,
    /// Steps taken per interval.
    pub per_interval: u32,
    /// Micro-steps of a typical interval.
    micro_steps: Option<u32>,
    /// How joints are stepped; `None` leaves it to them.
    pub method: Option<Method>,
    /// How long before its sample a drive value begins to act, s: half an interval where it is a measured
    /// current, zero where it was imposed.
    pub lead_s: f64,
    /// Median interval, s.
    typical: f64,
}

impl Grid {
    /// Of a record's sample times, told apart to a ten-thousandth of the shortest.
    pub fn new(time_s: &[f64], micro_steps: Option<u32>) -> Self {
        let shortest =
            time_s.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        let unit = if shortest.is_finite() { shortest * 1e-4 } else { 1.0 };
        let (mut intervals, mut serves) = (Vec::new(), Vec::with_capacity(time_s.len()));
        let mut known = HashMap::new();
        for pair in time_s.windows(2) {
            // Few distinct values: a clock has jitter, but a file has digits.
            let key = ((pair[1] - pair[0]) / unit).round() as i64;
            let index = *known.entry(key).or_insert_with(|| {
                intervals.push(key as f64 * unit);
                (intervals.len() - 1) as u32
            });
            serves.push(index);
        }
        if intervals.is_empty() {
            intervals.push(1.0);
            serves.push(0);
        }
        let mut sorted: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        sorted.sort_by(f64::total_cmp);
        let typical = sorted.get(sorted.len() / 2).copied().unwrap_or(1.0);
        Self {
            of_log: vec![0; intervals.len()],
            intervals,
            serves,
            per_interval: 1,
            micro_steps,
            method: None,
            lead_s: 0.0,
            typical,
        }
    }

    /// Of other sample times, with steps as here.
    pub fn over(&self, time_s: &[f64]) -> Self {
        let Self { method, lead_s, micro_steps, .. } = *self;
        Self { method, lead_s, ..Self::new(time_s, micro_steps) }
    }

    /// The same of several logs: by sample, which it is of.
    pub fn of_logs(self, log_of: impl Fn(usize) -> u32) -> Self {
        let (mut intervals, mut of_log) = (Vec::new(), Vec::new());
        let mut known = HashMap::new();
        let serve = |(k, serves): (usize, &u32)| {
            let (serves, log) = (*serves, log_of(k));
            *known.entry((serves, log)).or_insert_with(|| {
                intervals.push(self.intervals[serves as usize]);
                of_log.push(log);
                (intervals.len() - 1) as u32
            })
        };
        let serves = self.serves.iter().enumerate().map(serve).collect();
        Self { intervals, of_log, serves, ..self }
    }

    /// How many logs it is of.
    pub fn logs(&self) -> usize {
        self.of_log.iter().max().map_or(1, |last| *last as usize + 1)
    }

    /// Which log a sample is of.
    pub fn log(&self, k: usize) -> u32 {
        self.of_log[self.serves[k.min(self.serves.len() - 1)] as usize]
    }

    /// The distinct intervals, s, and which log each is of.
    pub fn distinct(&self) -> impl Iterator<Item = (f64, usize)> {
        self.intervals.iter().zip(&self.of_log).map(|(interval, log)| (*interval, *log as usize))
    }

    /// The same of a log whose drive values act this long before their samples, s.
    pub fn leading(self, lead_s: f64) -> Self {
        Self { lead_s, ..self }
    }

    /// The same with so many micro-steps in a typical interval.
    pub fn refined(self, micro_steps: u32) -> Self {
        Self { micro_steps: Some(micro_steps), ..self }
    }

    /// Micro-steps of an interval: more where a sample is missing, the same where a clock jitters.
    pub fn micro_steps(&self, interval: f64) -> Option<u32> {
        let asked = self.micro_steps?;
        Some(asked.max((0.7 * f64::from(asked) * interval / self.typical).ceil() as u32))
    }

    /// What is stepped of an interval: an estimator starts anew behind a gap.
    pub fn bridged(&self, interval: f64) -> f64 {
        if self.micro_steps.is_some() { interval.min(GAP * self.typical) } else { interval }
    }

    /// Median interval, s.
    pub fn typical_interval(&self) -> f64 {
        self.typical
    }

    /// Length of the interval after sample `k`, s.
    pub fn interval(&self, k: usize) -> f64 {
        self.intervals[self.serves[k.min(self.serves.len() - 1)] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_interval_has_its_own_length_however_many_there_are() {
        let mut time = vec![0.0];
        for k in 0..100_000 {
            time.push(time[k] + 1e-3 * (1.0 + f64::from(k as u32) * 1e-4));
        }
        let grid = Grid::new(&time, None);
        assert_eq!(grid.intervals.len(), 100_000);
        for k in [0, 65_535, 65_536, 99_999] {
            let wanted = time[k + 1] - time[k];
            assert!((grid.interval(k) / wanted - 1.0).abs() < 1e-4, "{k}");
        }
        let logs = Grid::new(&[0.0, 1.0, 2.0, 3.0, 4.0], None).of_logs(|k| u32::from(k >= 2));
        assert_eq!(logs.distinct().collect::<Vec<_>>(), [(1.0, 0), (1.0, 1)]);
        assert_eq!([1, 2, 9].map(|k| logs.log(k)), [0, 1, 1]);
        assert_eq!((logs.logs(), logs.interval(3)), (2, 1.0));
        let regular: Vec<f64> = (0..1000).map(|k| f64::from(k) * 1e-3).collect();
        assert_eq!(Grid::new(&regular, None).intervals.len(), 1);
    }
}
