//! What an encoder's readings scatter by, told from the readings alone.
//!
//! A sheet says how many counts a turn has, a file has its last digit; what disturbs a reading is often far
//! more: its stamp, which jitters by a part of an interval, moves it by its speed. Over a few samples a shaft
//! moves along a polynomial, and scatter does not: divided differences of order k leave of smooth motion
//! nothing, and of white scatter of one sigma, weighted to a length of one, one sigma (von Neumann et al.,
//! Ann. Math. Stat. 12, 1941, for differences of order one). Of motion every order leaves less than the one
//! before, of white scatter as much: where no order comes to that, the readings do not tell.
//!
//! Its variance is that of the encoder and that of the clock, `s² + (τ v)²` at a speed v, by maximum likelihood.

use std::ops::Range;

/// Orders of differences that are tried.
const ORDERS: Range<usize> = 2..9;
/// Most windows that are looked at, and fewest that tell anything.
const MOST: usize = 20_000;
const FEWEST: usize = 100;
/// Rounds of the likelihood's maximum.
const ROUNDS: usize = 100;
/// Share of its variance that the next order leaves of white scatter at least: of motion at half the highest
/// frequency it leaves half.
const WHITE: f64 = 0.9;
/// A square beyond so many times its variance counts as that: a reading that is plainly wrong is not noise.
const OUTLIER: f64 = 25.0;

/// What an encoder's readings scatter by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scatter {
    /// One sigma of the encoder itself, rad.
    pub(super) sigma_rad: f64,
    /// One sigma of the clock, s: a reading is off by it times the speed; zero unless that is most of the
    /// scatter.
    pub(super) jitter_s: f64,
    /// How many independent squares say so.
    witnesses: f64,
}

impl Scatter {
    /// Of readings at these times; `None` where the shaft hardly turns, or there are few.
    pub(super) fn of(
        time_s: &[f64],
        angle_rad: &[f64],
        starts: &[usize],
        step_rad: f64,
    ) -> Option<Self> {
        let windows = ORDERS.filter_map(|order| Windows::of(order, time_s, angle_rad, starts));
        let windows: Vec<Windows> = windows.collect();
        let white = windows.windows(2).find(|pair| pair[1].mean() > WHITE * pair[0].mean());
        let best = &white?[1];
        let moving = best.moving(step_rad);
        if moving.squares.len() < FEWEST {
            return None;
        }
        let (least, witnesses) = (step_rad * step_rad / 12.0, moving.witnesses());
        let plain = moving.fitted(least, false);
        let jittered = moving.fitted(least, true);
        let gain = (moving.deviance(plain) - moving.deviance(jittered)) / (best.order as f64 + 1.0);
        let [encoder, clock] = jittered;
        // A clock whose jitter is less than what the encoder adds changes no weight by much.
        let most = clock * moving.mean_square_speed() > encoder;
        let [encoder, clock] = if most && gain > bound(witnesses) { jittered } else { plain };
        Some(Self { sigma_rad: encoder.sqrt(), jitter_s: clock.sqrt(), witnesses })
    }

    /// Whether most of it is not what an encoder of this sigma leaves, rad.
    pub(super) fn exceeds(&self, sigma_rad: f64) -> bool {
        let ratio = (self.sigma_rad / sigma_rad).powi(2);
        ratio > 2.0 && self.witnesses * (ratio - 1.0 - ratio.ln()) > bound(self.witnesses)
    }
}

/// What one number more must gain of minus twice the log-likelihood (Schwarz, Ann. Stat. 6, 1978).
fn bound(witnesses: f64) -> f64 {
    witnesses.ln()
}

/// Squares of differences over windows, and what moved there.
struct Windows {
    order: usize,
    squares: Vec<f64>,
    /// Squared speed, rad²/s².
    speeds: Vec<f64>,
    /// Way, rad.
    ways: Vec<f64>,
}

impl Windows {
    fn of(order: usize, time_s: &[f64], angle_rad: &[f64], starts: &[usize]) -> Option<Self> {
        let last = time_s.len().checked_sub(order + 1)?;
        let typical = (time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1) as f64;
        let stride = last / MOST + 1;
        let mut all = Self { order, squares: Vec::new(), speeds: Vec::new(), ways: Vec::new() };
        for first in (0..=last).step_by(stride) {
            let window = first..first + order + 1;
            let begins = starts.partition_point(|start| *start <= window.start);
            if starts.get(begins).is_some_and(|start| *start < window.end) {
                continue;
            }
            let (times, angles) = (&time_s[window.clone()], &angle_rad[window]);
            let left = difference(times, angles, typical);
            let way = angles[order] - angles[0];
            if left.is_finite() && way.is_finite() {
                all.squares.push(left * left);
                all.speeds.push((way / (times[order] - times[0])).powi(2));
                all.ways.push(way.abs());
            }
        }
        (all.squares.len() >= FEWEST).then_some(all)
    }

    fn mean(&self) -> f64 {
        self.squares.iter().sum::<f64>() / self.squares.len() as f64
    }

    /// Those over which the shaft turns by a step of the encoder a sample: slower, rounding is no noise.
    fn moving(&self, step_rad: f64) -> Self {
        let least = self.order as f64 * step_rad;
        let of = |values: &[f64]| {
            let pairs = values.iter().zip(&self.ways);
            pairs.filter(|(_, way)| **way > least).map(|(value, _)| *value).collect()
        };
        Self {
            order: self.order,
            squares: of(&self.squares),
            speeds: of(&self.speeds),
            ways: of(&self.ways),
        }
    }

