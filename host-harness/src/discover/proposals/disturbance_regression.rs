//! Disturbance regression: names that the disturbance of an equation follows.
//!
//! A random-walk disturbance takes with it whatever is large and changes slowly, and a score beside it sees
//! nothing of that. But the disturbance itself shows it: regressed on what each effect would do on the same
//! equation, along the motion that the disturbance made true, an effect that explains most of it stands out,
//! and the regression tells its size.

use joint_core::joint::Drive;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::discover::bounds::REGRESSED_SHARE;
use crate::discover::candidates::hypothesis::{Hypothesis, first_of_each};
use crate::discover::evidence::disturbance::{disturbance_of, run_beside};
use crate::estimate::coordinates::Coordinate;
use crate::estimate::filter::{Equation, Noise, Walk};
use crate::estimate::fit::{Fit, Problem};
use crate::model::Model;
use crate::plant::{BuildError, Layout, plant};

/// How much slower than the likeliest disturbance wander others that are regressed on the effects: a fast one
/// is mostly noise, a slow one lags.
const SLOWNESS: [f64; 2] = [0.1, 10.0];
/// What keeps the regression of shapes that are almost one solvable, and small.
const RIDGE: f64 = 1e-9;

/// A hypothesis that a disturbance follows.
pub(crate) struct Regressed<'a> {
    /// Which.
    pub(crate) hypothesis: &'a Hypothesis,
    /// The model with it, as large as the disturbance says.
    pub(crate) start: Model,
    /// Share of the disturbance that it explains.
    share: f64,
    /// The fit beside the disturbance.
    pub(crate) beside: &'a Fit,
}

/// The hypotheses that explain most of the likeliest disturbance of an equation of motion or of the winding,
/// one for each name, the best first; `disturbances` begin with the likeliest.
///
/// # Errors
/// A model cannot be built.
pub(crate) fn regressed<'a>(
    problem: &Problem<'_>,
    disturbances: &'a [(Walk, Fit)],
    noise: &Noise,
    hypotheses: &'a [Hypothesis],
) -> Result<Vec<Regressed<'a>>, BuildError> {
    let of_the_joint = |(walk, _): &&(Walk, Fit)| !walk.equation.is_of_a_sensor();
    let Some((walk, beside)) = disturbances.iter().find(of_the_joint) else {
        return Ok(Vec::new());
    };
    let model = &beside.model;
    let layout = Layout::of(model);
    let state = match (walk.equation, problem.record.drive) {
        (Equation::Torque(mass), _) => layout.speed(mass),
        (_, Drive::Voltage) => Layout::CURRENT,
        (_, Drive::Current) => layout.speed(0),
    };
    let run = run_beside(problem, model, noise, *walk)?;
    let mut series = vec![disturbance_of(&run)];
    for slowness in SLOWNESS {
        let slow = Walk { rate: walk.rate / slowness, ..*walk };
        series.push(disturbance_of(&run_beside(problem, model, noise, slow)?));
    }
    let tried = hypotheses.par_iter().filter_map(|hypothesis| {
        let shapes = shapes(problem, model, hypothesis, &run.states, (walk.equation, state))?;
        let shares = series.iter().filter_map(|missed| regression(missed, &shapes));
        let (share, sizes) = shares.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let mut start = hypothesis.added(model);
        let coordinates = hypothesis.coordinates(model.effects.len());
        for (coordinate, size) in coordinates.iter().zip(sizes.iter()) {
            coordinate.shift(&mut start, *size);
        }
        Some(Regressed { hypothesis, start, share, beside })
    });
    let mut best: Vec<Regressed<'_>> = tried.collect();
    best.retain(|own| own.share > REGRESSED_SHARE);
    best.sort_by(|a, b| b.share.total_cmp(&a.share));
    Ok(first_of_each(best, |own| own.hypothesis.name()))
}

/// What a unit of each of a hypothesis's coordinates does to an equation by sample, in units of its
/// disturbance.
fn shapes(
    problem: &Problem<'_>,
    model: &Model,
    hypothesis: &Hypothesis,
    states: &[Vec<f64>],
    (equation, state): (Equation, usize),
) -> Option<DMatrix<f64>> {
    let record = problem.record;
    let build = |model: &Model| plant(model, &record.grid, record.drive).ok();
    let added = hypothesis.added(model);
    let coordinates = hypothesis.coordinates(model.effects.len());
    let moved = |coordinate: &Coordinate| {
        let mut moved = added.clone();
        coordinate.shift(&mut moved, coordinate.difference_step());
        build(&moved)
    };
    let base = build(&added)?;
    let moved = coordinates.iter().map(moved).collect::<Option<Vec<_>>>()?;
    let (own, before) = (Layout::of(&added).len(), Layout::of(model).len());
    let inertia = crate::plant::inertias(model);
    let mut shapes = DMatrix::zeros(states.len(), coordinates.len());
    let mut memory = vec![0.0; own - before];
    for (k, x) in states.iter().enumerate() {
        if record.starts.contains(&k) && !record.cuts.contains(&k) {
            memory.fill(0.0);
        }
        let mut start = x[..before].to_vec();
        start.extend(&memory);
        let (drive, load) = (record.drive_values[k], record.load_nm[k]);
        let next = |plant: &dyn crate::plant::Plant, drive: f64| {
            let mut x = start.clone();
            plant.propagate(k, &mut x, drive, load);
            x
        };
        let here = next(&*base, drive);
        let per_push = match equation {
            Equation::Torque(mass) => record.grid.interval(k) / inertia[mass],
            _ => {
                let step = 1e-4 * drive.abs() + 1e-6;
                (next(&*base, drive + step)[state] - here[state]) / step
            }
        };
        for (j, (plant, coordinate)) in moved.iter().zip(&coordinates).enumerate() {
            let change = next(&**plant, drive)[state] - here[state];
            shapes[(k, j)] = change / coordinate.difference_step() / per_push;
        }
        memory.copy_from_slice(&here[before..]);
    }
    shapes.iter().all(|shape| shape.is_finite()).then_some(shapes)
}

/// The share of a disturbance that shapes explain beside a constant, and their sizes.
fn regression(missed: &[f64], shapes: &DMatrix<f64>) -> Option<(f64, DVector<f64>)> {
    let missed = DVector::from_column_slice(missed);
    let missed = missed.add_scalar(-missed.mean());
    let mut shapes = shapes.clone();
    for mut shape in shapes.column_iter_mut() {
        let mean = shape.mean();
        shape.add_scalar_mut(-mean);
    }
    let mut normal = shapes.tr_mul(&shapes);
    let least = RIDGE * normal.trace();
    for k in 0..normal.nrows() {
        normal[(k, k)] += least;
    }
    let sizes = normal.cholesky()?.solve(&shapes.tr_mul(&missed));
    let left = &missed - &shapes * &sizes;
    let share = 1.0 - left.norm_squared() / missed.norm_squared();
    (share.is_finite() && sizes.iter().all(|size| size.is_finite())).then_some((share, sizes))
}
