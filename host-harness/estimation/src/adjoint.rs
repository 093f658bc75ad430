//! What the prediction errors pull at: their derivative with a push on any equation at any sample.
//!
//! One pass backward through the filter gives it for every sample at once, so that any shape a
//! missing effect may have along the record is tried at the cost of a sum over samples.

use super::filter::{Equation, Gains, Linearisation, Observer};
use super::record::{CHANNELS, Channel};

/// By sample: how a push on an equation, held over the interval after the sample, would change the
/// weighted sum of the innovations.
#[derive(Clone, Debug, Default)]
pub struct Pull {
    /// Torques on every mass, reflected to the motor, per Nm.
    pub torque: Vec<Vec<f64>>,
    /// The drive, per V, or per A where the current is imposed.
    pub drive: Vec<f64>,
    /// What each sensor shows, at the sample itself, per its unit.
    pub sensor: [Vec<f64>; CHANNELS],
}

impl Observer<'_> {
    /// The pull of `weights` by sample and channel: `Σ w ∂e/∂push`.
    pub fn pull(&self, gains: &Gains, along: &Linearisation, weights: &[[f64; CHANNELS]]) -> Pull {
        let (n, order, samples) = (self.layout.len(), gains.order, self.record.len());
        let masses = self.layout.stages + 1;
        let mut pull = Pull {
            torque: vec![vec![0.0; samples]; masses],
            drive: vec![0.0; samples],
            sensor: std::array::from_fn(|_| vec![0.0; samples]),
        };
        let mut later = vec![0.0; order];
        let mut now = vec![0.0; order];
        let mut row = vec![0.0; order];
        let mut kick = vec![0.0; order];
        for k in (0..samples).rev() {
            if k + 1 < samples {
                for (mass, torque) in pull.torque.iter_mut().enumerate() {
                    kick.fill(0.0);
                    self.push(&mut kick, mass, 1.0, self.record.grid.interval(k));
                    torque[k] = dot(&kick, &later);
                }
                pull.drive[k] = dot(&along.drive[k * n..(k + 1) * n], &later);
                now.copy_from_slice(&later);
                now[..n].fill(0.0);
                for (i, later) in later.iter().enumerate().take(n) {
                    let from = &along.transition[(k * n + i) * n..(k * n + i + 1) * n];
                    for (now, slope) in now.iter_mut().zip(from) {
                        *now += slope * later;
                    }
                }
                for (j, walk) in gains.walks.iter().enumerate() {
                    now[n + j] *= walk.kept(self.record.grid.interval(k));
                    now[n + j] += match walk.equation {
                        Equation::Voltage => pull.drive[k],
                        Equation::Torque(mass) => pull.torque[mass][k],
                        Equation::Sensor(_) => 0.0,
                    };
                }
                later.copy_from_slice(&now);
            }
            for channel in Channel::ALL.into_iter().rev() {
                let c = channel as usize;
                let weight = gains.weight[k][c];
                if weight == 0.0 {
                    continue;
                }
                let slot = (k * CHANNELS + c) * order;
                let along_error = weights[k][c] + dot(&gains.gain[slot..slot + order], &later);
                pull.sensor[c][k] = -weight * along_error;
                self.sensitivity(channel, &gains.walks, &mut row);
                for (later, row) in later.iter_mut().zip(&row) {
                    *later -= weight * along_error * row;
                }
            }
            if self.record.starts.contains(&k) {
                later.fill(0.0);
            }
        }
        pull
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
