//! The best that any causal linearised filter can do on a motion: what an observer is to be measured by.
//!
//! A time-varying Kalman filter with the joint's true parameters, its true noises and the true motion
//! to linearise along has the least covariance of all linear filters (R. E. Kalman, "A new approach to
//! linear filtering and prediction problems", J. Basic Eng. 82(1), 1960). What no covariance holds is
//! the load, which is no noise. Two answers:
//!
//! * the *bound*: the filter is told when the load jumps and by how much, though not to which side, and
//!   at every sample how strongly its slope changes. What it then takes to see the load is the sensors'.
//! * the *full filter*: it is told nothing, but its process noise is the best on this very motion.
//!
//! Both are free of chance: the error's covariance and, beside it, the error that the load itself makes
//! are carried along with the gains (A. H. Jazwinski, Stochastic Processes and Filtering Theory, 1970,
//! section 7.8: sensitivity to wrong noise models).

use joint_core::joint::Drive;
use nalgebra::{DMatrix, DVector};

use super::linear::{Linear, Order, linearise};
use super::noise::sensors;
use super::rating::Rating;
use super::truth::friction;
use super::twin::{Felt, Twin};
use crate::estimate::record::CHANNELS;
use crate::model::Model;
use crate::plant::BuildError;

/// A motion of a joint whose every parameter is known, and how well it is measured.
#[derive(Clone, Copy, Debug)]
pub struct Known<'a> {
    /// The joint as it is.
    pub truth: &'a Model,
    /// What its drive imposes.
    pub kind: Drive,
    /// Time between samples, s.
    pub step_s: f64,
    /// For what loads it is built.
    pub rating: &'a Rating,
    /// Its motion.
    pub motion: &'a Twin,
    /// Noise on the joint.
    pub felt: Felt,
    /// Whether there is an output encoder.
    pub output: bool,
}

/// RMS errors over the motion after its first tenth, in the units of a score.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// Load, share of its peak.
    pub load: f64,
    /// First wind-up, share of its peak; NaN without stages.
    pub first: f64,
    /// Last wind-up, share of its peak; NaN without stages.
    pub windup: f64,
    /// Friction, share of its RMS.
    pub friction: f64,
}

impl Bound {
    /// Nothing is known.
    pub const NONE: Self =
        Self { load: f64::NAN, first: f64::NAN, windup: f64::NAN, friction: f64::NAN };
}

/// The bound, and the full filter with the best process noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Told when the load changes.
    pub told: Bound,
    /// Told nothing.
    pub filter: Bound,
}

/// How much more than its own size at a sample a change of the load's slope is taken for: it goes on
/// to the same side for some time.
const TOLD: [f64; 4] = [1.0, 10.0, 100.0, 1000.0];
/// Walk of the load, in rated loads per root second.
const WALKS: [f64; 3] = [0.05, 0.5, 5.0];
/// Slope of the load, in rated loads per second.
const SLOPES: [f64; 4] = [5.0, 30.0, 150.0, 700.0];
/// Time constant of that slope, s.
const LEAK_S: f64 = 0.02;

/// What a load does in a step, as a filter has it.
#[derive(Clone, Copy, Debug)]
enum Walk {
    /// Nothing but what it is told of, with such a share of the change of slope.
    Told(f64),
    /// Load's walk and its slope, one sigma a step each.
    Steady(f64, f64),
}

