//! Which stretches of a record fits look at while they are on the way to others, and how the joint moves where
//! one begins.

use std::ops::Range;

use super::filter::Observer;
use super::fit::standing_walks;
use super::noise;
use super::record::{Motion, Record};
use super::scout::Scout;
use joint_simulation::model::Model;
use joint_simulation::plant::{Layout, plant};

/// Samples that are looked at on the way.
const SAMPLES: usize = 6000;
/// Least of a stretch: where one begins, nobody knows what the effects remember.
const STRETCH: usize = 1000;
/// Times the expected noise of the filter that shows how the joint moves where a stretch begins: it takes what
/// the model misses for noise.
const DISTRUST: f64 = 30.0;

impl Scout {
    /// Of what a mask leaves of a record of a joint that is roughly this model; `None` where that is no more
    /// than is looked at anyway.
    pub fn of(record: &Record, mask: &[f64], model: &Model) -> Option<Self> {
        let whole = fitted(record, mask);
        let samples: usize = whole.iter().map(Range::len).sum();
        if samples <= SAMPLES {
            return None;
        }
        let kept = shortened(&whole, SAMPLES as f64 / samples as f64);
        let mut part = record.stretches(&kept);
        part.motions = motions(record, &kept, model);
        part.motions.retain(|motion| part.cuts.contains(&motion.sample));
        // A sensor that none of the stretches has needs no constant.
        let constants = standing_walks(&part).len();
        part.motions.iter_mut().for_each(|motion| motion.constants.truncate(constants));
        let record = part;
        let mask = vec![1.0; record.len()];
        Some(Self { record, mask })
    }
}

/// How a joint moves where stretches begin; nothing where its model cannot follow it.
pub(super) fn motions(record: &Record, kept: &[Range<usize>], model: &Model) -> Vec<Motion> {
    let noise = noise::expected(model, record).distrusted(DISTRUST);
    let Ok(plant) = plant(model, &record.grid, record.drive) else { return Vec::new() };
    let run = Observer::new(model, &*plant, record).design(&noise, &standing_walks(record)).1;
    let layout = Layout::of(model);
    let log = |sample: usize| record.starts.partition_point(|start| *start <= sample);
    let (mut sample, mut last) = (0, None);
    let mut all = Vec::new();
    for stretch in kept {
        let state = &run.states[stretch.start];
        if state.iter().all(|value| value.is_finite()) {
            let (own, constants) = state.split_at(layout.len());
            let state = own[..layout.len() - layout.memories].to_vec();
            let goes_on = last == Some(log(stretch.start));
            all.push(Motion { sample, state, constants: constants.to_vec(), goes_on });
        }
        last = Some(log(stretch.start));
        sample += stretch.len();
    }
    all
}

/// Stretches of one log that are fitted to without a break.
fn fitted(record: &Record, mask: &[f64]) -> Vec<Range<usize>> {
    let mut stretches: Vec<Range<usize>> = Vec::new();
    for k in (0..record.len()).filter(|k| mask[*k] > 0.0) {
        match stretches.last_mut() {
            Some(last) if last.end == k && !record.starts.contains(&k) => last.end += 1,
            _ => stretches.push(k..k + 1),
        }
    }
    stretches
}

/// The beginnings of stretches, a share of them all in sum; where that would leave too little of one, of
/// fewer.
fn shortened(whole: &[Range<usize>], share: f64) -> Vec<Range<usize>> {
    let mut due = 0.0;
    let mut kept = Vec::new();
    for stretch in whole {
        due += share * stretch.len() as f64;
        let length = (due as usize).min(stretch.len());
        if length >= STRETCH.min(stretch.len()) {
            kept.push(stretch.start..stretch.start + length);
            due -= length as f64;
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use joint_core::effect::{EffectParameters, Kind};
    use joint_core::params::Location;

    use super::*;
    use crate::fit::Problem;
    use joint_simulation::demo::actuator;
    use joint_simulation::synthetic::{self, Experiment};

    #[test]
    fn every_long_stretch_is_shortened_and_of_short_ones_some_go() {
        assert_eq!(shortened(&[0..4800, 6400..9600], 0.5), [0..2400, 6400..8000]);
        let many: Vec<_> = (0..40).map(|k| k * 400..k * 400 + 300).collect();
        let kept = shortened(&many, 0.5);
        assert_eq!(kept.iter().map(Range::len).sum::<usize>(), 6000);
        assert!(kept.iter().all(|stretch| stretch.len() == 300), "{kept:?}");
    }

    #[test]
    fn a_stretch_goes_on_as_the_whole_record_does() {
        let nominal = actuator();
        let effect = |kind, location| EffectParameters::new(kind, location);
        let mut truth = nominal.clone();
        truth.effects = vec![
            effect(Kind::SensorDelay, Location::Encoder).with("delay_s", 7e-4),
            effect(Kind::Backlash, Location::Stage(1)).with("width_rad", 2e-3),
            effect(Kind::Coating, Location::Output)
                .with("stiffness_nm_per_rad", 0.3)
                .with("hysteresis_nm", 0.3)
                .with("width_rad", 0.1),
            effect(Kind::WindingHeating, Location::Motor)
                .with("relative_rise", 0.3)
                .with("time_constant_s", 0.5)
                .with("reference_current_a", 1.0),
        ];
        let experiment = Experiment { sample_time_s: 2e-4, ..Experiment::clean(2.4) };
        let log = synthetic::record(&truth, &experiment, 3).unwrap();
        let record = Record::new(&log, Some(2));
        let mask: Vec<f64> = (0..record.len())
            .map(|k| if [3, 6, 9].contains(&(k * 10 / record.len())) { 0.0 } else { 1.0 })
            .collect();
        let scout = Scout::of(&record, &mask, &nominal).unwrap();
        assert!((SAMPLES - 5..=SAMPLES).contains(&scout.record.len()), "{}", scout.record.len());
        assert_eq!(scout.record.cuts, scout.record.starts[1..]);
        let noise = noise::expected(&nominal, &record).distrusted(DISTRUST);
        let whole = Problem::new(&record, &mask).scouted(Some(&scout));
        let [ahead, whole] = [whole.ahead(), whole].map(|own| own.design(&truth, &noise).unwrap());
        let kept = shortened(&fitted(&record, &mask), SAMPLES as f64 / 8400.0);
        let squares = |rows: &[[f64; 3]]| rows.iter().flatten().map(|e| e * e).sum::<f64>();
        let mut begin = 0;
        for stretch in kept {
            let own = squares(&ahead.innovations[begin..begin + stretch.len()]);
            let wanted = squares(&whole.innovations[stretch.clone()]);
            assert!((own / wanted - 1.0).abs() < 0.05, "{stretch:?}: {own} {wanted}");
            begin += stretch.len();
        }
        assert!(Scout::of(&record, &vec![0.0; record.len()], &nominal).is_none());
    }
}
