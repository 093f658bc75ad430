//! What a log shows of its own sensors.
//!
//! A model says at most how many counts an encoder has. A log also shows interpolation errors, stamps
//! that jitter and two encoders that do not agree, and an observer that takes its measurements for
//! better than they are rejects them or follows their noise. White noise keeps its size under
//! repeated differences, where a motion vanishes: that gives the noise of each encoder. An
//! output encoder whose innovations do not agree with that is taken for as good as the output's angle
//! from the motor alone agrees with it (covariance matching: R. K. Mehra, "On the identification of
//! variances and adaptive Kalman filtering", IEEE Trans. Autom. Control 15(2), 1970).

use std::f64::consts::TAU;

use super::design::{Tuning, gains};
use super::noise::sensors;
use super::over::Samples;
use super::rating::Rating;
use super::run::{Seen, observer, run};
use crate::model::Model;
use crate::plant::BuildError;

/// An angle of a sample.
type Angle = fn(&Seen) -> f64;

/// Differences taken of an angle.
const ORDER: usize = 5;
/// Standard deviation of that difference of white noise of one: the root of C(10, 5).
const OF_DIFFERENCE: f64 = 15.874_507_866_387_544;
/// A sensor is taken for as good as the model says up to this ratio.
const AGREES: f64 = 2.0;
/// The same of the output's innovations, which hold what is uncertain of the load as well.
const CONSISTENT: f64 = 3.0;

impl Samples {
    /// The model with its encoders as the log shows them, and for what an observer has to be designed;
    /// `load_nm` where the load is known.
    ///
    /// # Errors
    /// The model cannot be built.
    pub fn sensed<const N: usize>(
        &self,
        model: &Model,
        load_nm: Option<f64>,
    ) -> Result<(Model, Rating), BuildError> {
        let mut model = model.clone();
        let sensor = &mut model.sensor;
        let channels: [(&mut f64, Angle); 2] = [
            (&mut sensor.motor_encoder_counts_per_rev, |seen| seen.motor),
            (&mut sensor.output_encoder_counts_per_rev, |seen| seen.output),
        ];
        for (counts, angle) in channels {
            if let Some(sigma) = self.white(angle)
                && (*counts <= 0.0 || sigma > AGREES * of_counts(*counts))
            {
                *counts = of_counts(sigma);
            }
        }
        let mut rating = self.rating::<N>(&model, load_nm)?;
        if N == 0 || !self.seen.iter().any(|seen| seen.output.is_finite()) {
            return Ok((model, rating));
        }
        let [.., sigma] = sensors(&model);
        if self.left::<N>(&model, &rating, self)? > CONSISTENT * sigma {
            let left = self.left::<N>(&model, &rating, &self.motor_only())?;
            model.sensor.output_encoder_counts_per_rev = of_counts(left.max(sigma));
            rating = self.rating::<N>(&model, load_nm)?;
        }
        Ok((model, rating))
    }

    /// White noise of an angle, one sigma, rad: half of what 95 % of its differences stay below, and at
    /// least what its smallest change leaves by rounding. `None` where it hardly is measured.
    fn white(&self, angle: Angle) -> Option<f64> {
        let rows: Vec<(f64, u32)> =
            self.seen.iter().map(angle).zip(self.steps.iter().copied()).collect();
        let even = |rows: &&[(f64, u32)]| rows.iter().skip(1).all(|(_, steps)| *steps == 1);
        let mut differences: Vec<f64> = rows
            .windows(ORDER + 1)
            .filter(even)
            .map(difference)
            .filter(|value| value.is_finite())
            .collect();
        let smallest = rows.windows(2).map(|pair| (pair[1].0 - pair[0].0).abs());
        let digit = smallest.filter(|step| *step > 1e-12).fold(f64::INFINITY, f64::min);
        let shown = 0.5 * share(&mut differences, 0.95)? / OF_DIFFERENCE;
        Some(if digit.is_finite() { shown.max(digit / 12.0_f64.sqrt()) } else { shown })
            .filter(|sigma| *sigma > 0.0)
    }

    /// How far the output's estimate from such samples stays from its encoder, one sigma, rad.
    fn left<const N: usize>(
        &self,
        model: &Model,
        rating: &Rating,
        given: &Samples,
    ) -> Result<f64, BuildError> {
        let design = gains::<N>(model, self.kind, self.step_s, rating, &Tuning::default())?;
        let observer = observer::<f64, N>(model, self.kind, self.step_s, &design)?;
        let found = run(&observer, &given.seen, &given.steps);
        let rows = found.iter().zip(&self.seen).skip(self.seen.len() / 20);
        let mut left: Vec<f64> = rows
            .map(|(found, seen)| (found.output_angle - seen.output).abs())
            .filter(|left| left.is_finite())
            .collect();
        Ok(0.5 * share(&mut left, 0.95).unwrap_or(0.0))
    }
}

/// Counts in a turn from the noise that they leave, rad, and the other way round.
fn of_counts(value: f64) -> f64 {
    TAU / value / 12.0_f64.sqrt()
}

/// The difference of that order of as many values and one.
fn difference(rows: &[(f64, u32)]) -> f64 {
    let mut values: Vec<f64> = rows.iter().map(|(value, _)| *value).collect();
    while values.len() > 1 {
        values = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    }
    values.first().map_or(f64::NAN, |value| value.abs())
}

/// What such a share of the values stays below.
fn share(values: &mut [f64], share: f64) -> Option<f64> {
    let index = (values.len() as f64 * share) as usize;
    (index < values.len()).then(|| *values.select_nth_unstable_by(index, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use joint_core::joint::Drive;

    use super::*;

    fn samples(angle: impl Fn(f64) -> f64) -> Samples {
        let seen = (0..2000).map(|k| Seen {
            drive: 0.0,
            current: f64::NAN,
            motor: angle(f64::from(k)),
            output: f64::NAN,
        });
        Samples { kind: Drive::Current, step_s: 1e-3, steps: vec![1; 2000], seen: seen.collect() }
    }

    #[test]
    fn a_moving_encoder_shows_the_noise_of_its_counts_and_no_motion() {
        for counts in [2000.0, 50_000.0] {
            let moving = |k: f64| 10.0 * (0.0126 * k).sin() + 1e-4 * k;
            let counted = |k: f64| (moving(k) / TAU * counts).round() / counts * TAU;
            let sigma = samples(counted).white(|seen| seen.motor).unwrap();
            // 2000 differences: a few per cent, and rounding is not quite white.
            let ratio = sigma / of_counts(counts);
            assert!((0.7..1.5).contains(&ratio), "{ratio} of the noise of {counts} counts");
        }
    }

    #[test]
    fn an_angle_that_is_never_measured_shows_nothing() {
        assert_eq!(samples(|_| f64::NAN).white(|seen| seen.output), None);
    }
}