/// The best of each kind on a motion.
///
/// # Errors
/// The model cannot be built.
pub fn bounds(known: &Known<'_>) -> Result<Bounds, BuildError> {
    let Known { truth, kind, step_s, rating, motion, output, .. } = *known;
    let sigma = sensors(truth);
    let linear = linearise(truth, kind, step_s, motion, &sigma)?;
    let channels: Vec<usize> = (0..CHANNELS)
        .filter(|&c| {
            let imposed = c == 0 && kind == Drive::Current;
            sigma[c].is_finite() && !imposed && (output || c < 2)
        })
        .collect();
    let filter = Filter::new(known, &linear, &channels, &sigma);
    let best = |walks: &mut dyn Iterator<Item = Walk>| {
        walks.map(|walk| filter.errors(walk)).min_by(|a, b| a.load.total_cmp(&b.load))
    };
    let told = best(&mut TOLD.into_iter().map(Walk::Told)).unwrap_or(Bound::NONE);
    let steady = |walk: f64, slope: f64| {
        Walk::Steady(walk * rating.load_nm * step_s.sqrt(), slope * rating.load_nm * step_s)
    };
    // One free number after the other: the errors have one minimum in each.
    let mut best_steady = (f64::INFINITY, Bound::NONE, SLOPES[1]);
    for slope in SLOPES {
        let own = filter.errors(steady(WALKS[1], slope));
        if own.load < best_steady.0 {
            best_steady = (own.load, own, slope);
        }
    }
    for walk in [WALKS[0], WALKS[2]] {
        let own = filter.errors(steady(walk, best_steady.2));
        if own.load < best_steady.0 {
            best_steady = (own.load, own, best_steady.2);
        }
    }
    Ok(Bounds { told, filter: best_steady.1 })
}

/// The joint's states, then the load of the last step and its slope, Nm a step.
struct Filter {
    transition: Vec<DMatrix<f64>>,
    /// What noise on drive and rotor does in a step.
    noise: Vec<DMatrix<f64>>,
    shows: DMatrix<f64>,
    variance: DVector<f64>,
    /// What friction is made of, by sample.
    friction: Vec<DVector<f64>>,
    order: Order,
    /// The load's jump into every sample, Nm, and its slope otherwise.
    jumps: Vec<f64>,
    slopes: Vec<f64>,
    leak: f64,
    /// Peak of the load and of the wind-ups at the motor, RMS of friction.
    scale: [f64; 4],
}

impl Filter {
    fn new(
        known: &Known<'_>,
        linear: &Linear,
        channels: &[usize],
        sigma: &[f64; CHANNELS],
    ) -> Self {
        let Known { truth, step_s, motion, felt, .. } = *known;
        let order = linear.order;
        let layout = order.plant;
        let (n, size) = (order.states(), order.states() + 2);
        let part = |f: &DMatrix<f64>| f.view((0, 0), (size, size)).into_owned();
        let noise = linear.transition.iter().map(|f| {
            let mut noise = DMatrix::zeros(size, size);
            for by in [f.column(order.bias()) * felt.drive, &linear.kick * felt.torque] {
                let by = by.rows(0, n).into_owned();
                let mut states = noise.view_mut((0, 0), (n, n));
                states += &by * by.transpose();
            }
            noise
        });
        let slope_of = |state: &[f64]| {
            let mut slope = DVector::zeros(size);
            let mut moved = state.to_vec();
            for mass in 0..=layout.stages {
                for (index, by) in [(layout.speed(mass), 1e-6), (layout.bristle(mass), 1e-6)] {
                    let by = by * state[index].abs().max(1.0);
                    let own = state[index];
                    moved[index] = own + by;
                    let up = friction(truth, &moved);
                    moved[index] = own - by;
                    slope[index] = (up - friction(truth, &moved)) / (2.0 * by);
                    moved[index] = own;
                }
            }
            slope
        };
        let load = &motion.load;
        let mut jumps = vec![0.0; load.len()];
        let mut slopes = vec![0.0; load.len()];
        let peak = load.iter().fold(1e-12_f64, |most, load| most.max(load.abs()));
        for k in 1..load.len() {
            let step = load[k] - load[k - 1];
            let jumped = step.abs() > JUMP * peak;
            slopes[k] = if jumped { slopes[k - 1] } else { step };
            jumps[k] = if jumped { step - slopes[k] } else { 0.0 };
        }
        let most = |stage: Option<usize>| {
            let Some(stage) = stage else { return f64::NAN };
            let index = layout.deflection(stage);
            motion.states.iter().map(|x| x[index].abs()).fold(0.0, f64::max)
        };
        let last = layout.stages.checked_sub(1);
        let from = motion.states.len() / 10;
        let frictions: Vec<f64> =
            motion.states.iter().skip(from).map(|x| friction(truth, x)).collect();
        let squares: f64 = frictions.iter().map(|f| f * f).sum();
        let rms = (squares / frictions.len().max(1) as f64).sqrt();
        Self {
            transition: linear.transition.iter().map(part).collect(),
            noise: noise.collect(),
            shows: linear.shows.columns(0, size).select_rows(channels),
            variance: DVector::from_iterator(
                channels.len(),
                channels.iter().map(|&c| sigma[c] * sigma[c]),
            ),
            friction: motion.states.iter().map(|x| slope_of(x)).collect(),
            order,
            jumps,
            slopes,
            leak: (-step_s / LEAK_S).exp(),
            scale: [peak, most(last.map(|_| 0)), most(last), rms],
        }
    }

