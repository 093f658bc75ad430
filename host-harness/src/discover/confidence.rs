//! How sure a name is.
//!
//! Likelihoods tell names apart far more sharply than they deserve: friction laws and sensors that
//! differ slightly from ours move them by some tens. So every lead is counted in units of that size,
//! and what no list has takes its share: more of a name that explains little itself.

use super::findings::Rival;
use super::search::Round;

/// Units of log-likelihood that separate two names by a factor e: friction laws and sensors that
/// differ slightly from ours move likelihoods by some tens.
pub(super) const SEPARATION: f64 = 25.0;
/// Odds of something unlisted against a name that leaves noise, however much it explains.
const UNLISTED: f64 = 0.02;

/// How sure a name is, and the others that were refitted: its likelihood against theirs and against
/// that of something unlisted, which is as likely as the name where the gate complains (`clean` is
/// false); less where another draw of the log would have had another winner. `other` is what something
/// unlisted explains in the name's place, where that was tried.
pub(super) fn confidence(round: &Round, clean: bool, other: Option<f64>) -> (f64, Vec<Rival>) {
    let odds = |gain: f64| (-(round.gain - gain).max(0.0) / (2.0 * SEPARATION)).exp();
    let unlisted = if clean { UNLISTED.max(odds(other.unwrap_or(0.0))) } else { 1.0 };
    let total = 1.0 + unlisted + round.rivals.iter().map(|rival| odds(rival.gain)).sum::<f64>();
    let rivals = round
        .rivals
        .iter()
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

    use super::super::search::Contender;
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
        confidence(&Round { name, gain, rivals, runner_up: None, stays_ahead }, clean, other).0
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
    fn what_is_on_no_list_takes_its_share_where_it_was_tried() {
        let beside = |other: f64| beside(5000.0, None, 1.0, true, Some(other));
        assert!((beside(5000.0) - 0.5).abs() < 1e-3 && (beside(5100.0) - 0.5).abs() < 1e-3);
        assert!((0.6..0.95).contains(&beside(4950.0)));
        assert!((beside(4000.0) - 0.98).abs() < 1e-3);
    }
}
