//! A torque map for what repeats and has no name.
//!
//! Where a generic family predicts what no named law explains, the user of the model can have it as a
//! table. Its knots are those of a penalised spline (Eilers and Marx, Stat. Sci. 11, 1996): straight
//! lines whose bends are held down by as much as lets the table predict the blocks best that it was not
//! fitted to, nor to their neighbours. A table that does not do so beyond chance is none.

use std::f64::consts::TAU;
use std::ops::Range;

use joint_core::effect::{EffectParameters, Kind, MAX_KNOTS};
use joint_core::params::Location;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::blocks::{Blocks, Share, beyond_chance, correlation_time, neighbours, ratio};

/// Knots of a curve, coarse to fine.
const KNOTS: [usize; 4] = [8, 16, 32, MAX_KNOTS];
/// Samples that a knot has to have in the mean.
const PER_KNOT: usize = 16;
/// Weights of the bends' squares, in independent samples.
const SMOOTHING: [f64; 5] = [0.01, 0.1, 1.0, 10.0, 100.0];
/// Turns from which on a course may come again with each.
const TURNS: f64 = 1.5;
/// Speed within which one direction passes into the other, of the speed's RMS.
const BLEND: f64 = 0.1;

/// A disturbance along a record, at the map's own side, by sample; what is no number is left out.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unexplained<'a> {
    /// Torque that is missing, Nm, positive with positive motion.
    pub torque_nm: &'a [f64],
    /// Angle, rad.
    pub angle_rad: &'a [f64],
    /// Speed, rad/s.
    pub speed_rad_per_s: &'a [f64],
}

/// What a map is over.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Over {
    Span,
    Turn,
    Speed,
}

/// A shape of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Shape {
    over: Over,
    by_direction: bool,
    knots: usize,
}

impl Shape {
    fn numbers(self) -> usize {
        self.knots * if self.by_direction { 2 } else { 1 }
    }
}

/// The maps at this place that predict a disturbance on blocks which they were not fitted to: over the travel,
/// over a turn, over the speed, of each the coarsest that is as good as the best, in the order of what they
/// predict; none where none does so beyond chance.
pub(super) fn fitted_maps(of: &Unexplained<'_>, place: Location) -> Vec<EffectParameters> {
    let Some(rows) = Rows::of(of) else { return Vec::new() };
    let shapes = rows.shapes();
    let least = beyond_chance(shapes.len(), rows.blocks.ranges().len());
    let tried = shapes.into_par_iter().filter_map(|shape| {
        let design = rows.design(shape);
        let (smoothing, share) = design.best_smoothing();
        (share.value > least * share.error).then_some((design, smoothing, share))
    });
    let mut tried: Vec<_> = tried.collect();
    tried.sort_by_key(|(design, ..)| design.shape.numbers());
    let of = |over: Over| {
        let own = || tried.iter().filter(|(design, ..)| design.shape.over == over);
        let best = own().map(|own| own.2).max_by(|a, b| a.value.total_cmp(&b.value))?;
        // Breiman and others 1984: within a standard error of the best.
        let (design, smoothing, _) = own().find(|own| own.2.value >= best.value - best.error)?;
        Some((best.value, rows.effect(design.shape, &design.fitted(*smoothing)?, place)?))
    };
    let mut maps: Vec<_> =
        [Over::Span, Over::Turn, Over::Speed].into_iter().filter_map(of).collect();
    maps.sort_by(|a, b| b.0.total_cmp(&a.0));
    maps.into_iter().map(|(_, map)| map).collect()
}

/// The samples that are numbers.
struct Rows {
    torque: Vec<f64>,
    angle: Vec<f64>,
    speed: Vec<f64>,
    correlation: f64,
    blocks: Blocks,
    start: f64,
    span: f64,
    largest_speed: f64,
    blend: f64,
}

impl Rows {
    fn of(of: &Unexplained<'_>) -> Option<Self> {
        let samples = of.torque_nm.iter().zip(of.angle_rad).zip(of.speed_rad_per_s);
        let samples = samples
            .map(|((torque, angle), speed)| [*torque, *angle, *speed])
            .filter(|sample| sample.iter().all(|value| value.is_finite()));
        let samples: Vec<[f64; 3]> = samples.collect();
        let [torque, angle, speed] = [0, 1, 2].map(|which: usize| -> Vec<f64> {
            samples.iter().map(|sample| sample[which]).collect()
        });
        let least = angle.iter().copied().fold(f64::INFINITY, f64::min);
        let most = angle.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let squares: f64 = speed.iter().map(|v| v * v).sum();
        let blend = BLEND * (squares / speed.len().max(1) as f64).sqrt();
        let largest_speed = speed.iter().fold(0.0_f64, |most, v| v.abs().max(most));
        let blocks = Blocks::of_series(&vec![true; torque.len()], &torque);
        (most > least && blend > 0.0).then(|| Self {
            correlation: correlation_time(&torque),
            blocks,
            torque,
            angle,
            speed,
            start: least,
            span: most - least,
            largest_speed,
            blend,
        })
    }

    fn shapes(&self) -> Vec<Shape> {
        let turns = self.span / TAU > TURNS;
        let mut all = Vec::new();
        for over in [Over::Span, Over::Turn, Over::Speed] {
            for by_direction in [false, true] {
                let curves = if by_direction { 2 } else { 1 };
                let knots = KNOTS.into_iter().filter(|knots| {
                    knots * curves <= MAX_KNOTS && knots * curves * PER_KNOT <= self.torque.len()
                });
                if over != Over::Turn || turns {
                    all.extend(knots.map(|knots| Shape { over, by_direction, knots }));
                }
            }
        }
        all
    }

