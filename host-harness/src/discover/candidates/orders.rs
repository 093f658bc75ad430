//! Which orders of an angle explain something: the spectrum, along that angle, of what the
//! prediction errors pull at.
//!
//! Every effect that repeats with an angle pulls the errors in a shape times a sine of that angle.
//! Summed over the record for every order at once, and held against what replicates of the model show
//! at the same order, that is a spectrum in which a line stands out at the order it has, whole or
//! not. What it ranks highest is then tested properly.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

/// A family of lines along one angle.
#[derive(Clone, Debug)]
pub struct Family {
    /// The angle by sample, rad.
    pub angle: Vec<f64>,
    /// What a unit of the effect pulls at by sample: on the record, then on each replicate.
    pub weights: Vec<Vec<f64>>,
    /// Highest order.
    pub highest: f64,
    /// Least periods in the record.
    pub periods: f64,
}

/// Bins per period of the highest order.
const BINS: f64 = 6.0;
/// Points of the spectrum per order that the travel can tell apart.
const FINE: f64 = 4.0;
/// How much stronger a line must be than whole orders beside it before its order is taken as not
/// whole: friction and inertia smear a line, and a rotor has whole orders.
const BROKEN: f64 = 1.6;
/// Least periods in the record of a line whose order is not whole: less is any slow course.
const REPEATS: f64 = 2.0;
/// Longest transform.
const LONGEST: usize = 1 << 22;

/// Distance between the extremes of what is finite of a series.
pub(crate) fn span(series: impl Iterator<Item = f64>) -> f64 {
    let finite = series.filter(|value| value.is_finite());
    let (low, high) =
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), a| (l.min(a), h.max(a)));
    (high - low).max(0.0)
}

impl Family {
    /// Turns between the extremes of the angle.
    pub fn turns(&self) -> f64 {
        span(self.angle.iter().copied()) / std::f64::consts::TAU
    }

    /// Smallest difference of orders that the travel can tell.
    pub fn resolution(&self) -> f64 {
        0.5 / self.turns().max(1e-9)
    }

    /// The orders that stand out most, strongest first: whole ones where the travel can tell whole
    /// orders, others where they are plainly stronger.
    pub fn strongest(&self, count: usize) -> Vec<f64> {
        let turns = self.turns();
        let Some((per_point, power)) = self.spectrum() else { return Vec::new() };
        let strength = |order: f64| {
            let place = order / per_point;
            let (low, share) = (place as usize, place.fract());
            match (power.get(low), power.get(low + 1)) {
                (Some(a), Some(b)) => a.max(*b).min(a * (1.0 - share) + b * share),
                _ => 0.0,
            }
        };
        let least = (self.periods / turns).max(per_point);
        let mut found: Vec<(f64, f64)> = Vec::new();
        let stride = self.resolution().max(1.0).round();
        let whole: Vec<f64> = (1..=(self.highest / stride) as u32)
            .map(|k| f64::from(k) * stride)
            .filter(|order| *order >= least)
            .collect();
        for (k, order) in whole.iter().enumerate() {
            let own = strength(*order);
            let beside = |k: Option<usize>| {
                k.and_then(|k| whole.get(k)).map_or(0.0, |order| strength(*order))
            };
            if own > 0.0 && own >= beside(k.checked_sub(1)).max(beside(Some(k + 1))) {
                found.push((*order, own));
            }
        }
        let repeated = least.max(REPEATS / turns);
        let reach = (1.5 * self.resolution()).max(0.02);
        for k in 1..power.len().saturating_sub(1) {
            let order = k as f64 * per_point;
            let peak = power[k] >= power[k - 1] && power[k] >= power[k + 1];
            if !peak || order < repeated || order > self.highest {
                continue;
            }
            let nearest = order.round();
            let near = strength(order.floor()).max(strength(order.ceil()));
            if (order - nearest).abs() > reach && power[k] > BROKEN * near {
                found.push((order, power[k] / BROKEN));
            }
        }
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        found.into_iter().map(|(order, _)| order).take(count).collect()
    }

