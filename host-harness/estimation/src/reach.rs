//! How far a run goes: to the last sample of each log that is fitted to, since nothing before depends on
//! what comes after. A search runs its models thousands of times, and the end of each log is held out.

use super::filter::Observer;

impl Observer<'_> {
    /// The same without what comes after the last sample of a mask in each log: innovations and weights
    /// are zero there, derivatives no numbers.
    pub fn as_far_as(mut self, mask: &[f64]) -> Self {
        let starts = &self.record.starts;
        let ends = starts.iter().skip(1).copied().chain([self.record.len()]);
        let idle = starts.iter().zip(ends).filter_map(|(start, end)| {
            let last = mask[*start..end].iter().rposition(|weight| *weight > 0.0);
            let from = last.map_or(*start, |last| start + last + 1);
            (from < end).then_some(from..end)
        });
        self.idle = idle.collect();
        self
    }

    /// Whether nothing is asked for from a sample on, to the end of its log.
    pub(super) fn is_idle(&self, k: usize) -> bool {
        self.idle.iter().any(|range| range.contains(&k))
    }
}

#[cfg(test)]
mod tests {
    use crate::fit::Problem;
    use crate::noise;
    use crate::record::Record;
    use joint_simulation::demo::actuator;
    use joint_simulation::synthetic::{Experiment, record};

    #[test]
    fn what_comes_after_the_last_fitted_sample_changes_nothing_before() {
        let model = actuator();
        let log = record(&model, &Experiment::clean(0.3), 5).unwrap();
        let record = Record::join(&[log.clone(), log], None).unwrap();
        let second = record.starts[1];
        let (samples, ends) = (record.len(), [second - 70, record.len() - 40]);
        // Held out are the middle of the first log and the end of both.
        let fitted =
            |k: usize| k < ends[0] && !(100..200).contains(&k) || (second..ends[1]).contains(&k);
        let mask: Vec<f64> = (0..samples).map(|k| f64::from(u8::from(fitted(k)))).collect();
        let every = vec![1.0; samples];
        let [part, whole] = [&mask, &every].map(|mask| Problem::new(&record, mask));
        let noise = noise::expected(&model, &record);
        let [own, other] = [&part, &whole].map(|p| p.design(&model, &noise).unwrap());
        let again = part.innovations(&model, &own.gains).unwrap();
        for (k, again) in again.iter().enumerate() {
            let asked = k < ends[0] || (second..ends[1]).contains(&k);
            let wanted = if asked { other.innovations[k] } else { [0.0; 3] };
            assert_eq!(own.innovations[k], wanted, "{k}");
            let error = |c: usize| (again[c] - wanted[c]).abs();
            assert!((0..3).all(|c| error(c) < 1e-9), "{k}");
        }
        let missed = part.sum_of_squares(&other.innovations) + other.gains.log_variance(&mask);
        assert!((own.deviance - missed).abs() < 1e-9 * missed.abs());
        let moved = crate::refit::coordinates(&model, &part);
        let slopes = part.sensitivity(&model, &own.gains, &moved, None);
        let wanted = part.sensitivity(&model, &other.gains, &moved, None);
        assert!(slopes.iter().all(|slope| slope.is_finite()));
        assert!((slopes - &wanted).norm() < 1e-6 * wanted.norm());
    }
}
