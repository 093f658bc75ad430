//! A log through smooth windows: means, rates and accelerations of the same stretch of time.
//!
//! Differences of encoder counts are noise. Weighted by φ(s) = (1 − s²)³ over a window, s from −1 to 1, a
//! derivative moves onto φ by partial integration (modulating functions, Shinbrot 1957): ∫φ q̇ = −∫φ̇ q
//! and ∫φ q̈ = ∫φ̈ q. All signals pass the same filter, so that an equation that holds between them holds
//! between their windows.

use crate::grid::GAP;
use crate::log::Log;

use super::regression::median;

/// Fewest samples of a window: quadrature of φ̈ over 8 intervals is good to a thousandth.
pub(super) const FEWEST: usize = 8;
/// Most windows that are looked at; those of a longer log lie further apart.
const MOST: usize = 20_000;
/// Ratio of signal to noise that an acceleration needs: noise in it then biases by four hundredths.
const CLEAR: f64 = 5.0;

/// Where the windows of a log lie.
#[derive(Clone, Debug)]
pub(super) struct Windows {
    /// First samples and numbers of samples.
    pub(super) width: usize,
    starts: Vec<usize>,
    typical_s: f64,
}

/// The typical interval between samples, s.
pub(super) fn typical_interval(time_s: &[f64]) -> f64 {
    let step = time_s.len() / 100_000 + 1;
    let pairs = time_s.windows(2).step_by(step).map(|pair| pair[1] - pair[0]);
    median(pairs.collect()).unwrap_or(1.0)
}

/// One window's weights.
struct Weights<'a> {
    time_s: &'a [f64],
    middle: f64,
    half: f64,
}

impl Weights<'_> {
    /// φ, φ̇ and φ̈ at a time.
    fn phi(&self, time: f64) -> [f64; 3] {
        let s = (time - self.middle) / self.half;
        let r = (1.0 - s * s).max(0.0);
        let rate = -6.0 * s * r * r / self.half;
        let second = (24.0 * s * s * r - 6.0 * r * r) / (self.half * self.half);
        [r * r * r, rate, second]
    }

    /// The trapezoid's share of a sample.
    fn share(&self, k: usize) -> f64 {
        let before = if k > 0 { self.time_s[k] - self.time_s[k - 1] } else { 0.0 };
        let after = self.time_s.get(k + 1).map_or(0.0, |next| next - self.time_s[k]);
        0.5 * (before + after)
    }
}

impl Windows {
    /// Windows of so many samples, a quarter of one apart; none over a gap of the clock.
    pub(super) fn of(time_s: &[f64], width: usize) -> Self {
        let typical_s = typical_interval(time_s);
        let width = width.max(FEWEST);
        let stride = (width / 4).max(time_s.len() / MOST);
        let whole = |start: &usize| {
            let span = time_s[start + width] - time_s[*start];
            span < (width as f64 + GAP) * typical_s
        };
        let last = time_s.len().saturating_sub(width);
        let starts = (0..last).step_by(stride.max(1)).filter(whole).collect();
        Self { width, starts, typical_s }
    }

    pub(super) fn len(&self) -> usize {
        self.starts.len()
    }

    /// Length of a window, s.
    pub(super) fn length_s(&self) -> f64 {
        self.width as f64 * self.typical_s
    }

