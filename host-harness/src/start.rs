//! The state of a joint at a sample of its log, without a filter.
//!
//! A free run has to begin where the joint was: at the angle of the sample, with the speed of the samples
//! around it and the wind-up that both encoders show. Begun at rest at zero, it measures where the encoder's
//! zero lies.

use nalgebra::{Matrix3, Vector3};

use crate::layout::Layout;
use crate::log::Log;
use crate::model::Model;
use crate::plant::output_shaft;
use crate::preflight::{median, scatter};

/// Samples on either side that a speed is taken from, at least and at most.
const SIDES: [usize; 2] = [4, 128];
/// Times the encoder's scatter that a parabola may leave.
const LEFT: f64 = 1.5;
/// Standard errors of a speed within which the joint is at rest.
const RESTS: f64 = 3.0;

/// The states that a log shows.
pub struct Measured<'a> {
    log: &'a Log,
    layout: Layout,
    scatter: f64,
    shaft: f64,
    /// What the output encoder shows beside the motor's angle through the gear, without wind-up, rad.
    offset: f64,
    /// The stages' shares in a wind-up, at the motor over at the output.
    shares: Vec<f64>,
}

impl<'a> Measured<'a> {
    /// Of a log of this joint.
    pub fn new(model: &Model, log: &'a Log) -> Self {
        let shaft = output_shaft(model);
        let offset = log.output_angle_rad.as_ref().and_then(|output| {
            let pairs = output.iter().zip(&log.motor_angle_rad);
            median(
                pairs.map(|(out, motor)| out - motor * shaft).filter(|d| d.is_finite()).collect(),
            )
        });
        // Stages in series share a wind-up by their compliances, at the motor.
        let mut own = 1.0;
        let compliances: Vec<f64> = model
            .stages
            .iter()
            .map(|stage| {
                own /= stage.reduction;
                1.0 / (stage.stiffness_nm_per_rad * own * own)
            })
            .collect();
        let whole: f64 = compliances.iter().sum();
        Self {
            log,
            layout: Layout::of(model),
            scatter: scatter(&log.motor_angle_rad),
            shaft,
            offset: offset.unwrap_or(0.0),
            shares: compliances.iter().map(|own| own / whole).collect(),
        }
    }

    /// What the output encoder shows beside the motor's angle through the gear, rad.
    pub fn output_offset(&self) -> f64 {
        self.offset
    }

    /// The state at sample `k`, as [`Layout`] has it; `None` where no angle is known there.
    pub fn at(&self, k: usize) -> Option<Vec<f64>> {
        let angle = *self.log.motor_angle_rad.get(k).filter(|angle| angle.is_finite())?;
        let mut state = vec![0.0; self.layout.len()];
        state[Layout::ANGLE] = angle;
        if let Some(current) = self.log.current_a.as_ref().map(|current| current[k]) {
            state[Layout::CURRENT] = if current.is_finite() { current } else { 0.0 };
        }
        let (speed, error) = self.speed(k).unwrap_or((0.0, 0.0));
        // At rest the bristles may lean either way; in motion they are stretched.
        let moves = speed.abs() > RESTS * error;
        let wound = self.log.output_angle_rad.as_ref().map(|output| output[k] - self.offset);
        let wound = wound.map(|output| angle - output / self.shaft).filter(|w| w.is_finite());
        for (stage, share) in self.shares.iter().enumerate() {
            state[self.layout.deflection(stage)] = share * wound.unwrap_or(0.0);
        }
        for mass in 0..=self.layout.stages {
            state[self.layout.speed(mass)] = if moves { speed } else { 0.0 };
            state[self.layout.bristle(mass)] = if moves { speed.signum() } else { 0.0 };
        }
        Some(state)
    }

    /// Rotor speed at a sample, rad/s, with its standard error: the slope of a parabola through as many
    /// samples around it as one describes.
    fn speed(&self, k: usize) -> Option<(f64, f64)> {
        let mut best = None;
        let mut side = SIDES[0];
        while side <= SIDES[1] {
            // At the ends of a log the other side gives twice as many.
            let from = k.saturating_sub(side);
            let to = (k + side + (side - (k - from))).min(self.log.len() - 1);
            let from = from.min(to.saturating_sub(2 * side));
            let Some((slope, error, left)) = self.parabola(k, from..to + 1) else { break };
            if best.is_some() && left > LEFT * self.scatter {
                break;
            }
            best = Some((slope, error));
            side *= 2;
        }
        best
    }

    fn parabola(&self, k: usize, around: std::ops::Range<usize>) -> Option<(f64, f64, f64)> {
        let time = &self.log.time_s;
        let angle = &self.log.motor_angle_rad;
        let unit = (time[around.end - 1] - time[around.start]) * 0.5;
        let rows = || {
            around.clone().filter(|j| angle[*j].is_finite()).map(|j| {
                let s = (time[j] - time[k]) / unit;
                (Vector3::new(1.0, s, s * s), angle[j] - angle[k])
            })
        };
        let (mut gram, mut right) = (Matrix3::zeros(), Vector3::zeros());
        let mut count = 0.0;
        for (row, value) in rows() {
            gram += row * row.transpose();
            right += row * value;
            count += 1.0;
        }
        let inverse = gram.try_inverse().filter(|_| count > 3.0)?;
        let fit = inverse * right;
        let squares: f64 = rows().map(|(row, value)| (value - row.dot(&fit)).powi(2)).sum();
        let left = (squares / (count - 3.0)).sqrt();
        let error = left.max(self.scatter) * inverse[(1, 1)].sqrt() / unit;
        Some((fit[1] / unit, error, left))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::actuator;
    use crate::synthetic::{Experiment, record};

    #[test]
    fn the_state_on_the_way_is_that_of_the_samples_around() {
        let model = actuator();
        let time_s: Vec<f64> = (0..2000).map(|k| 1e-3 * f64::from(k)).collect();
        let motor_angle_rad = time_s.iter().map(|t| 4.0 + 3.0 * (5.0 * t).sin()).collect();
        let output = time_s.iter().map(|t| 0.7 + 3.0 * (5.0 * t).sin() / 9.0).collect();
        let log = Log { time_s, motor_angle_rad, output_angle_rad: Some(output), ..Log::default() };
        let measured = Measured::new(&model, &log);
        let layout = Layout::of(&model);
        for (k, tolerance) in [(0, 0.05), (700, 0.01), (1999, 0.05)] {
            let state = measured.at(k).unwrap();
            let speed = 15.0 * (5.0 * log.time_s[k]).cos();
            // The parabola leaves the sine's third derivative: less than a hundredth of its largest rate.
            assert!((state[layout.speed(0)] - speed).abs() < 15.0 * tolerance, "{k}");
            assert_eq!(state[layout.bristle(1)], speed.signum());
            assert!(state[layout.deflection(0)].abs() < 1e-9, "the encoders' zeros are no wind-up");
        }
    }

    #[test]
    fn a_joint_at_rest_starts_at_rest() {
        let model = actuator();
        let log = record(&model, &Experiment::default(), 3).unwrap();
        let state = Measured::new(&model, &log).at(0).unwrap();
        assert_eq!(state[Layout::of(&model).speed(0)], 0.0);
    }
}
