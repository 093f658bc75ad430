//! What a generic family of functions still predicts of a disturbance: the yardstick for effects.
//!
//! Curves over every coordinate of the joint, alone, for each direction of motion, and as the coefficient of
//! current, speed or voltage (varying-coefficient models, Hastie and Tibshirani, J. R. Stat. Soc. B 55, 1993)
//! are fitted to the disturbance and asked of the blocks that were left out, their neighbours left out as
//! well (h-v block cross-validation, Racine, J. Econometrics 99, 2000). What such a curve predicts is a
//! law that nobody has named; what it does not predict is no law of these coordinates. A law is correlated in time as
//! the motion is, so it is what a curve leaves that says how long a block must be.

use rayon::prelude::*;

use super::blocks::{Blocks, Share, beyond_chance, correlation_time, neighbours, ratio};
use super::family::{Equations, Family};
use super::hats::Grid;
use super::linear::Linear;
use crate::discover::bounds::APART;

/// Knots over a coordinate, coarse to fine: a line, a trend, a course, a curve, a line spectrum, one of high orders.
const KNOTS: [usize; 6] = [2, 4, 12, 48, 192, 768];
/// Samples that a knot has to have in the mean.
const PER_KNOT: usize = 16;
/// What a linear combination of all coordinates is called.
const STATES: &str = "linear combination of the states";

/// What follows a coordinate and has no name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Predicted {
    /// The coordinate.
    pub follows: String,
    /// Whether each direction of motion has a curve of its own.
    pub by_direction: bool,
    /// The quantity that it is the coefficient of, if it is one.
    pub times: Option<String>,
    /// Share of the disturbance's square, on blocks that the curve was not fitted to.
    pub share: Share,
}

/// What a curve is multiplied with.
#[derive(Clone, Copy)]
enum Beside<'a> {
    Nothing,
    Direction,
    Quantity(&'a str, &'a [f64]),
}

/// The family that predicts most of a series on the samples of `asked`, if one does beyond chance on all.
/// `coordinates` and `weights` are by sample, `direction` is any quantity with the sign of the motion.
pub(super) fn predicted(
    series: &[f64],
    coordinates: &[(&str, Vec<f64>)],
    weights: &[(&str, Vec<f64>)],
    direction: &[f64],
    asked: &[bool],
) -> Option<Predicted> {
    let mut curves = Vec::new();
    let quantities = weights.iter().map(|(name, values)| Beside::Quantity(name, values));
    let beside: Vec<Beside<'_>> =
        [Beside::Nothing, Beside::Direction].into_iter().chain(quantities).collect();
    for (name, values) in coordinates {
        for beside in &beside {
            let count = KNOTS.into_iter().filter(|knots| knots * PER_KNOT <= series.len());
            curves.extend(count.map(|knots| (*name, values, *beside, knots)));
        }
    }
    let asked = Asked { series, tests: curves.len() + 1, samples: asked };
    let found = curves.into_par_iter().filter_map(|(name, values, beside, knots)| {
        let grid = match beside {
            Beside::Nothing => Grid::new(values, None, knots)?,
            Beside::Direction => Grid::new(values, Some(direction), knots)?,
            Beside::Quantity(_, weights) => Grid::new(values, None, knots)?.times(weights)?,
        };
        let share = asked.share(&grid)?;
        let times = match beside {
            Beside::Quantity(name, _) => Some(name.to_owned()),
            _ => None,
        };
        let by_direction = matches!(beside, Beside::Direction);
        Some(Predicted { follows: name.to_owned(), by_direction, times, share })
    });
    let curve = found.max_by(|a, b| a.share.value.total_cmp(&b.share.value));
    let states: Vec<&[f64]> = coordinates.iter().map(|(_, values)| &values[..]).collect();
    let linear = Linear::new(&states).and_then(|linear| {
        Some(Predicted {
            follows: STATES.into(),
            share: asked.share(&linear)?,
            ..Predicted::default()
        })
    });
    // A curve says more than a combination of everything does.
    linear.into_iter().chain(curve).max_by(|a, b| a.share.value.total_cmp(&b.share.value))
}

/// What families are asked.
struct Asked<'a> {
    series: &'a [f64],
    tests: usize,
    samples: &'a [bool],
}

impl Asked<'_> {
    /// The share of the series that a family predicts on the samples of interest, if it predicts one on all beyond
    /// chance.
    fn share(&self, family: &impl Family) -> Option<Share> {
        let Self { series, tests, samples } = *self;
        let correlation = correlation_time(&left(series, family));
        let every = vec![true; series.len()];
        let blocks = blocks(&every, correlation);
        // All samples say whether there is a law; those that no fit has seen, how much it is.
        let sure = left_out(series, family, &blocks, correlation, &every);
        (sure.value > beyond_chance(tests, blocks.ranges().len()) * sure.error)
            .then(|| left_out(series, family, &blocks, correlation, samples))
    }
}