    fn each<'a>(&'a self, time_s: &'a [f64]) -> impl Iterator<Item = (usize, Weights<'a>)> {
        self.starts.iter().map(move |start| {
            let own = &time_s[*start..=start + self.width];
            let (from, to) = (own[0], own[self.width]);
            (*start, Weights { time_s: own, middle: 0.5 * (from + to), half: 0.5 * (to - from) })
        })
    }

    /// Means of a signal that is sampled at its instants; NaN where a sample is missing.
    pub(super) fn means(&self, time_s: &[f64], values: &[f64]) -> Vec<f64> {
        let mean = |(start, weights): (usize, Weights<'_>)| {
            let (mut sum, mut whole) = (0.0, 0.0);
            for k in 0..=self.width {
                let weight = weights.share(k) * weights.phi(weights.time_s[k])[0];
                sum += weight * values[start + k];
                whole += weight;
            }
            sum / whole
        };
        self.each(time_s).map(mean).collect()
    }

    /// Means of a signal that is held from its instant to the next.
    pub(super) fn held_means(&self, time_s: &[f64], values: &[f64]) -> Vec<f64> {
        let mean = |(start, weights): (usize, Weights<'_>)| {
            let (mut sum, mut whole) = (0.0, 0.0);
            for k in 0..self.width {
                let (from, to) = (weights.time_s[k], weights.time_s[k + 1]);
                let weight = (to - from) * weights.phi(0.5 * (from + to))[0];
                sum += weight * values[start + k];
                whole += weight;
            }
            sum / whole
        };
        self.each(time_s).map(mean).collect()
    }

    /// Rates and accelerations of a signal.
    pub(super) fn derivatives(&self, time_s: &[f64], values: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let both = |(start, weights): (usize, Weights<'_>)| {
            let own = &values[start..=start + self.width];
            // A straight line is taken off first: quadrature then errs on what is left of it alone.
            let slope = (own[self.width] - own[0]) / (2.0 * weights.half);
            let (mut rate, mut second, mut whole) = (0.0, 0.0, 0.0);
            for k in 0..=self.width {
                let time = weights.time_s[k];
                let [phi, dot, dots] = weights.phi(time);
                let share = weights.share(k);
                let off = own[k] - own[0] - slope * (time - weights.time_s[0]);
                rate -= share * dot * off;
                second += share * dots * off;
                whole += share * phi;
            }
            (slope + rate / whole, second / whole)
        };
        self.each(time_s).map(both).unzip()
    }

    /// Standard deviations of rate and acceleration for an angle that scatters by one.
    pub(super) fn noise(&self) -> (f64, f64) {
        let half = 0.5 * self.length_s();
        // ∫φ² of φ̇ and φ̈ by quadrature over s, over ∫φ = 32/35.
        let count = 400;
        let unit = Weights { time_s: &[], middle: 0.0, half: 1.0 };
        let sums = (0..count).fold([0.0; 2], |sums, k| {
            let [_, dot, dots] = unit.phi(2.0 * (f64::from(k) + 0.5) / f64::from(count) - 1.0);
            [sums[0] + dot * dot, sums[1] + dots * dots]
        });
        let scaled = |sum: f64| (sum * 2.0 / f64::from(count)).sqrt() / (32.0 / 35.0);
        let samples = (0.5 * self.width as f64).sqrt();
        (scaled(sums[0]) / half / samples, scaled(sums[1]) / half / half / samples)
    }

    /// The shortest windows, of at least `longer_than_s`, through which the angle's acceleration stands out
    /// of its noise; the longest that leave enough rows where none does.
    pub(super) fn clear(log: &Log, angle: &[f64], longer_than_s: f64) -> Self {
        let typical = typical_interval(&log.time_s);
        let most = (angle.len() / 30).max(FEWEST);
        let mut width = ((longer_than_s / typical).ceil() as usize).clamp(FEWEST, most);
        let scatter = scatter(angle);
        loop {
            let windows = Self::of(&log.time_s, width);
            let (_, accelerations) = windows.derivatives(&log.time_s, angle);
            let there = accelerations.iter().filter(|value| value.is_finite());
            let (sum, count) = there.fold((0.0, 0.0), |(s, n), a| (s + a * a, n + 1.0));
            let noise = windows.noise().1 * scatter;
            if (sum / f64::max(count, 1.0)).sqrt() > CLEAR * noise || width >= most {
                return windows;
            }
            width = (2 * width).min(most);
        }
    }
}

/// The difference of a channel's largest and smallest known value.
pub(super) fn travel(values: &[f64]) -> f64 {
    let [low, high] = extremes(values);
    (high - low).max(0.0)
}

