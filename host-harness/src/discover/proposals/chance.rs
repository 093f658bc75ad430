//! What a score means: what replicates reach by chance, and which lines are worth telling the reader.

use super::score_test::Gain;
use crate::discover::bounds::{CHANCE_SIGMAS, LEAST_GAIN};

/// The orders that are worth telling, strongest first; `best` is the best hypothesis' score.
pub(crate) fn told(lines: &[(f64, Gain)], best: f64, by_chance: f64) -> Vec<f64> {
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
pub(crate) fn threshold<'a>(gains: impl Iterator<Item = &'a Gain>) -> f64 {
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
    mean + CHANCE_SIGMAS * spread
}