/// Blocks of what a curve leaves with this correlation time, in samples.
fn blocks(every: &[bool], correlation: f64) -> Blocks {
    Blocks::over(every, (APART * correlation).ceil() as usize)
}

/// What a curve leaves of a series that it is fitted to.
fn left(series: &[f64], family: &impl Family) -> Vec<f64> {
    let mut equations = family.none();
    family.add(&mut equations, series, 0..series.len());
    let curve = equations.solved(1.0);
    series.iter().enumerate().map(|(k, value)| value - family.value(&curve, k)).collect()
}

/// Share of a series that a curve predicts on blocks which it was not fitted to, nor to their
/// neighbours. The ridge holds a knot to zero by as much as one independent sample pulls it away.
fn left_out<F: Family>(
    series: &[f64],
    family: &F,
    blocks: &Blocks,
    correlation: f64,
    asked: &[bool],
) -> Share {
    let ranges = blocks.ranges();
    let mut all = family.none();
    let own: Vec<F::Equations> = ranges
        .iter()
        .map(|range| {
            let mut equations = family.none();
            family.add(&mut equations, series, range.clone());
            all.plus(&equations, 1.0);
            equations
        })
        .collect();
    let (mut gained, mut whole) = (Vec::new(), Vec::new());
    for (b, range) in ranges.iter().enumerate() {
        let mut seen = range.clone().filter(|k| asked[*k]).peekable();
        if seen.peek().is_none() {
            continue;
        }
        let mut others = all.clone();
        own[neighbours(b, own.len())].iter().for_each(|near| others.plus(near, -1.0));
        let curve = others.solved(correlation);
        let (mut before, mut after) = (0.0, 0.0);
        for k in seen {
            before += series[k] * series[k];
            after += (series[k] - family.value(&curve, k)).powi(2);
        }
        gained.push(before - after);
        whole.push(before);
    }
    ratio(&gained, &whole)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const SAMPLES: usize = 6000;

    /// A coordinate that goes to and fro, its direction, and a disturbance of OU noise.
    fn motion(seed: u64, keep: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let phase = |k: usize| k as f64 * 0.013 + 0.4 * (k as f64 * 0.0017).sin();
        let angle: Vec<f64> = (0..SAMPLES).map(|k| 3.0 * phase(k).sin()).collect();
        // Its size is another matter than the place: a speed that told the place would be as good a coordinate.
        let size = |k: usize| 1.0 + 0.9 * (k as f64 * 0.0071).sin();
        let speed: Vec<f64> = (0..SAMPLES).map(|k| size(k) * phase(k).cos()).collect();
        let mut state = 0.0;
        let noise = (0..SAMPLES).map(|_| {
            state = keep * state + (1.0 - keep * keep).sqrt() * random.random_range(-1.7..1.7);
            state
        });
        (angle, speed, noise.collect())
    }

    fn asked(series: &[f64], angle: &[f64], speed: &[f64]) -> Option<Predicted> {
        let coordinates = [("angle", angle.to_vec()), ("speed", speed.to_vec())];
        let held: Vec<bool> = (0..SAMPLES).map(|k| (k / 300) % 3 == 0).collect();
        predicted(series, &coordinates, &[("speed", speed.to_vec())], speed, &held)
    }

    #[test]
    fn coloured_noise_that_follows_nothing_is_hardly_ever_predicted() {
        let found = (0..40).filter(|seed| {
            let (angle, speed, noise) = motion(*seed, 0.95);
            asked(&noise, &angle, &speed).is_some()
        });
        // One in twenty is what the test allows; five of forty has a probability of 3 %.
        let count = found.count();
        assert!(count < 6, "{count} of 40");
    }

    #[test]
    fn a_law_is_found_with_its_coordinate_and_its_share() {
        let (angle, speed, noise) = motion(5, 0.9);
        let series: Vec<f64> = angle
            .iter()
            .zip(&noise)
            .map(|(angle, noise)| 1.5 * (2.0 * angle).sin() + noise)
            .collect();
        let found = asked(&series, &angle, &speed).unwrap();
        assert_eq!(found.follows, "angle");
        let law: f64 = angle.iter().map(|angle| (1.5 * (2.0 * angle).sin()).powi(2)).sum();
        let whole: f64 = series.iter().map(|x| x * x).sum();
        // A curve of a few dozen knots loses some to noise and ridge.
        let share = law / whole;
        assert!((found.share.value - share).abs() < 0.1, "{:?}, {share}", found.share);
    }

    #[test]
    fn a_coefficient_that_follows_a_coordinate_is_told_with_its_quantity() {
        let (angle, speed, noise) = motion(7, 0.9);
        let rows = angle.iter().zip(&speed).zip(&noise);
        let series: Vec<f64> =
            rows.map(|((angle, speed), noise)| 2.0 * (2.0 * angle).sin() * speed + noise).collect();
        let found = asked(&series, &angle, &speed).unwrap();
        assert!(found.follows == "angle" && found.times.as_deref() == Some("speed"), "{found:?}");
    }

    #[test]
    fn a_law_as_slow_as_the_motion_is_found_by_what_is_left_of_it() {
        // Four periods, which are five correlation times of the law.
        let angle: Vec<f64> = (0..SAMPLES).map(|k| (k as f64 * 0.0042).sin()).collect();
        let (_, speed, noise) = motion(8, 0.5);
        let rows = angle.iter().zip(&noise);
        let series: Vec<f64> = rows.map(|(x, noise)| x * x.abs() + 0.3 * noise).collect();
        let found = asked(&series, &angle, &speed).unwrap();
        assert!(found.follows == "angle" && found.share.value > 0.7, "{found:?}");
    }

    #[test]
    fn what_no_coordinate_tells_alone_is_told_by_a_combination_of_them() {
        let (angle, speed, noise) = motion(9, 0.9);
        let rows = angle.iter().zip(&speed).zip(&noise);
        let series: Vec<f64> =
            rows.map(|((angle, speed), noise)| angle + 3.0 * speed + 0.1 * noise).collect();
        let found = asked(&series, &angle, &speed).unwrap();
        assert!(found.follows == STATES && found.share.value > 0.95, "{found:?}");
    }

    #[test]
    fn a_law_of_each_direction_is_told_as_such() {
        let (angle, speed, noise) = motion(6, 0.5);
        let rows = angle.iter().zip(&speed).zip(&noise);
        let series: Vec<f64> = rows
            .map(|((angle, speed), noise)| angle.cos() * speed.signum() + 0.2 * noise)
            .collect();
        let found = asked(&series, &angle, &speed).unwrap();
        assert!(found.by_direction && found.follows == "angle", "{found:?}");
    }

    #[test]
    fn a_family_has_no_more_knots_than_a_sixteenth_of_the_samples() {
        // Four periods, which twelve knots follow and four do not.
        let law = |samples: usize| {
            let angle: Vec<f64> = (0..samples).map(|k| (0.618_034 * k as f64).fract()).collect();
            let series: Vec<f64> = angle.iter().map(|x| (TAU * 4.0 * x).sin()).collect();
            let direction = vec![1.0; samples];
            predicted(&series, &[("angle", angle)], &[], &direction, &vec![true; samples])
        };
        assert!(law(191).is_none_or(|found| found.share.value < 0.2), "{:?}", law(191));
        assert!(law(192).unwrap().share.value > 0.4, "{:?}", law(192));
    }

    #[test]
    fn what_a_curve_leaves_is_the_series_less_its_values() {
        let values: Vec<f64> = (0..1000).map(|k| f64::from(k % 100)).collect();
        let grid = Grid::new(&values, None, 2).unwrap();
        let series: Vec<f64> = values.iter().map(|x| 2.0 * x - 40.0).collect();
        let left = left(&series, &grid);
        // A ridge of one sample beside some three hundred of each knot.
        assert!(left.len() == 1000 && left.iter().all(|left| left.abs() < 1.0), "{left:?}");
    }

    #[test]
    fn a_block_lasts_three_correlation_times_where_a_sixtieth_is_shorter() {
        let lasts = |correlation: f64| blocks(&[true; 600], correlation).ranges()[0].len();
        assert_eq!([lasts(1.0), lasts(20.0), lasts(19.9)], [10, 60, 60]);
    }

    #[test]
    fn a_block_is_predicted_by_those_that_are_no_neighbours_alone() {
        // Each place is visited in one block and at its ends: nothing that is learned elsewhere holds there.
        let values: Vec<f64> = (0..120).map(f64::from).collect();
        let series = vec![1.0; 120];
        let grid = Grid::new(&values, None, 120).unwrap();
        let every = vec![true; 120];
        let blocks = Blocks::over(&every, 20);
        let share = left_out(&series, &grid, &blocks, 1.0, &every);
        assert_eq!(share.value, 0.0);
        // Where it is visited in every block, all of it holds but for the ridge.
        let values: Vec<f64> = (0..120).map(|k| f64::from(k % 20)).collect();
        let grid = Grid::new(&values, None, 20).unwrap();
        let share = left_out(&series, &grid, &blocks, 1e-9, &every);
        assert!((share.value - 1.0).abs() < 1e-6, "{share:?}");
    }
}