    /// Orders per point, and the power at each point in units of what replicates show there.
    fn spectrum(&self) -> Option<(f64, Vec<f64>)> {
        let turns = self.turns();
        let (own, replicates) = self.weights.split_first()?;
        if turns <= 0.0 || self.highest <= 0.0 || replicates.is_empty() {
            return None;
        }
        let wanted = FINE * turns * BINS * self.highest;
        let length = (wanted as usize).next_power_of_two().clamp(64, LONGEST);
        let bins_per_turn = BINS * self.highest;
        let per_point = bins_per_turn / length as f64;
        let points = ((self.highest / per_point) as usize + 2).min(length / 2);
        let mut planner = FftPlanner::new();
        let transform = planner.plan_fft_forward(length);
        let power = |weights: &[f64]| -> Vec<f64> {
            let mut bins = vec![Complex::new(0.0, 0.0); length];
            for (angle, weight) in self.angle.iter().zip(weights) {
                if angle.is_finite() && weight.is_finite() {
                    let place =
                        (angle / std::f64::consts::TAU * bins_per_turn).rem_euclid(length as f64);
                    let (bin, share) = (place as usize, place.fract());
                    bins[bin % length].re += weight * (1.0 - share);
                    bins[(bin + 1) % length].re += weight * share;
                }
            }
            transform.process(&mut bins);
            bins.iter().take(points).map(|bin| bin.norm_sqr()).collect()
        };
        let mut null = vec![0.0; points];
        for replicate in replicates {
            for (sum, value) in null.iter_mut().zip(power(replicate)) {
                *sum += value / replicates.len() as f64;
            }
        }
        let reach = ((2.0 / per_point) as usize).max(4);
        let null = smoothed(&null, reach);
        let own = power(own);
        Some((per_point, own.iter().zip(null).map(|(own, null)| own / null).collect()))
    }
}

/// Means over a window that reaches so far to either side.
fn smoothed(values: &[f64], reach: usize) -> Vec<f64> {
    let mut sums = Vec::with_capacity(values.len() + 1);
    let mut sum = 0.0;
    sums.push(0.0);
    for value in values {
        sum += value;
        sums.push(sum);
    }
    (0..values.len())
        .map(|k| {
            let (from, to) = (k.saturating_sub(reach), (k + reach + 1).min(values.len()));
            ((sums[to] - sums[from]) / (to - from) as f64).max(f64::MIN_POSITIVE)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn family(order: f64, turns: f64) -> Family {
        let mut noise = 1_u64;
        let mut white = || {
            noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_041);
            (noise >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
        };
        let angle: Vec<f64> =
            (0..8000).map(|k| turns * std::f64::consts::TAU * f64::from(k) / 8000.0).collect();
        let own = angle.iter().map(|q| 0.2 * (order * q + 0.3).sin() + white()).collect();
        let replicate = |_| angle.iter().map(|_| white()).collect();
        let replicates: Vec<Vec<f64>> = (0..4).map(replicate).collect();
        let weights = std::iter::once(own).chain(replicates).collect();
        Family { angle: angle.clone(), weights, highest: 60.0, periods: 2.0 }
    }

    #[test]
    fn a_whole_order_is_found_as_whole_whatever_the_travel() {
        for turns in [0.6, 3.3, 41.0] {
            assert_eq!(family(42.0, turns).strongest(3)[0], 42.0, "{turns} turns");
        }
    }

    #[test]
    fn an_order_that_is_not_whole_is_found_where_the_travel_tells() {
        let found = family(3.08, 41.0).strongest(3)[0];
        assert!((found - 3.08).abs() < 0.01, "{found}");
    }

    #[test]
    fn of_less_than_two_periods_only_whole_orders_are_told() {
        let family = Family { periods: 0.7, ..family(0.4, 3.0) };
        let broken = |order: &f64| order.fract() != 0.0 && order * family.turns() < 2.0;
        assert!(!family.strongest(20).iter().any(broken));
    }
}
