//! Gains along a motion, and the constant ones that stand for them.

use nalgebra::{DMatrix, DVector};

use super::linear::Linear;
use crate::estimate::record::CHANNELS;

/// One sigma of everything that is uncertain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uncertain {
    /// Drive held over a sample, V or A.
    pub drive: f64,
    /// Torque on the rotor held over a sample, Nm.
    pub torque: f64,
    /// The sensors; infinite where there is none.
    pub sensors: [f64; CHANNELS],
    /// Load's own walk, Nm a step.
    pub load: f64,
    /// Load's slope, Nm a step, in the mean of time.
    pub slope: f64,
    /// Share of the slope that is left after a step.
    pub leak: f64,
    /// Walk of the missing drive, V or A a step.
    pub bias: f64,
    /// Walk of the resistance a step, as a share.
    pub ohm: f64,
    /// Walk of the flux a step, as a share.
    pub flux: f64,
    /// Walk of friction's level a step, as a share.
    pub level: f64,
    /// Share by which the running mean of what friction takes follows it.
    pub mean_deceleration: f64,
    /// Walk of every bristle in a step, as a share of its Coulomb level.
    pub bristle: f64,
}

/// What is known of the resistance at first: one sigma, as a share.
const OHM: f64 = 0.05;
/// The same of the flux.
const FLUX: f64 = 0.01;
/// The same of friction's level.
const LEVEL: f64 = 0.07;

/// Gains of one regime.
#[derive(Clone, Debug)]
pub struct Median {
    /// By channel: correction of every quantity for an innovation of one unit.
    pub gain: DMatrix<f64>,
    /// One sigma of each channel's innovation.
    pub sigma: [f64; CHANNELS],
    /// Correction of resistance and flux for an innovation of the current of 1 A, at a current of
    /// 1 A and a speed of 1 rad/s.
    pub scale: [f64; 2],
    /// By channel: correction of friction's level for an innovation of one unit where friction takes
    /// 1 rad/s more of the rotor's speed in a step than in the mean.
    pub level: [f64; CHANNELS],
}

/// Runs the covariance along a motion and takes the medians of the gains where `when` says so; `None`
/// where that is nowhere.
pub fn medians(linear: &Linear, uncertain: &Uncertain, when: &[Vec<bool>]) -> Vec<Option<Median>> {
    let order = linear.order;
    let size = order.size();
    let used: Vec<usize> = (0..CHANNELS).filter(|&c| uncertain.sensors[c].is_finite()).collect();
    let mut h = linear.shows.select_rows(&used);
    let mut p = DMatrix::<f64>::zeros(size, size);
    let square = |value: f64| value * value;
    for (index, sigma) in [
        (order.load(), 100.0 * uncertain.load),
        (order.slope(), uncertain.slope),
        (order.bias(), 100.0 * uncertain.bias),
        (order.ohm(), OHM),
        (order.flux(), FLUX),
        (order.level(), LEVEL),
    ] {
        p[(index, index)] = square(sigma);
    }
    for index in 0..order.states() {
        p[(index, index)] = 1e-12;
    }
    let mut gains: Vec<Vec<DMatrix<f64>>> = vec![Vec::new(); when.len()];
    let mut scales = vec![[[0.0; 2]; 2]; when.len()];
    let mut levels = vec![[0.0; CHANNELS + 1]; when.len()];
    let mut mean = 0.0;
    let mut variances: Vec<Vec<[f64; CHANNELS]>> = vec![Vec::new(); when.len()];
    let slope_walk = uncertain.slope * (1.0 - square(uncertain.leak)).max(0.0).sqrt();
    for (k, transition) in linear.transition.iter().enumerate() {
        if used.first() == Some(&0) {
            // More flux makes more of a measured current.
            h[(0, order.flux())] = -linear.running[k][0];
        }
        let ph = &p * h.transpose();
        let mut s = &h * &ph;
        for (row, &c) in used.iter().enumerate() {
            s[(row, row)] += square(uncertain.sensors[c]);
        }
        let Some(inverse) = s.clone().try_inverse() else { continue };
        let gain = &ph * inverse;
        p -= &gain * ph.transpose();
        let beside = linear.deceleration[k] - mean;
        mean += uncertain.mean_deceleration * beside;
        let mut variance = [0.0; CHANNELS];
        for (row, &c) in used.iter().enumerate() {
            variance[c] = s[(row, row)];
        }
        for (slot, mask) in when.iter().enumerate() {
            if mask[k] {
                gains[slot].push(gain.clone());
                variances[slot].push(variance);
                for (row, &c) in used.iter().enumerate() {
                    levels[slot][c] += gain[(order.level(), row)] * beside;
                }
                levels[slot][CHANNELS] += beside * beside;
                if used.first() == Some(&0) {
                    let rows = [order.ohm(), order.flux()];
                    for ((sums, row), by) in
                        scales[slot].iter_mut().zip(rows).zip(linear.running[k])
                    {
                        sums[0] += gain[(row, 0)] * by;
                        sums[1] += by * by;
                    }
                }
            }
        }
        let mut f = transition.clone();
        f[(order.slope(), order.slope())] = uncertain.leak;
        let by_drive: DVector<f64> = f.column(order.bias()).into_owned();
        p = &f * &p * f.transpose();
        let mut by_drive = by_drive;
        by_drive[order.bias()] = 0.0;
        p += &by_drive * by_drive.transpose() * square(uncertain.drive);
        p += &linear.kick * linear.kick.transpose() * square(uncertain.torque);
        p[(order.load(), order.load())] += square(uncertain.load);
        p[(order.slope(), order.slope())] += square(slope_walk);
        p[(order.bias(), order.bias())] += square(uncertain.bias);
        p[(order.ohm(), order.ohm())] += square(uncertain.ohm);
        p[(order.flux(), order.flux())] += square(uncertain.flux);
        p[(order.level(), order.level())] += square(uncertain.level);
        for mass in 0..=order.plant.stages {
            let index = order.plant.bristle(mass);
            p[(index, index)] += square(uncertain.bristle);
        }
        let transposed = p.transpose();
        p = (p + transposed) * 0.5;
    }
    gains
        .iter()
        .zip(&variances)
        .zip(scales.iter().zip(&levels))
        .map(|((gains, variances), (scale, level))| {
            if gains.is_empty() {
                return None;
            }
            let mut gain = DMatrix::zeros(size, CHANNELS);
            for (column, &c) in used.iter().enumerate() {
                for row in 0..size {
                    gain[(row, c)] = median(gains.iter().map(|g| g[(row, column)]));
                }
            }
            let sigma =
                std::array::from_fn(|c| median(variances.iter().map(|v| v[c])).max(0.0).sqrt());
            let scale =
                scale.map(|[product, square]| if square > 0.0 { product / square } else { 0.0 });
            let [.., square] = *level;
            let level = std::array::from_fn(|c| if square > 0.0 { level[c] / square } else { 0.0 });
            Some(Median { gain, sigma, scale, level })
        })
        .collect()
}

/// The middle of some values.
pub fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
