//! How sure a name is.
//!
//! Likelihoods tell names apart far more sharply than they deserve: friction laws and sensors that
//! differ slightly from ours move them by some tens. So every lead is counted in units of that size,
//! and what no list has takes its share: more of a name that explains little itself. How sure a name is
//! and how much is left are two questions: a remainder counts against a name only as far as it is
//! predictable and as large as what the name explains, since a smaller name may be a leak of it.

use statrs::distribution::{ContinuousCDF, Normal as Gaussian};

use super::findings::Rival;
use crate::discover::bounds::{SEPARATION, SIGMAS, UNLISTED};
use crate::discover::state::rounds::{Contender, Name, Round};

/// Most odds that are told.
const MOST: f64 = 1e3;

/// What a name stands beside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Left {
    /// Noise.
    Noise,
    /// Something that is not noise: odds of it against the name.
    More(f64),
}

impl Left {
    /// Something that is not noise, of which a generic family predicts the share `unnamed`, beside a name
    /// that explains `share` with its standard error, and comes nearer on unseen samples by `t` of them; as many
    /// names were tried.
    pub(crate) fn more(unnamed: f64, [share, error]: [f64; 2], t: f64, tried: usize) -> Self {
        let least = share - SIGMAS * error;
        if !unnamed.is_finite() || least.is_nan() || least <= 0.0 {
            return Self::More(1.0);
        }
        // The best of so many false names has a larger t by chance with this probability. Samples that tell nothing
        // leave a name as likely as not.
        let by_chance = 1.0 - Gaussian::standard().cdf(t).powi(tried.max(1) as i32);
        let chance = (by_chance / (1.0 - by_chance).max(1e-9)).min(1.0);
        Self::More((unnamed / least + chance).min(MOST))
    }

    fn odds(self) -> f64 {
        match self {
            Self::Noise => UNLISTED,
            Self::More(odds) => odds.max(UNLISTED),
        }
    }
}

/// How sure a name is, and the others that were refitted: its likelihood against theirs and against
/// that of something unlisted, which is told by what is `left`; less where another draw of the log would
/// have had another winner. `other` is what something unlisted explains in the name's place, where that was
/// tried. One of the names `found` is no rival of another: both are needed.
pub(crate) fn confidence(
    round: &Round,
    found: &[Name],
    left: Left,
    other: Option<f64>,
) -> (f64, Vec<Rival>) {
    let odds = |gain: f64| (-(round.gain - gain).max(0.0) / (2.0 * SEPARATION)).exp();
    let unlisted = left.odds().max(odds(other.unwrap_or(0.0)));
    let rival = |rival: &&Contender| rival.name == round.name || !found.contains(&rival.name);
    let rivals = || round.rivals.iter().filter(rival);
    let total = 1.0 + unlisted + rivals().map(|rival| odds(rival.gain)).sum::<f64>();
    let rivals = rivals()
        .map(|rival| Rival {
            kind: rival.name.0.spec().kind.to_owned(),
            location: rival.name.1.to_string(),
            confidence: odds(rival.gain) / total,
            gain: rival.gain,
        })
        .collect();
    (round.stays_ahead / total, rivals)
}

#[cfg(test)]
mod tests {
    use joint_core::effect::Kind;
    use joint_core::params::Location;

    use super::*;

    fn of(gain: f64, rival: Option<f64>, stays_ahead: f64, clean: bool) -> f64 {
        beside(gain, rival, stays_ahead, clean, None)
    }

    fn beside(
        gain: f64,
        rival: Option<f64>,
        stays_ahead: f64,
        clean: bool,
        other: Option<f64>,
    ) -> f64 {
        let name = (Kind::Cogging, Location::Motor);
        let rivals = rival.map(|gain| Contender { name, gain }).into_iter().collect();
        let left = if clean { Left::Noise } else { Left::More(1.0) };
        confidence(
            &Round { name, gain, rivals, runner_up: None, stays_ahead },
            &[name],
            left,
            other,
        )
        .0
    }

    #[test]
    fn a_name_is_certain_only_if_it_explains_much_and_nothing_else_does() {
        assert!((of(5000.0, None, 1.0, true) - 0.98).abs() < 1e-3);
        assert!((of(5000.0, Some(5000.0), 1.0, true) - 0.495).abs() < 1e-3);
        assert!(of(80.0, None, 1.0, true) < 0.9);
        assert!((of(5000.0, None, 1.0, false) - 0.5).abs() < 1e-3);
        assert!((of(5000.0, None, 0.6, true) - 0.6 * 0.98).abs() < 1e-3);
    }

    #[test]
    fn a_remainder_counts_by_what_of_it_is_predictable_beside_what_the_name_explains() {
        let of = |unnamed: f64, share: [f64; 2], t: f64| {
            let name = (Kind::Cogging, Location::Motor);
            let round =
                Round { name, gain: 5000.0, rivals: Vec::new(), runner_up: None, stays_ahead: 1.0 };
            confidence(&round, &[name], Left::more(unnamed, share, t, 30), None).0
        };
        // A large name beside a small remainder, one as large as what is left, and one that may be none.
        assert!(of(0.05, [0.81, 0.03], 8.0) > 0.9);
        assert!((of(0.05, [0.05, 0.0], 8.0) - 0.5).abs() < 1e-6);
        assert!((of(0.0, [0.05, 0.05], 8.0) - 0.5).abs() < 1e-6);
        // The best of thirty false names reaches two standard errors every other time.
        assert!((0.4..0.6).contains(&of(0.0, [0.3, 0.01], 2.0)));
        assert!(of(0.0, [0.3, 0.01], 5.0) > 0.97);
        assert!((of(0.0, [0.3, 0.01], -3.0) - 0.5).abs() < 1e-6);
        assert_eq!(Left::more(0.0, [f64::NAN, 0.0], 5.0, 30), Left::More(1.0));
    }

    #[test]
    fn a_name_that_was_found_beside_it_is_no_rival() {
        let [name, beside] = [(Kind::Cogging, Location::Motor), (Kind::Coating, Location::Output)];
        let rivals = vec![Contender { name: beside, gain: 5000.0 }];
        let round = Round { name, gain: 5000.0, rivals, runner_up: None, stays_ahead: 1.0 };
        let of = |found: &[Name]| confidence(&round, found, Left::Noise, None);
        let [alone, both] = [of(&[name]), of(&[name, beside])];
        assert!((alone.0 - 0.495).abs() < 1e-3 && alone.1.len() == 1);
        assert!((both.0 - 0.98).abs() < 1e-3 && both.1.is_empty());
    }

    #[test]
    fn what_is_on_no_list_takes_its_share_where_it_was_tried() {
        let beside = |other: f64| beside(5000.0, None, 1.0, true, Some(other));
        assert!((beside(5000.0) - 0.5).abs() < 1e-3 && (beside(5100.0) - 0.5).abs() < 1e-3);
        assert!((0.6..0.95).contains(&beside(4950.0)));
        assert!((beside(4000.0) - 0.98).abs() < 1e-3);
    }
}
