//! Refitting by simulation: the parameters with which a joint runs freely nearest to its log.
//!
//! Prediction errors find what a model misses, and they weigh every sample's own motion. What a user of the
//! model sees is a run of a second or more by the input alone, and with a law that is slightly other than the
//! joint's the two ask for other parameters. So a record is cut into windows, each begins in the state that a
//! filter shows there, and what is made smallest is the error of the run to its end (output-error method; Ljung,
//! System Identification, 1999). Windows of a second or a few transfer best to other records: an angle's drift
//! over a whole record is one number, and a tenth of a second shows what a sample shows.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::coordinates::{Coordinate, precision};
use super::filter::Noise;
use super::fit::Problem;
use super::free_run;
use super::gram::{gram, shared};
use super::noise;
use super::record::{CHANNELS, Channel, Record};
use super::stretches::motions;
use crate::interrupt;
use joint_simulation::model::Model;
use joint_simulation::plant::BuildError;

/// Share of the expected process noise that a window's filter is left with: what it corrects is where the window
/// began.
const SIMULATED: f64 = 1e-3;
/// Times the windows are laid anew where the model has moved, and most rounds of a fit over them.
const LAID: usize = 3;
const ROUNDS: usize = 8;
/// Least samples of a window.
const LEAST: usize = 8;
/// Share of the error that another lay must take for one more.
const WORTHWHILE: f64 = 0.01;

/// A model fitted by simulation.
#[derive(Clone, Debug)]
pub struct Simulated {
    /// The fitted model.
    pub model: Model,
    /// Covariance of its coordinates, by the scatter of the windows: errors of a run are correlated.
    pub covariance: DMatrix<f64>,
    /// RMS error over the windows by channel, in its unit: of the start, and of the fitted model.
    pub errors: [[Option<f64>; CHANNELS]; 2],
    /// How many windows there are.
    pub windows: usize,
}

/// Fits a model from the best of several starts over windows of so many seconds; `origin` centres the priors.
///
/// # Errors
/// A model cannot be built.
pub fn fit(
    record: &Record,
    origin: &Model,
    starts: &[Model],
    coordinates: &[Coordinate],
    window_s: f64,
) -> Result<Simulated, BuildError> {
    let windows = windows(record, window_s);
    let expected = noise::expected(origin, record);
    let errors = |model: &Model| free_run::errors(model, record, &expected, &windows);
    let first = errors(starts.first().unwrap_or(origin))?;
    let mut best: Option<(f64, Model, [Option<f64>; CHANNELS])> = None;
    for start in starts {
        let (mut model, mut own) = (start.clone(), errors(start)?);
        for _ in 0..LAID {
            if interrupt::asked() {
                break;
            }
            let laid = Laid::new(record, &windows, &model, &expected, &own);
            let mask = vec![1.0; laid.record.len()];
            let problem = Problem::new(&laid.record, &mask).rough();
            let fit = problem.fit(origin, &model, coordinates, &laid.noise, ROUNDS)?;
            let there = errors(&fit.model)?;
            let gained = 1.0 - mean(&there, &first) / mean(&own, &first);
            if gained > 0.0 {
                (model, own) = (fit.model, there);
            }
            if gained.is_nan() || gained < WORTHWHILE {
                break;
            }
        }
        let left = mean(&own, &first);
        if best.as_ref().is_none_or(|(least, ..)| left < *least) {
            best = Some((left, model, own));
        }
    }
    let (_, model, last) = best.unwrap_or_else(|| (1.0, origin.clone(), first));
    let laid = Laid::new(record, &windows, &model, &expected, &last);
    let covariance = laid.covariance(origin, &model, coordinates)?;
    Ok(Simulated { model, covariance, errors: [first, last], windows: windows.len() })
}

/// The windows of a record: as long as asked for, within its logs.
fn windows(record: &Record, window_s: f64) -> Vec<Range<usize>> {
    let every = vec![true; record.len()];
    let samples = (window_s / record.grid.typical_interval()).round();
    let samples = if samples.is_finite() { (samples as usize).max(LEAST) } else { LEAST };
    let mut all = Vec::new();
    for whole in free_run::stretches(record, &every) {
        let count = (whole.len() / samples).max(1);
        let at = |number: usize| whole.start + number * whole.len() / count;
        all.extend((0..count).map(|number| at(number)..at(number + 1)));
    }
    all.retain(|window| window.len() >= LEAST);
    all
}

/// Mean over the channels of a run's squared errors in units of another's.
fn mean(own: &[Option<f64>; CHANNELS], unit: &[Option<f64>; CHANNELS]) -> f64 {
    let pairs = own.iter().zip(unit).filter_map(|(own, unit)| Some((*own)? / (*unit)?));
    let (sum, count) =
        pairs.fold((0.0, 0.0), |(sum, count), ratio| (sum + ratio * ratio, count + 1.0));
    if count > 0.0 { sum / count } else { f64::INFINITY }
}

/// A record cut into windows, with the state in which each begins.
struct Laid {
    record: Record,
    noise: Noise,
}