    /// RMS errors of the filter with such a load.
    fn errors(&self, walk: Walk) -> Bound {
        let size = self.order.states() + 2;
        let (load, slope) = (self.order.load(), self.order.slope());
        let layout = self.order.plant;
        let identity = DMatrix::<f64>::identity(size, size);
        let measured = DMatrix::from_diagonal(&self.variance);
        let mut assumed = DMatrix::<f64>::zeros(size, size);
        if let Walk::Steady(_, slope_sigma) = walk {
            assumed[(slope, slope)] = slope_sigma * slope_sigma;
        }
        let mut real = DMatrix::<f64>::zeros(size, size);
        let mut bias = DVector::<f64>::zeros(size);
        let mut sums = [0.0; 4];
        let samples = self.transition.len();
        let from = samples / 10;
        for k in 0..samples {
            // Measured: gains by what the filter assumes, errors by what is.
            let shown = &assumed * self.shows.transpose();
            let mut innovation = &self.shows * &shown;
            innovation += &measured;
            let Some(inverse) = innovation.try_inverse() else { return Bound::NONE };
            let gain = shown * inverse;
            let kept = &identity - &gain * &self.shows;
            let by_sensors = &gain * &measured * gain.transpose();
            assumed = &kept * &assumed * kept.transpose() + &by_sensors;
            real = &kept * &real * kept.transpose() + &by_sensors;
            bias = &kept * &bias;
            if k >= from {
                // The load of this very sample is not felt yet: the slope foretells it.
                let ahead = bias[load] + bias[slope] + self.jumps[k];
                let foretold =
                    real[(load, load)] + 2.0 * real[(load, slope)] + real[(slope, slope)];
                sums[0] += foretold + ahead * ahead;
                for (sum, stage) in [(1, Some(0)), (2, layout.stages.checked_sub(1))] {
                    if let Some(stage) = stage.filter(|stage| *stage < layout.stages) {
                        let at = layout.deflection(stage);
                        sums[sum] += real[(at, at)] + bias[at] * bias[at];
                    }
                }
                let by = &self.friction[k];
                sums[3] += by.dot(&(&real * by)) + by.dot(&bias).powi(2);
            }
            // One step on: the load acts with its slope and its jump.
            let mut f = self.transition[k].clone();
            let acts = f.column(load).into_owned();
            if let Walk::Steady(..) = walk {
                f[(slope, slope)] = self.leak;
            }
            let slope_now = self.slopes[k];
            let slope_next = self.slopes.get(k + 1).copied().unwrap_or(slope_now);
            let changed = slope_next - slope_now;
            let jump = self.jumps[k];
            assumed = &f * &assumed * f.transpose() + &self.noise[k];
            real = &f * &real * f.transpose() + &self.noise[k];
            // What leaks of the filter's slope is an error of the true one.
            let leaks = if let Walk::Steady(..) = walk { 1.0 - self.leak } else { 0.0 };
            bias = &f * &bias + &acts * jump;
            bias[slope] += changed + leaks * slope_now;
            let (walks, slope_walks) = match walk {
                Walk::Told(times) => (jump * jump, times * changed * changed),
                Walk::Steady(walks, slope) => {
                    (walks * walks, slope * slope * (1.0 - self.leak * self.leak))
                }
            };
            assumed += &acts * acts.transpose() * walks;
            assumed[(slope, slope)] += slope_walks;
        }
        let mean = |sum: f64| (sum / (samples - from) as f64).sqrt();
        let [peak, first, last, rms] = self.scale;
        Bound {
            load: mean(sums[0]) / peak,
            first: mean(sums[1]) / first,
            windup: mean(sums[2]) / last,
            friction: mean(sums[3]) / rms,
        }
    }
}

/// Share of its peak from which on a change of the load in a step is a jump.
const JUMP: f64 = 0.02;