    /// How each sample follows from the knots, with the blend of the law.
    fn design(&self, shape: Shape) -> Design<'_> {
        let Shape { over, by_direction, knots } = shape;
        let intervals = if over == Over::Turn { knots } else { knots - 1 };
        let row = |sample: usize| {
            let part = match over {
                Over::Span => (self.angle[sample] - self.start) / self.span,
                Over::Turn => (self.angle[sample] / TAU).rem_euclid(1.0),
                Over::Speed => self.speed[sample].abs() / self.largest_speed,
            };
            let place = part * intervals as f64;
            let knot = (place as usize).min(intervals - 1);
            let share = place - knot as f64;
            let way = (self.speed[sample] / self.blend).clamp(-1.0, 1.0);
            let [ahead, back] = match (over, by_direction) {
                (_, true) => [0.5 + 0.5 * way, 0.5 - 0.5 * way],
                (Over::Speed, false) => [way, 0.0],
                _ => [1.0, 0.0],
            };
            let next = (knot + 1) % knots;
            let behind = if by_direction { knots } else { 0 };
            [
                (knot, ahead * (1.0 - share)),
                (next, ahead * share),
                (behind + knot, back * (1.0 - share)),
                (behind + next, back * share),
            ]
        };
        let curves = if by_direction { 2 } else { 1 };
        Design {
            shape,
            count: curves * knots,
            rows: (0..self.torque.len()).map(row).collect(),
            torque: &self.torque,
            blocks: self.blocks.ranges(),
            correlation: self.correlation,
        }
    }

    fn effect(&self, shape: Shape, knots: &[f64], place: Location) -> Option<EffectParameters> {
        let (forward, backward) = knots.split_at(shape.knots);
        let map = EffectParameters::new(Kind::TorqueMap, place).with_table(forward, backward)?;
        let map = match shape.over {
            Over::Span => map.with("start_rad", self.start).with("span_rad", self.span),
            Over::Turn => map.with("period_rad", TAU),
            Over::Speed => map.with("speed_rad_per_s", self.largest_speed),
        };
        let blends = shape.by_direction || shape.over == Over::Speed;
        Some(if blends { map.with("blend_rad_per_s", self.blend) } else { map })
    }
}

/// A least-squares problem for the knots of one shape.
struct Design<'a> {
    shape: Shape,
    count: usize,
    rows: Vec<[(usize, f64); 4]>,
    torque: &'a [f64],
    blocks: &'a [Range<usize>],
    correlation: f64,
}

impl Design<'_> {
    fn normal(&self, samples: Range<usize>) -> (DMatrix<f64>, DVector<f64>) {
        let mut gram = DMatrix::zeros(self.count, self.count);
        let mut right = DVector::zeros(self.count);
        for k in samples {
            for (i, a) in self.rows[k] {
                right[i] += a * self.torque[k];
                for (j, b) in self.rows[k] {
                    gram[(i, j)] += a * b;
                }
            }
        }
        (gram, right)
    }

    /// What is added to the normal equations: bends of each curve, and a ridge that holds a knot to zero by
    /// as much as a thousandth of an independent sample pulls it away.
    fn penalty(&self, smoothing: f64) -> DMatrix<f64> {
        let Shape { over, knots, .. } = self.shape;
        let mut penalty = DMatrix::identity(self.count, self.count) * (1e-3 * self.correlation);
        let bends = if over == Over::Turn { knots } else { knots - 2 };
        for from in (0..self.count).step_by(knots) {
            for k in 0..bends {
                let bend = [(k, 1.0), ((k + 1) % knots, -2.0), ((k + 2) % knots, 1.0)];
                for (i, a) in bend {
                    for (j, b) in bend {
                        penalty[(from + i, from + j)] += smoothing * self.correlation * a * b;
                    }
                }
            }
        }
        penalty
    }

    /// The smoothing that predicts most of the blocks left out, and that share.
    fn best_smoothing(&self) -> (f64, Share) {
        let own: Vec<_> = self.blocks.iter().map(|range| self.normal(range.clone())).collect();
        let none = (DMatrix::zeros(self.count, self.count), DVector::zeros(self.count));
        let all = own.iter().fold(none, |(gram, right), (g, r)| (gram + g, right + r));
        let share = |smoothing: f64| {
            let penalty = self.penalty(smoothing);
            let (mut gained, mut whole) = (Vec::new(), Vec::new());
            for (b, range) in self.blocks.iter().enumerate() {
                let (mut gram, mut right) = (&all.0 + &penalty, all.1.clone());
                for (g, r) in &own[neighbours(b, own.len())] {
                    gram -= g;
                    right -= r;
                }
                let Some(knots) = gram.cholesky().map(|factor| factor.solve(&right)) else {
                    return Share { value: 0.0, error: f64::INFINITY };
                };
                let (mut before, mut after) = (0.0, 0.0);
                for k in range.clone() {
                    let told: f64 = self.rows[k].iter().map(|(i, a)| a * knots[*i]).sum();
                    before += self.torque[k] * self.torque[k];
                    after += (self.torque[k] - told).powi(2);
                }
                gained.push(before - after);
                whole.push(before);
            }
            ratio(&gained, &whole)
        };
        let tried = SMOOTHING.map(|smoothing| (smoothing, share(smoothing)));
        let better = |a: (f64, Share), b: (f64, Share)| if b.1.value > a.1.value { b } else { a };
        tried.into_iter().reduce(better).unwrap_or((1.0, Share::default()))
    }

    /// The knots, of all samples.
    fn fitted(&self, smoothing: f64) -> Option<Vec<f64>> {
        let (gram, right) = self.normal(0..self.torque.len());
        let factor = (gram + self.penalty(smoothing)).cholesky()?;
        Some(factor.solve(&right).iter().copied().collect())
    }
}

#[cfg(test)]
mod tests;
