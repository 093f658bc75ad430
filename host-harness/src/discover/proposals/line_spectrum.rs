//! The line spectrum of a disturbance: a torque of many lines, none of which explains much alone.
//!
//! Where cogging is many times the noise and has several strong orders, a model with the first of
//! them is hardly better than one without: what is left still swamps the filter. The disturbance that was
//! estimated along shows all of them at once, so its lines are taken together, placed where a
//! regression of the disturbance on the rotor's angle has them, and only then refitted.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::joint::Drive;
use joint_core::params::Location;
use nalgebra::{DMatrix, DVector};

use crate::discover::bounds::{LINE_SHARE, LINES_TOGETHER};
use crate::discover::candidates::hypothesis::Hypothesis;
use crate::discover::candidates::{cogging, gravity};
use crate::discover::checks::admissibility::is_moved;
use crate::discover::evidence::disturbance::disturbance_along;
use crate::discover::state::stage::Stage;
use crate::estimate::filter::{Equation, Noise, Walk};
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::record::Channel;
use crate::estimate::refit;
use crate::model::Model;
use crate::plant::BuildError;

/// Most lines that are taken.
const LINES: usize = 8;
/// Highest order that is looked for.
const HIGHEST: usize = 144;
/// How much slower than the likeliest disturbance wanders the one that is laid against the angle: a fast one
/// is mostly noise.
const SLOWNESS: [f64; 4] = [1.0, 10.0, 100.0, 1000.0];

/// The strongest lines of a disturbance as at most `most` effects, refitted without it; `None`
/// where the disturbance is none of the rotor's torque or is not made of lines, or the model has some. The
/// line of order one of a joint without stages is gravity's.
///
/// # Errors
/// A model cannot be built.
pub(crate) fn lines(
    problem: &Problem<'_>,
    base: &Stage,
    (walk, beside): (Walk, &Fit),
    [expected, wary]: [&Noise; 2],
    most: usize,
    withdrawn: &[Kind],
) -> Result<Option<Stage>, BuildError> {
    if cogging::stands_in(&base.fit.model) {
        return Ok(None);
    }
    let constant = match (walk.equation, problem.record.drive) {
        (Equation::Torque(0), _) => 1.0,
        (Equation::Voltage, Drive::Current) => beside.model.motor.torque_constant_nm_per_a,
        _ => return Ok(None),
    };
    let starts = [&base.origin, &beside.model];
    let Some((mut left, start)) = strongest(problem, starts, walk, wary)? else { return Ok(None) };
    // A disturbance beside a filter that is inconsistent may be of any size.
    let moved =
        |line: &Line| is_moved(constant * line.amplitude(), &base.fit.model, problem.record);
    if !left.iter().all(moved) {
        return Ok(None);
    }
    let hangs = gravity::own_line(&base.fit.model);
    left.retain(|line| !(hangs && line.order == 1 && withdrawn.contains(&gravity::KIND)));
    let (mut start, mut origin) = (start.clone(), base.origin.clone());
    let mut coordinates = base.fit.coordinates.clone();
    for _ in 0..most {
        if left.is_empty() {
            break;
        }
        let first = left.remove(0);
        let (hypothesis, effect) = if hangs && first.order == 1 {
            first.of_gravity(constant)
        } else {
            let double = left.iter().position(|line| line.order == 2 * first.order);
            first.of_cogging(double.map(|at| left.remove(at)), constant)
        };
        coordinates.extend(hypothesis.coordinates(start.effects.len()));
        origin.effects.push(hypothesis.start);
        start.effects.push(effect);
    }
    let fit = refit::polish(problem, &origin, &start, &coordinates, expected, wary)?;
    Ok(Some(Stage { fit: refit::converge(problem, &origin, fit, expected)?, origin }))
}

/// The lines of the disturbance that is made of lines most, over its rates and the models that a filter may run with,
/// and that model; `None` where none is.
fn strongest<'m>(
    problem: &Problem<'_>,
    starts: [&'m Model; 2],
    walk: Walk,
    wary: &Noise,
) -> Result<Option<(Vec<Line>, &'m Model)>, BuildError> {
    let mut best: Option<(f64, Vec<Line>, &Model)> = None;
    for model in starts {
        for slowness in SLOWNESS {
            let slow = Walk { rate: walk.rate / slowness, ..walk };
            let missed = disturbance_along(problem, model, wary, slow)?;
            let rotor = problem.record.measured.iter().map(|row| row[Channel::Motor as usize]);
            let finite = |(angle, missed): &(f64, f64)| angle.is_finite() && missed.is_finite();
            let (angle, missed): (Vec<f64>, Vec<f64>) = rotor.zip(missed).filter(finite).unzip();
            let (share, lines) = spectrum(&angle, &missed);
            let better = best.as_ref().is_none_or(|(most, ..)| share > *most);
            if share > LINES_TOGETHER && better {
                best = Some((share, lines, model));
            }
        }
    }
    Ok(best.map(|(_, lines, model)| (lines, model)))
}