impl Laid {
    fn new(
        record: &Record,
        windows: &[Range<usize>],
        model: &Model,
        expected: &Noise,
        errors: &[Option<f64>; CHANNELS],
    ) -> Self {
        let mut part = record.stretches(windows);
        part.motions = motions(record, windows, model);
        part.motions.retain(|motion| part.cuts.contains(&motion.sample));
        let mut noise = expected.distrusted(SIMULATED);
        for channel in Channel::ALL {
            let c = channel as usize;
            if let Some(error) = errors[c].filter(|error| error.is_finite()) {
                noise.sensors[c] = noise.sensors[c].max(error);
            }
        }
        Self { record: part, noise }
    }

    /// The covariance of a fit's coordinates: with errors that are correlated within a window and not from one to
    /// another (sandwich estimator; White, Econometrica 50, 1982).
    fn covariance(
        &self,
        origin: &Model,
        model: &Model,
        coordinates: &[Coordinate],
    ) -> Result<DMatrix<f64>, BuildError> {
        let mask = vec![1.0; self.record.len()];
        let problem = Problem::new(&self.record, &mask);
        let design = problem.design(model, &self.noise)?;
        let jacobian = problem.sensitivity(model, &design.gains, coordinates, None);
        let precision = precision(coordinates);
        let curvature = gram(&jacobian) + DMatrix::from_diagonal(&precision);
        let count = coordinates.len();
        let Some(inverse) = curvature.cholesky().map(|factor| factor.inverse()) else {
            return Ok(DMatrix::zeros(count, count));
        };
        let residual = problem.residual(&design.innovations);
        let offset = coordinates.iter().map(|c| c.distance(origin, model));
        let pull = precision.component_mul(&DVector::from_iterator(count, offset));
        let starts = &self.record.starts;
        let ends = starts.iter().skip(1).copied().chain([self.record.len()]);
        let mut scatter = DMatrix::from_diagonal(&precision);
        for (start, end) in starts.iter().zip(ends) {
            let (first, rows) = (start * CHANNELS, (end - start) * CHANNELS);
            let own = jacobian.rows(first, rows).into_owned();
            let error = DMatrix::from_column_slice(rows, 1, residual.rows(first, rows).as_slice());
            let score = shared(&own, &error).column(0) + &pull / starts.len() as f64;
            scatter += &score * score.transpose();
        }
        Ok(&inverse * scatter * &inverse)
    }
}

/// What a refit by simulation moves of a model's own effects: sizes, each with its phase, from the values they
/// have. Orders, widths and references stay.
pub fn of_effects(model: &Model) -> Vec<Coordinate> {
    let mut all = Vec::new();
    for (effect, own) in model.effects.iter().enumerate() {
        let specs = own.kind.spec().parameters;
        for (value, spec) in specs.iter().enumerate() {
            let size = own.values[value].abs();
            let is_size = size > 0.0 && !KEPT.iter().any(|kept| spec.key.contains(kept));
            if !is_size {
                continue;
            }
            let scale = SCALE * size;
            let phased = specs.get(value + 1).is_some_and(|next| next.key.ends_with("phase_rad"));
            match phased {
                true => all.extend([false, true].map(|sine| Coordinate::Phasor {
                    effect,
                    amplitude: value,
                    sine,
                    scale,
                    sigma: SIGMA,
                })),
                false => all.push(Coordinate::Effect { effect, value, scale, sigma: SIGMA }),
            }
        }
    }
    all
}

/// Parts of the keys of values that a refit leaves as they are.
const KEPT: [&str; 5] = ["phase", "order", "width", "reference", "time_constant"];
/// Share of an effect's size at which a change matters, and one sigma of its prior in such shares: its own size.
const SCALE: f64 = 0.1;
const SIGMA: f64 = 10.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Quantity;
    use crate::refit;
    use joint_simulation::demo::actuator;
    use joint_simulation::synthetic::{Experiment, record};

    #[test]
    fn a_wrong_inertia_and_friction_are_found_by_runs_of_a_fifth_of_a_second() {
        let mut truth = actuator();
        truth.stages.clear();
        let log =
            record(&truth, &Experiment { duration_s: 2.0, ..Experiment::default() }, 3).unwrap();
        let record = Record::new(&log, Some(2));
        let mut nominal = truth.clone();
        nominal.motor.rotor_inertia_kg_m2 *= 1.1;
        nominal.motor.friction.coulomb_nm *= 0.8;
        let every = vec![1.0; record.len()];
        let moved = refit::coordinates(&nominal, &Problem::new(&record, &every));
        let found = fit(&record, &nominal, std::slice::from_ref(&nominal), &moved, 0.2).unwrap();
        let [before, after] = found.errors.map(|errors| errors[Channel::Motor as usize].unwrap());
        assert!(found.windows >= 9 && after < 0.2 * before, "{before} {after} {}", found.windows);
        let own = |quantity: Quantity| (quantity.get(&found.model) / quantity.get(&truth)).ln();
        for (k, coordinate) in moved.iter().enumerate() {
            let Coordinate::Parameter(quantity) = *coordinate else { continue };
            if !matches!(quantity, Quantity::Inertia(0) | Quantity::Coulomb(0)) {
                continue;
            }
            let sigma = found.covariance[(k, k)].sqrt();
            // Four standard errors, and a per cent for the noise of the joint, which a run does not know.
            assert!(
                sigma < 0.05 && own(quantity).abs() < 4.0 * sigma + 0.01,
                "{quantity:?}: {} {sigma}",
                own(quantity)
            );
        }
    }
}
