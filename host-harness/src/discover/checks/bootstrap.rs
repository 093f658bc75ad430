//! How often a name would have come first had the log come out a little otherwise.
//!
//! A likelihood that is higher by hundreds may owe all of it to one moment of the log. So the log
//! is cut into blocks, long enough to be independent of each other, and drawn anew from them with
//! repetition (Künsch, Ann. Stat. 17, 1989); the name has to stay ahead of its rivals, and of the
//! model without it, in what was drawn.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::estimate::fit::Fit;

/// Blocks that a log is cut into.
const BLOCKS: usize = 50;
/// Logs that are drawn.
const DRAWS: usize = 1000;
/// The draws are the same every time.
const SEED: u64 = 17;

/// Share of the drawn logs in which a fit stays likelier than all others, priors included; never
/// quite none or all. `mask` weighs the samples that were fitted to.
pub(crate) fn stays_ahead(fit: &Fit, others: &[&Fit], mask: &[f64]) -> f64 {
    let own = fit.deviances(mask);
    let lead = |other: &&Fit| (blocks(&own, &other.deviances(mask)), other.prior - fit.prior);
    share_ahead(&others.iter().map(lead).collect::<Vec<_>>())
}

/// The same of leads: by block, and before any.
fn share_ahead(leads: &[([f64; BLOCKS], f64)]) -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let ahead = (0..DRAWS).filter(|_| {
        let drawn: [usize; BLOCKS] = std::array::from_fn(|_| random.random_range(0..BLOCKS));
        let lead = |(blocks, before): &([f64; BLOCKS], f64)| {
            drawn.iter().map(|block| blocks[*block]).sum::<f64>() + before
        };
        // A rival that is non-finite is behind.
        !leads.iter().any(|other| lead(other) <= 0.0)
    });
    (ahead.count() as f64 + 0.5) / (DRAWS + 1) as f64
}

/// By how much one is likelier than another in each block of a log.
fn blocks(own: &[f64], other: &[f64]) -> [f64; BLOCKS] {
    let (mut blocks, count) = ([0.0; BLOCKS], own.len());
    for (k, (own, other)) in own.iter().zip(other).enumerate() {
        blocks[k * BLOCKS / count] += other - own;
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lead_counts_by_how_evenly_it_is_earned() {
        let own = [1.0; 5000];
        let evenly = (blocks(&own, &[1.02; 5000]), 0.0);
        let at_once = (
            blocks(&own, &std::array::from_fn::<_, 5000, _>(|k| if k == 99 { 101.0 } else { 1.0 })),
            -1.0,
        );
        assert!((evenly.0.iter().sum::<f64>() - 100.0).abs() < 1e-6);
        assert!(share_ahead(&[evenly]) > 0.999);
        // The block that holds the moment is drawn at least once in 1 − (1 − 1/50)^50 of the logs.
        let once = share_ahead(&[at_once]);
        assert!((once - 0.636).abs() < 0.05, "{once}");
        assert!((share_ahead(&[evenly, at_once]) - once).abs() < 1e-12);
        assert!(share_ahead(&[(evenly.0, -200.0)]) < 0.001);
    }
}