/// One line of a disturbance: `cosine · cos(order q) + sine · sin(order q)`.
#[derive(Clone, Copy, Debug)]
struct Line {
    order: usize,
    cosine: f64,
    sine: f64,
}

impl Line {
    fn amplitude(&self) -> f64 {
        self.cosine.hypot(self.sine)
    }

    /// Phase of the same line written as `−a sin(order q + phase)`.
    fn phase(&self) -> f64 {
        (-self.cosine).atan2(-self.sine)
    }

    /// Gravity with this line's size, as a hypothesis and as an effect; `constant` is torque over disturbance.
    fn of_gravity(&self, constant: f64) -> (Hypothesis, EffectParameters) {
        let amplitude = constant * self.amplitude();
        let hypothesis = gravity::pull(Location::Motor, amplitude);
        let pulls = hypothesis.start.with("amplitude_nm", amplitude);
        let pulls = pulls.with("phase_rad", self.phase());
        (hypothesis, pulls)
    }

    /// Cogging with this line's size and perhaps its double's.
    fn of_cogging(&self, double: Option<Self>, constant: f64) -> (Hypothesis, EffectParameters) {
        let scale = constant * self.amplitude();
        let hypothesis = cogging::line(self.order as f64, scale, double.is_some());
        let mut effect = hypothesis.start;
        for (line, at) in [Some(self), double.as_ref()].into_iter().flatten().zip([1, 3]) {
            effect.values[at] = constant * line.amplitude();
            effect.values[at + 1] = line.phase();
        }
        (hypothesis, effect)
    }
}

/// The whole orders of an angle that a disturbance shows, strongest first, and the share of it that they
/// explain.
fn spectrum(angle: &[f64], missed: &[f64]) -> (f64, Vec<Line>) {
    let wave = |order: usize| {
        angle.iter().map(move |q| (order as f64 * q).sin_cos()).collect::<Vec<(f64, f64)>>()
    };
    let missed = DVector::from_column_slice(missed);
    let total = missed.add_scalar(-missed.mean()).norm_squared();
    let mut columns = vec![DVector::repeat(missed.len(), 1.0)];
    let mut orders: Vec<usize> = Vec::new();
    let mut left = missed.add_scalar(-missed.mean());
    let mut fitted = DVector::zeros(1);
    while orders.len() < LINES && total > 0.0 {
        let strength = |order: &usize| {
            let waves = wave(*order);
            let sums = waves.iter().zip(left.iter());
            let (s, c) = sums.fold((0.0, 0.0), |(s, c), (w, l)| (s + w.0 * l, c + w.1 * l));
            s * s + c * c
        };
        let free = (1..=HIGHEST).filter(|order| !orders.contains(order));
        let next = free.map(|order| (strength(&order), order)).max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, order)) = next else { break };
        let waves = wave(order);
        columns.push(DVector::from_iterator(missed.len(), waves.iter().map(|w| w.1)));
        columns.push(DVector::from_iterator(missed.len(), waves.iter().map(|w| w.0)));
        let design = DMatrix::from_columns(&columns);
        let normal = design.tr_mul(&design);
        let Some(solved) = normal.cholesky().map(|c| c.solve(&design.tr_mul(&missed))) else {
            break;
        };
        let rest = &missed - &design * &solved;
        if left.norm_squared() - rest.norm_squared() < LINE_SHARE * total {
            break;
        }
        orders.push(order);
        (left, fitted) = (rest, solved);
    }
    let line = |(k, order): (usize, &usize)| Line {
        order: *order,
        cosine: fitted[1 + 2 * k],
        sine: fitted[2 + 2 * k],
    };
    let mut lines: Vec<Line> = orders.iter().enumerate().map(line).collect();
    lines.sort_by(|a, b| b.amplitude().total_cmp(&a.amplitude()));
    (1.0 - left.norm_squared() / total.max(f64::MIN_POSITIVE), lines)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lines_of_a_push_are_found_over_one_turn_with_their_phases() {
        let angle: Vec<f64> = (0..4000).map(|k| 6.3 * f64::from(k) / 4000.0).collect();
        let missed: Vec<f64> = angle
            .iter()
            .map(|q| 0.3 - 2.0 * (7.0 * q + 0.4).sin() - (28.0 * q - 1.0).sin())
            .collect();
        let (share, found) = spectrum(&angle, &missed);
        assert!(share > 0.999);
        assert_eq!(found.iter().map(|line| line.order).collect::<Vec<_>>(), [7, 28]);
        assert!((found[0].amplitude() - 2.0).abs() < 1e-6);
        assert!((found[0].phase() - 0.4).abs() < 1e-6);
        assert!((found[1].phase() + 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_push_without_lines_gives_none() {
        let angle: Vec<f64> = (0..4000).map(|k| 6.3 * f64::from(k) / 4000.0).collect();
        let mut noise = 1_u64;
        let mut white = || {
            noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_041);
            (noise >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
        };
        let missed: Vec<f64> = angle.iter().map(|_| white()).collect();
        assert!(spectrum(&angle, &missed).0 < LINES_TOGETHER);
    }
}
