//! What a score means: what replicates reach by chance, what a name must explain, and which lines are worth
//! telling the reader.

use joint_core::params::Location;

use super::score_test::Gain;
use super::search::{LEAST_GAIN, Search, WEAK, excess};
use crate::estimate::refit::{DOUBTFUL, RUGGED};

/// Least that an effect must explain of a joint with one stage at most whose noise is not doubtful: in a
/// hundred drawn ones in which nothing is missing no score exceeds 22.
const LEAST_OF_SMOOTH: f64 = 40.0;
/// Least that a law of a stage must explain in a rugged chain: such laws score 64 and more in a fifth of
/// those in which nothing is missing, where the refit has ended in a hollow of the chain's own.
const LEAST_OF_RUGGED: f64 = 120.0;

impl Search {
    /// Least that an effect at a place must explain of the model as it is.
    pub(super) fn least_gain(&self, place: Location) -> f64 {
        least_gain(self.after.origin.stages.len(), excess(self), place)
    }

    /// Gain below which an effect at a place is weak: samples that no fit has seen must bear it out.
    pub(super) fn weak_gain(&self, place: Location) -> f64 {
        WEAK / LEAST_GAIN * self.least_gain(place).max(LEAST_GAIN)
    }
}

fn least_gain(stages: usize, excess: f64, place: Location) -> f64 {
    match place {
        Location::Stage(_) if stages >= RUGGED => LEAST_OF_RUGGED,
        _ if stages < RUGGED && excess < DOUBTFUL => LEAST_OF_SMOOTH,
        _ => LEAST_GAIN,
    }
}

/// The orders that are worth telling, strongest first; `best` is the best hypothesis' score.
pub(super) fn told(lines: &[(f64, Gain)], best: f64, by_chance: f64) -> Vec<f64> {
    let strongest = lines.iter().map(|(_, gain)| gain.real).fold(0.0, f64::max);
    // Lines only count where they rival the best hypothesis: every effect has some order.
    if strongest <= 0.3 * best {
        return Vec::new();
    }
    let least = by_chance.min(LEAST_GAIN).max(0.02 * strongest);
    let mut told: Vec<(f64, f64)> =
        lines.iter().map(|(o, gain)| (*o, gain.real)).filter(|(_, gain)| *gain > least).collect();
    told.sort_by(|a, b| b.1.total_cmp(&a.1));
    told.into_iter().map(|(order, _)| order).take(8).collect()
}

/// What nothing reaches by chance: six sigma above the mean of the replicates' best, each measured by its
/// own luck.
pub(super) fn threshold<'a>(gains: impl Iterator<Item = &'a Gain>) -> f64 {
    let mut best = Vec::new();
    for gain in gains {
        best.resize(best.len().max(gain.null.len()), 0.0_f64);
        for (best, null) in best.iter_mut().zip(&gain.null) {
            *best = best.max(*null / gain.luck());
        }
    }
    if best.is_empty() {
        return LEAST_GAIN;
    }
    let count = best.len() as f64;
    let mean = best.iter().sum::<f64>() / count;
    let spread = (best.iter().map(|b| (b - mean).powi(2)).sum::<f64>() / count).sqrt();
    mean + 6.0 * spread
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_of_a_rugged_chain_has_to_explain_more_than_one_of_a_smooth_joint() {
        let at = |stages: usize, place: Location| least_gain(stages, 1.0, place);
        let stage = Location::Stage(1);
        assert_eq!([at(2, stage), at(1, stage)], [LEAST_OF_RUGGED, LEAST_OF_SMOOTH]);
        let rotor = Location::Motor;
        assert_eq!([at(2, rotor), at(0, rotor)], [LEAST_GAIN, LEAST_OF_SMOOTH]);
        assert_eq!(least_gain(0, 7.0, rotor), LEAST_GAIN);
    }
}