    /// Windows that share no sample.
    fn witnesses(&self) -> f64 {
        self.squares.len() as f64 / (self.order + 1) as f64
    }

    fn mean_square_speed(&self) -> f64 {
        self.speeds.iter().sum::<f64>() / self.speeds.len() as f64
    }

    /// The squares, outliers bounded, with their variances and squared speeds.
    fn bounded(&self, [encoder, clock]: [f64; 2]) -> impl Iterator<Item = [f64; 3]> {
        self.squares.iter().zip(&self.speeds).map(move |(square, speed)| {
            let variance = encoder + clock * speed;
            [square.min(OUTLIER * variance), variance, *speed]
        })
    }

    fn deviance(&self, variances: [f64; 2]) -> f64 {
        self.bounded(variances).map(|[square, variance, _]| variance.ln() + square / variance).sum()
    }

    /// Variances of encoder, at `least` this, and clock, by steps that keep them positive.
    fn fitted(&self, least: f64, with_clock: bool) -> [f64; 2] {
        let mean = self.mean().max(least);
        let [mut encoder, mut clock] = match with_clock {
            true => [0.5 * mean, 0.5 * mean / self.mean_square_speed().max(f64::MIN_POSITIVE)],
            false => [mean, 0.0],
        };
        for _ in 0..ROUNDS {
            let mut sums = [[0.0; 2]; 2];
            for [square, variance, speed] in self.bounded([encoder, clock]) {
                for (sum, of) in sums.iter_mut().zip([1.0, speed]) {
                    sum[0] += of * square / (variance * variance);
                    sum[1] += of / variance;
                }
            }
            let step = |[up, down]: [f64; 2]| if down > 0.0 { up / down } else { 1.0 };
            let next = [(encoder * step(sums[0])).max(least), clock * step(sums[1])];
            let settled = (next[0] - encoder).abs() < 1e-4 * encoder
                && (next[1] - clock).abs() <= 1e-4 * clock;
            [encoder, clock] = next;
            if settled {
                break;
            }
        }
        [encoder, clock]
    }
}

/// The divided difference of these readings, weighted to a length of one.
fn difference(times: &[f64], angles: &[f64], typical_s: f64) -> f64 {
    let (mut sum, mut squares) = (0.0, 0.0);
    for (i, (own, angle)) in times.iter().zip(angles).enumerate() {
        let others = times.iter().enumerate().filter(|(j, _)| *j != i);
        let weight: f64 = others.map(|(_, other)| typical_s / (own - other)).product();
        sum += weight * (angle - angles[0]);
        squares += weight * weight;
    }
    sum / squares.sqrt()
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// A shaft that swings, seen by an encoder of so many counts a turn and a clock that jitters.
    fn seen(counts: f64, white_rad: f64, jitter_s: f64) -> Option<Scatter> {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
        let step = std::f64::consts::TAU / counts;
        let time_s: Vec<f64> = (0..6000).map(|k| 1e-3 * f64::from(k)).collect();
        let angle = time_s.iter().map(|t| {
            let then = t + jitter_s * normal();
            let angle = 3.0 * (9.0 * then).sin() + 2.0 * (4.0 * then).cos();
            ((angle + white_rad * normal()) / step).round() * step
        });
        let angle: Vec<f64> = angle.collect();
        Scatter::of(&time_s, &angle, &[0], step)
    }

    #[test]
    fn an_encoder_that_only_rounds_scatters_by_its_counts() {
        let scatter = seen(20_000.0, 0.0, 0.0).unwrap();
        let count = std::f64::consts::TAU / 20_000.0 / 12.0_f64.sqrt();
        assert!(!scatter.exceeds(count) && scatter.jitter_s == 0.0, "{scatter:?}");
        assert!(scatter.exceeds(0.5 * count));
    }

    #[test]
    fn white_scatter_and_a_clocks_jitter_are_told_apart() {
        // A thousand squares and more tell a sigma to a few per cent.
        let white = seen(1e6, 3e-4, 0.0).unwrap();
        assert!((white.sigma_rad / 3e-4 - 1.0).abs() < 0.1 && white.jitter_s == 0.0, "{white:?}");
        let jitter = seen(1e6, 1e-5, 5e-5).unwrap();
        assert!((jitter.jitter_s / 5e-5 - 1.0).abs() < 0.1, "{jitter:?}");
        assert!(jitter.sigma_rad < 1e-4, "{jitter:?}");
    }

    #[test]
    fn a_wrong_reading_is_no_noise_and_a_shaft_at_rest_tells_nothing() {
        let time_s: Vec<f64> = (0..2000).map(|k| 1e-3 * f64::from(k)).collect();
        let mut angle: Vec<f64> =
            time_s.iter().map(|t| (1e4 * (5.0 * t).sin()).round() * 1e-4).collect();
        angle[700] += 1.0;
        let scatter = Scatter::of(&time_s, &angle, &[0], 1e-4).unwrap();
        assert!(scatter.sigma_rad < 1e-4, "{scatter:?}");
        assert_eq!(Scatter::of(&time_s, &vec![0.3; 2000], &[0], 1e-4), None);
        assert_eq!(Scatter::of(&time_s[..20], &angle[..20], &[0], 1e-4), None);
    }
}
