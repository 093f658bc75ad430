//! Cogging: lines in the rotor's torque at whole orders of its angle, the same at every current
//! and speed. Every order that the record resolves is tried; the best few become hypotheses, each
//! with its double.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;
use rayon::prelude::*;

use super::super::hypothesis::{Free, Hypothesis};
use super::super::score_test::{Gain, ScoreTest};
use super::Scene;
use crate::estimate::record::Channel;

/// Highest order tried on a rotor that turns.
const HIGHEST: f64 = 144.0;
/// Turns from which on an axis is a rotor, not a linear one.
const A_TURN: f64 = 0.8;
/// Resolved orders tried on an axis that turns less.
const TRIED: u32 = 400;
/// Orders that become hypotheses.
const KEPT: usize = 2;

pub(super) fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    scene.lines.iter().take(KEPT).map(|(order, _)| hypothesis(scene, *order, true)).collect()
}

/// What every order that the model has no cogging of would explain: the peaks, strongest first.
pub(super) fn spectrum(scene: &Scene<'_>, test: &ScoreTest<'_>) -> Vec<(f64, Gain)> {
    let turned = turned(scene);
    let resolved = 0.5 / turned.max(1e-9);
    let sampled = std::f64::consts::PI / typical_step(scene);
    let mut orders = tried(turned, resolved);
    orders.retain(|order| *order < sampled);
    let gains: Vec<Gain> = orders
        .par_iter()
        .map(|order| match taken(scene, *order, resolved) || order * turned < 2.0 {
            true => Gain::default(),
            false => test.gain(&hypothesis(scene, *order, false)),
        })
        .collect();
    let at = |k: Option<usize>| k.and_then(|k| gains.get(k)).map_or(0.0, |gain| gain.real);
    let mut peaks: Vec<(f64, Gain)> = (0..orders.len())
        .filter(|k| gains[*k].real >= at(k.checked_sub(1)).max(at(Some(k + 1))))
        .map(|k| (orders[k], gains[k].clone()))
        .collect();
    peaks.sort_by(|a, b| b.1.real.total_cmp(&a.1.real));
    peaks
}

/// Orders to try: every whole one that the travel can tell from its neighbour. A rotor has no
/// others; an axis that turns little may be a linear one, whose lines lie far higher.
fn tried(turned: f64, resolved: f64) -> Vec<f64> {
    let stride = resolved.max(1.0);
    let highest =
        if turned < A_TURN { (f64::from(TRIED) * resolved).max(HIGHEST) } else { HIGHEST };
    let count = (highest / stride) as u32;
    (1..=count).map(|k| (f64::from(k) * stride).round()).collect()
}

fn hypothesis(scene: &Scene<'_>, order: f64, double: bool) -> Hypothesis {
    let scale = 0.05 * scene.torque_scale();
    let phasor = |amplitude| Free::Phasor { amplitude, scale, sigma: 200.0 };
    let double = double && !taken(scene, 2.0 * order, 0.25);
    Hypothesis {
        start: EffectParameters::new(Kind::Cogging, Location::Motor).with("order", order),
        free: if double { vec![phasor(1), phasor(3)] } else { vec![phasor(1)] },
    }
}

/// Whether the model has a line within `reach` of this order.
fn taken(scene: &Scene<'_>, order: f64, reach: f64) -> bool {
    let lines = scene.model.effects.iter().filter(|effect| effect.kind == Kind::Cogging);
    let near = |line: f64| (line - order).abs() < reach.max(0.25);
    lines.into_iter().any(|effect| {
        let [order, amplitude, _, second, ..] = effect.values;
        (amplitude != 0.0 && near(order)) || (second != 0.0 && near(2.0 * order))
    })
}

/// Median of how far the rotor turns from one sample to the next, rad: a line that passes half a
/// period in that is not seen as what it is.
fn typical_step(scene: &Scene<'_>) -> f64 {
    let angle = |row: &[f64; 3]| row[Channel::Motor as usize];
    let pairs = scene.record.measured.windows(2);
    let mut steps: Vec<f64> = pairs
        .map(|pair| (angle(&pair[1]) - angle(&pair[0])).abs())
        .filter(|step| *step > 0.0)
        .collect();
    let middle = steps.len() / 2;
    if steps.is_empty() {
        return f64::MIN_POSITIVE;
    }
    *steps.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Turns between the rotor's extremes.
fn turned(scene: &Scene<'_>) -> f64 {
    let angles = scene.record.measured.iter().map(|row| row[Channel::Motor as usize]);
    let (low, high) = angles
        .filter(|angle| angle.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), a| (low.min(a), high.max(a)));
    (high - low) / std::f64::consts::TAU
}
