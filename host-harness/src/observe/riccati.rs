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
    /// Walk of every bristle in a step, as a share of its Coulomb level.
    pub bristle: f64,
}

/// Gains of one regime.
#[derive(Clone, Debug)]
pub struct Median {
    /// By channel: correction of every quantity for an innovation of one unit.
    pub gain: DMatrix<f64>,
    /// One sigma of each channel's innovation.
    pub sigma: [f64; CHANNELS],
}

/// Runs the covariance along a motion and takes the medians of the gains where `when` says so; `None`
/// where that is nowhere.
pub fn medians(linear: &Linear, uncertain: &Uncertain, when: &[Vec<bool>]) -> Vec<Option<Median>> {
    let order = linear.order;
    let size = order.len();
    let used: Vec<usize> = (0..CHANNELS).filter(|&c| uncertain.sensors[c].is_finite()).collect();
    let h = linear.shows.select_rows(&used);
    let mut p = DMatrix::<f64>::zeros(size, size);
    let square = |value: f64| value * value;
    for (index, sigma) in [
        (order.load(), 100.0 * uncertain.load),
        (order.slope(), uncertain.slope),
        (order.bias(), 100.0 * uncertain.bias),
    ] {
        p[(index, index)] = square(sigma);
    }
    for index in 0..order.states() {
        p[(index, index)] = 1e-12;
    }
    let mut gains: Vec<Vec<DMatrix<f64>>> = vec![Vec::new(); when.len()];
    let mut variances: Vec<Vec<[f64; CHANNELS]>> = vec![Vec::new(); when.len()];
    let slope_walk = uncertain.slope * (1.0 - square(uncertain.leak)).max(0.0).sqrt();
    for (k, transition) in linear.transition.iter().enumerate() {
        let ph = &p * h.transpose();
        let mut s = &h * &ph;
        for (row, &c) in used.iter().enumerate() {
            s[(row, row)] += square(uncertain.sensors[c]);
        }
        let Some(inverse) = s.clone().try_inverse() else { continue };
        let gain = &ph * inverse;
        p -= &gain * ph.transpose();
        let mut variance = [0.0; CHANNELS];
        for (row, &c) in used.iter().enumerate() {
            variance[c] = s[(row, row)];
        }
        for (slot, mask) in when.iter().enumerate() {
            if mask[k] {
                gains[slot].push(gain.clone());
                variances[slot].push(variance);
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
        .map(|(gains, variances)| {
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
            Some(Median { gain, sigma })
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
