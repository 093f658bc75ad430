//! Whether a joint moves where its log begins: an encoder that has gone by more than its counts tells.

/// Samples over which a speed is taken where a joint may be in motion.
const CATCH: usize = 8;
/// The same where it moves by few counts.
const LONGEST_CATCH: usize = 64;
/// Smallest steps of an encoder that a joint goes in as many samples for its motion to be told from
/// one that begins.
const SHOWN: f64 = 6.0;

/// Whether an encoder shows a joint that moves already at its first sample: it then goes as far in the
/// first half of a few samples as in the second, where from rest it goes a quarter.
pub(super) fn moves_at_once(angle_rad: &[f64]) -> bool {
    let Some(window) = caught(angle_rad) else { return false };
    let [first, half, last] = [0, window / 2, window].map(|k| angle_rad[k]);
    let (early, late) = (half - first, last - half);
    early * late > 0.0 && early.abs() > 0.6 * late.abs()
}

/// From the first sample on, the fewest samples over which an encoder shows a motion by more than its
/// counts; `None` where it hardly moves.
pub(super) fn caught(angle_rad: &[f64]) -> Option<usize> {
    let mut window = CATCH;
    while window <= LONGEST_CATCH && window < angle_rad.len() {
        let seen = &angle_rad[..=window];
        let steps = seen.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let count = steps.filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
        if (seen[window] - seen[0]).abs() > SHOWN * count {
            return Some(window);
        }
        window *= 2;
    }
    None
}
