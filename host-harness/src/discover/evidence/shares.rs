//! How the share that the effects explain together is divided between them.
//!
//! All effects together are weighed by the disturbance that they take away. One of several is weighed by what
//! its loss costs in prediction errors, which every equation has in common: an effect of a sensor and one of
//! a gear then stand in one list.

use rayon::prelude::*;

use super::blocks::{Blocks, Share, jackknifed};
use crate::estimate::filter::Gains;
use crate::estimate::fit::Problem;
use crate::estimate::record::CHANNELS;
use crate::model::Model;
use crate::plant::BuildError;

/// Squares of a disturbance by block: what the refitted nominal leaves, and the improved model.
pub(super) struct Disturbances {
    pub(super) before: Vec<f64>,
    pub(super) after: Vec<f64>,
}

impl Disturbances {
    /// Share that is gone, over the blocks that are kept.
    fn gone(&self, kept: impl Iterator<Item = usize> + Clone) -> f64 {
        let sum = |values: &[f64]| -> f64 { kept.clone().map(|k| values[k]).sum() };
        let before = sum(&self.before);
        if before > 0.0 { ((before - sum(&self.after)) / before).max(0.0) } else { 0.0 }
    }

    /// Share that is gone.
    pub(super) fn named(&self) -> Share {
        jackknifed(self.before.len(), |kept| self.gone(kept))
    }
}

/// Squares of prediction errors by block that the loss of each effect at these places of a model brings, if
/// all else stays; zero where one explains nothing.
///
/// # Errors
/// A model cannot be built.
pub(super) fn losses(
    problem: &Problem<'_>,
    model: &Model,
    gains: &Gains,
    places: &[usize],
    blocks: &Blocks,
) -> Result<Vec<Vec<f64>>, BuildError> {
    let squares = |model: &Model| -> Result<Vec<f64>, BuildError> {
        let rows = problem.innovations(model, gains)?;
        let own: Vec<f64> = rows.iter().map(square).collect();
        let sum = |range: &std::ops::Range<usize>| own[range.clone()].iter().sum();
        Ok(blocks.ranges().iter().map(sum).collect())
    };
    let whole = squares(model)?;
    let lost = places.par_iter().map(|place| {
        let mut without = model.clone();
        without.effects.remove(*place);
        let lost = squares(&without)?;
        Ok(lost.iter().zip(&whole).map(|(lost, whole)| lost - whole).collect())
    });
    lost.collect()
}

/// Most that a prediction error counts for, in sigmas: a model without its effect may diverge.
const MOST: f64 = 1e3;

fn square(row: &[f64; CHANNELS]) -> f64 {
    let bounded = |e: &f64| if e.is_finite() { e.abs().min(MOST) } else { MOST };
    row.iter().map(|e| bounded(e).powi(2)).sum()
}

/// Each effect's share.
pub(super) fn divided(gone: &Disturbances, losses: &[Vec<f64>]) -> Vec<Share> {
    (0..losses.len())
        .map(|own| {
            jackknifed(gone.before.len(), |kept| {
                let weight = |effect: &[f64]| -> f64 {
                    kept.clone().map(|k| effect[k]).sum::<f64>().max(0.0)
                };
                let all: f64 = losses.iter().map(|effect| weight(effect)).sum();
                let part = if all > 0.0 { weight(&losses[own]) / all } else { 0.0 };
                part * gone.gone(kept)
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_add_up_to_what_is_gone() {
        let gone = Disturbances { before: vec![10.0, 12.0, 8.0], after: vec![1.0, 2.0, 0.0] };
        let losses = [vec![3.0, 3.0, 2.0], vec![1.0, 1.0, 0.0], vec![-1.0, 0.5, 0.2]];
        let shares = divided(&gone, &losses);
        let sum: f64 = shares.iter().map(|share| share.value).sum();
        assert!((sum - 0.9).abs() < 1e-12 && (gone.named().value - 0.9).abs() < 1e-12);
        assert!((shares[0].value - 0.72).abs() < 1e-12, "{shares:?}");
        assert_eq!(shares[2].value, 0.0);
        assert!(shares.iter().all(|share| share.error.is_finite()));
    }

    #[test]
    fn effects_that_make_it_worse_have_no_share() {
        let gone = Disturbances { before: vec![1.0; 4], after: vec![2.0; 4] };
        assert_eq!(gone.named(), Share { value: 0.0, error: 0.0 });
        assert_eq!(divided(&gone, &[vec![5.0; 4]])[0].value, 0.0);
    }
}
