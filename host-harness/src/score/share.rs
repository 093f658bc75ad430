//! A share counted, and how far it may be from the one that would be counted over ever more logs.

use serde::Serialize;

/// So many of so many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Share {
    /// How many hold.
    pub count: usize,
    /// Of how many.
    pub of: usize,
    /// 95 % confidence interval of the share, both ends (Wilson, J. Am. Stat. Assoc. 22, 1927).
    pub interval: [f64; 2],
}

/// Standard deviations within which 95 % lie.
const SIGMAS: f64 = 1.96;

impl Share {
    /// The share of the items that hold; `None` of nothing.
    pub fn of<T>(items: impl IntoIterator<Item = T>, holds: impl Fn(&T) -> bool) -> Option<Self> {
        let (mut count, mut of) = (0_usize, 0_usize);
        for item in items {
            of += 1;
            count += usize::from(holds(&item));
        }
        (of > 0).then(|| Self { count, of, interval: wilson(count as f64, of as f64) })
    }

    /// The share itself.
    pub fn value(&self) -> f64 {
        self.count as f64 / self.of as f64
    }
}

impl std::fmt::Display for Share {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [low, high] = self.interval.map(|end| 100.0 * end);
        let share = 100.0 * self.value();
        write!(out, "{share:.1} % ({} of {}; {low:.1} to {high:.1})", self.count, self.of)
    }
}

fn wilson(count: f64, of: f64) -> [f64; 2] {
    let (share, square) = (count / of, SIGMAS * SIGMAS);
    let middle = (share + square / (2.0 * of)) / (1.0 + square / of);
    let half = SIGMAS / (1.0 + square / of)
        * (share * (1.0 - share) / of + square / (4.0 * of * of)).sqrt();
    [(middle - half).max(0.0), (middle + half).min(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Worked by hand for the textbook's ten of ten and five of ten.
    #[test]
    fn the_interval_is_wilsons() {
        let [all, half] = [10, 5].map(|count| Share::of(0..10, |k| *k < count).unwrap().interval);
        assert!((all[0] - 0.7225).abs() < 1e-3 && (all[1] - 1.0).abs() < 1e-12, "{all:?}");
        assert!((half[0] - 0.2366).abs() < 1e-3 && (half[1] - 0.7634).abs() < 1e-3, "{half:?}");
        assert_eq!(Share::of(0..0, |_| true), None);
    }
}
