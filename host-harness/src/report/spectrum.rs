//! A disturbance by order of the motor angle, and over a wind-up that grows and falls.

use std::f64::consts::TAU;

use crate::discover::findings::Disturbance;

/// Orders that are looked at besides those that were named.
const ORDERS: u32 = 48;
/// Turns that a joint has to go for orders of its angle to be told apart.
const TURNS: f64 = 2.0;
/// Bins of a wind-up.
const BINS: usize = 32;
/// Samples that a bin has at least.
const LEAST: f64 = 8.0;

/// Order, amplitude before and after: whole orders and those that were named. Nothing where the joint went too
/// few turns.
pub(super) fn spectrum(angle_rad: &[f64], named: &[f64], push: &Disturbance) -> Vec<[f64; 3]> {
    let known = || angle_rad.iter().copied().filter(|angle| angle.is_finite());
    let ends = known().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], angle| {
        [low.min(angle), high.max(angle)]
    });
    if ends[1] - ends[0] < TURNS * TAU || angle_rad.len() != push.before.len() {
        return Vec::new();
    }
    let highest = named.iter().fold(0.0_f64, |most, order| most.max(*order));
    let last = ORDERS.max((1.25 * highest.min(400.0)) as u32);
    let mut orders: Vec<f64> = (1..=last).map(f64::from).collect();
    orders.extend(named.iter().filter(|order| order.fract() != 0.0));
    orders.sort_by(f64::total_cmp);
    let amplitude = |order: f64, values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let (mut cos, mut sin) = (0.0, 0.0);
        for (angle, value) in angle_rad.iter().zip(values) {
            let (s, c) = (order * angle).sin_cos();
            cos += (value - mean) * c;
            sin += (value - mean) * s;
        }
        2.0 * cos.hypot(sin) / values.len() as f64
    };
    orders
        .into_iter()
        .map(|order| [order, amplitude(order, &push.before), amplitude(order, &push.after)])
        .collect()
}

/// Means of a disturbance by bin of the wind-up, while it grows and while it falls: each as its centres and means.
pub(super) fn loops(windup_rad: &[f64], values: &[f64]) -> [[Vec<f64>; 2]; 2] {
    let ends = windup_rad.iter().filter(|own| own.is_finite());
    let [low, high] = ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], own| {
        [low.min(*own), high.max(*own)]
    });
    let mut sums = [[[0.0; 2]; BINS]; 2];
    if low < high {
        for (pair, value) in windup_rad.windows(2).zip(values) {
            let [from, to] = [pair[0], pair[1]];
            if !(from.is_finite() && to.is_finite() && value.is_finite()) || from == to {
                continue;
            }
            let bin = (((from - low) / (high - low) * BINS as f64) as usize).min(BINS - 1);
            let own = &mut sums[usize::from(to < from)][bin];
            own[0] += 1.0;
            own[1] += value;
        }
    }
    sums.map(|bins| {
        let filled = bins.iter().enumerate().filter(|(_, own)| own[0] >= LEAST);
        let (x, y) = filled
            .map(|(k, [count, sum])| {
                (low + (high - low) * (k as f64 + 0.5) / BINS as f64, sum / count)
            })
            .unzip();
        [x, y]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_shows_at_its_order_with_its_height() {
        let angle: Vec<f64> = (0..10_000).map(|k| f64::from(k) * 8.0 * TAU / 1e4).collect();
        let line = |order: f64, height: f64| -> Vec<f64> {
            angle.iter().map(|angle| 3.0 + height * (order * angle).cos()).collect()
        };
        let push =
            Disturbance { before: line(7.0, 2.0), after: line(3.5, 0.5), ..Disturbance::default() };
        let lines = spectrum(&angle, &[3.5], &push);
        for [order, before, after] in lines {
            let exact =
                [if order == 7.0 { 2.0 } else { 0.0 }, if order == 3.5 { 0.5 } else { 0.0 }];
            // Whole and half orders over eight whole turns are orthogonal but for rounding.
            assert!((before - exact[0]).abs() < 1e-9 && (after - exact[1]).abs() < 1e-9, "{order}");
        }
        assert!(spectrum(&angle[..1000], &[], &push).is_empty(), "less than two turns");
    }

    #[test]
    fn a_loop_lies_apart_by_its_height_and_a_curve_does_not() {
        let windup: Vec<f64> = (0..20_000).map(|k| (f64::from(k) * 0.01).sin()).collect();
        let rate = |k: usize| (k as f64 * 0.01).cos();
        let turning: Vec<f64> = (0..20_000).map(|k| 0.2 * rate(k).signum()).collect();
        let [growing, falling] = loops(&windup, &turning);
        let middle = growing[1].len() / 2;
        assert!((growing[1][middle] - 0.2).abs() < 1e-9 && (falling[1][middle] + 0.2).abs() < 1e-9);
        let [growing, falling] = loops(&windup, &windup);
        assert!((growing[1][10] - falling[1][10]).abs() < 1.0 / BINS as f64);
    }
}
