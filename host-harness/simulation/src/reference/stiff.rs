//! An adaptive implicit method from another hand, to check the explicit reference.
//!
//! `diffsol`'s ESDIRK of order three on the same right-hand side: no fixed step to choose, no
//! stability limit, an error estimate of its own. It stops at every sample and starts again where
//! an input changes, since an error estimate must not see a jump.

use std::cell::Cell;

use diffsol::{NalgebraLU, NalgebraMat, OdeBuilder, OdeSolverMethod, OdeSolverStopReason};

use super::ReferenceError;
use super::equations::{Equations, Held};
use crate::plant::{Layout, Snapshot};

type Matrix = NalgebraMat<f64>;

/// Typical sizes of the state's entries, by which an absolute tolerance is scaled.
fn sizes(equations: &Equations) -> Vec<f64> {
    let layout = equations.layout();
    let mut sizes = vec![1e-2; layout.len()];
    sizes[Layout::ANGLE] = 1.0;
    for mass in 0..=layout.stages {
        sizes[layout.speed(mass)] = 10.0;
        sizes[layout.bristle(mass)] = equations.bristle_reach(mass).max(1e-12);
    }
    for slot in 0..layout.memories {
        sizes[layout.memory(slot)] = 1.0;
    }
    sizes
}

/// Product of the Jacobian and a direction, by a difference to the side on which the speeds already
/// lie: friction has a corner at standstill. The method's error does not depend on it, only how
/// fast its Newton iteration converges.
fn slope(
    equations: &Equations,
    sizes: &[f64],
    held: &Held,
    state: &[f64],
    direction: &[f64],
    product: &mut [f64],
) {
    let mut reach = f64::INFINITY;
    let mut side = 1.0;
    for ((direction, size), value) in direction.iter().zip(sizes).zip(state) {
        if *direction != 0.0 {
            reach = reach.min(size.max(1e-3 * value.abs()) / direction.abs());
            side = if value * direction < 0.0 { -1.0 } else { 1.0 };
        }
    }
    product.fill(0.0);
    if !reach.is_finite() {
        return;
    }
    let width = 1e-6 * reach * side;
    let moved: Vec<f64> =
        state.iter().zip(direction).map(|(value, direction)| value + width * direction).collect();
    let mut here = vec![0.0; state.len()];
    equations.derivative(held, &moved, product);
    equations.derivative(held, state, &mut here);
    for (there, here) in product.iter_mut().zip(here) {
        *there = (*there - here) / width;
    }
}

/// Runs the equations over the samples and hands each sample's state to `report`.
pub(super) fn run(
    equations: &Equations,
    time_s: &[f64],
    held: impl Fn(usize) -> Held,
    tolerance: f64,
    start: Vec<f64>,
) -> Result<Vec<Snapshot>, ReferenceError> {
    let failed = |error: diffsol::error::DiffsolError| ReferenceError::Stiff(error.to_string());
    let now = Cell::new(held(0));
    let length = equations.layout().len();
    let sizes = sizes(equations);
    let absolute: Vec<f64> = sizes.iter().map(|size| tolerance * size).collect();
    let mut problem = OdeBuilder::<Matrix>::new()
        .t0(time_s.first().copied().unwrap_or(0.0))
        .h0(1e-9)
        .rtol(tolerance)
        .atol(absolute)
        .rhs_implicit(
            |state: &[f64], _, _, rate: &mut [f64]| equations.derivative(&now.get(), state, rate),
            |state: &[f64], _, _, direction: &[f64], product: &mut [f64]| {
                slope(equations, &sizes, &now.get(), state, direction, product);
            },
        )
        .init(|_, _, state: &mut [f64]| state.copy_from_slice(&start[..length]), length)
        .build()
        .map_err(failed)?;
    // Newton's iteration may circle at the corner of friction: only shorter steps cure that.
    problem.ode_options.max_nonlinear_solver_failures = 100_000;
    problem.ode_options.min_timestep = 1e-16;
    let mut solver = problem.esdirk34::<NalgebraLU<f64>>().map_err(failed)?;
    let mut flat = start.clone();
    let mut snapshots = vec![equations.snapshot(&flat)];
    for (k, time) in time_s.iter().enumerate().skip(1) {
        let input = held(k - 1);
        if input != now.get() {
            now.set(input);
            let state = solver.state_mut();
            equations.derivative(&input, state.y.batch_as_slice(0), state.dy.batch_as_mut_slice(0));
            *state.h = 1e-9;
        }
        solver.set_stop_time(*time).map_err(failed)?;
        while solver.step().map_err(failed)? != OdeSolverStopReason::TstopReached {}
        flat.copy_from_slice(solver.state().y.batch_as_slice(0));
        equations.settle(&input, &mut flat);
        snapshots.push(equations.snapshot(&flat));
    }
    Ok(snapshots)
}
