//! How the share that the effects explain together is divided between them.
//!
//! All effects together are weighed by the disturbance that they take away. One of several is weighed by what
//! it gains in likelihood, given all the others, which every equation has in common: an effect of a sensor and
//! one of a gear then stand in one list.

use super::blocks::{Share, jackknifed};

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

/// Each effect's share, by what each gains in each block.
pub(super) fn divided(gone: &Disturbances, gains: &[Vec<f64>]) -> Vec<Share> {
    (0..gains.len())
        .map(|own| {
            jackknifed(gone.before.len(), |kept| {
                let weight = |effect: &[f64]| -> f64 {
                    kept.clone().map(|k| effect[k]).sum::<f64>().max(0.0)
                };
                let all: f64 = gains.iter().map(|effect| weight(effect)).sum();
                let part = if all > 0.0 { weight(&gains[own]) / all } else { 0.0 };
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
        let gains = [vec![3.0, 3.0, 2.0], vec![1.0, 1.0, 0.0], vec![-1.0, 0.5, 0.2]];
        let shares = divided(&gone, &gains);
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

    #[test]
    fn effects_that_gain_nothing_have_no_share_of_what_is_gone() {
        let gone = Disturbances { before: vec![1.0; 4], after: vec![0.5; 4] };
        assert_eq!(divided(&gone, &[vec![0.0; 4]])[0], Share { value: 0.0, error: 0.0 });
    }
}