/// The smallest and the largest known value.
pub(super) fn extremes(values: &[f64]) -> [f64; 2] {
    let known = values.iter().filter(|value| value.is_finite());
    known.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(*v), high.max(*v)])
}

/// How an encoder's samples scatter, rad: by their third differences, and by the step of its counts.
pub(crate) fn scatter(angle: &[f64]) -> f64 {
    let stride = angle.len() / 200_000 + 1;
    let four =
        || angle.windows(4).step_by(stride).filter(|four| four.iter().all(|a| a.is_finite()));
    let third = |four: &[f64]| four[3] - 3.0 * four[2] + 3.0 * four[1] - four[0];
    let (sum, count) =
        four().map(third).fold((0.0, 0.0), |(sum, count), d| (sum + d * d, count + 1.0));
    // The variance of a third difference of white noise is 20 times its own.
    let white = (sum / f64::max(count, 1.0) / 20.0).sqrt();
    let largest = four().map(|four| four[0].abs()).fold(0.0, f64::max);
    let second = |four: &[f64]| (four[2] - 2.0 * four[1] + four[0]).abs();
    let step = four().map(second).filter(|d| *d > 1e-9 * largest).fold(f64::INFINITY, f64::min);
    if step.is_finite() { white.max(step / 12.0_f64.sqrt()) } else { white }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(even: bool) -> Log {
        let uneven = |k: usize| if even { 0.0 } else { 0.3 * ((k * 7919) % 13) as f64 / 13.0 };
        let time_s: Vec<f64> = (0..4000).map(|k| 1e-3 * (k as f64 + uneven(k))).collect();
        let motor_angle_rad = time_s.iter().map(|t| 5.0 * t + (20.0 * t).sin()).collect();
        Log { time_s, motor_angle_rad, ..Log::default() }
    }

    #[test]
    fn rates_and_accelerations_are_those_of_the_signal_through_the_same_window() {
        for even in [true, false] {
            let log = log(even);
            let windows = Windows::of(&log.time_s, 40);
            let (rates, accelerations) = windows.derivatives(&log.time_s, &log.motor_angle_rad);
            let of =
                |f: &dyn Fn(f64) -> f64| -> Vec<f64> { log.time_s.iter().map(|t| f(*t)).collect() };
            let speed = windows.means(&log.time_s, &of(&|t| 5.0 + 20.0 * (20.0 * t).cos()));
            let second = windows.means(&log.time_s, &of(&|t| -400.0 * (20.0 * t).sin()));
            for k in 0..windows.len() {
                assert!((rates[k] - speed[k]).abs() < 0.02, "{} {}", rates[k], speed[k]);
                assert!(
                    (accelerations[k] - second[k]).abs() < 4.0,
                    "{} {}",
                    accelerations[k],
                    second[k]
                );
            }
        }
    }

    #[test]
    fn the_noise_of_an_acceleration_is_as_told() {
        let mut random = <rand_chacha::ChaCha8Rng as rand::SeedableRng>::seed_from_u64(4);
        let white = || 12.0_f64.sqrt() * (rand::RngExt::random::<f64>(&mut random) - 0.5);
        let angle: Vec<f64> = std::iter::repeat_with(white).take(40_000).collect();
        let time_s: Vec<f64> = (0..angle.len()).map(|k| 1e-3 * k as f64).collect();
        let windows = Windows::of(&time_s, 40);
        let (_, accelerations) = windows.derivatives(&time_s, &angle);
        let rms =
            (accelerations.iter().map(|a| a * a).sum::<f64>() / accelerations.len() as f64).sqrt();
        assert!((rms / windows.noise().1 - 1.0).abs() < 0.1, "{rms}");
        assert!((scatter(&angle) - 1.0).abs() < 0.05);
    }

    #[test]
    fn no_window_lies_over_a_gap() {
        let mut log = log(true);
        log.time_s[2000..].iter_mut().for_each(|t| *t += 1.0);
        let windows = Windows::of(&log.time_s, 40);
        assert!(windows.starts.iter().all(|s| s + 40 < 2000 || *s >= 2000));
    }
}
