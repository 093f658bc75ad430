//! The goodness-of-fit test: whether what a model leaves is noise.
//!
//! The best of a wrong list still wins its comparison. What gives it away is what it leaves behind:
//! noise far above what the sensors and the joint's nature lead one to expect, or innovations that
//! are not white where those of the model's own replicate are.

use crate::discover::bounds::{
    AUTOCORRELATION, DRIVE_RATIO, MULTIMODAL, PLAIN_TORQUE_RATIO, SCATTER, TORQUE_RATIO, UNSEEN,
    UNSEEN_OF_MULTIMODAL, VARIANCE,
};
use crate::estimate::filter::{Disturbed, Noise};
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::record::{CHANNELS, Channel};
use crate::estimate::replicate::null_innovations;
use crate::plant::BuildError;
use joint_core::joint::Drive;
use serde::{Deserialize, Serialize};

/// Replicates that tell what a right model leaves.
const REPLICATES: u64 = 6;
/// The first of their seeds.
const SEED: u64 = 100;
/// Most that an innovation counts for, in sigmas.
const BEYOND: f64 = 1e6;
/// Lags looked at.
const LAGS: usize = 8;

/// What a model leaves.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct Remainder {
    /// Noise on the drive over what is expected; one where the current is imposed.
    pub drive: f64,
    /// Noise on the rotor over what is expected.
    pub torque: f64,
    /// The same on the output; zero where it is taken to feel nothing of its own.
    #[serde(default)]
    pub output: f64,
    /// RMS of a disturbance of the rotor that is correlated in time, over the noise that is expected there; zero
    /// where there is none.
    #[serde(default)]
    pub disturbed: f64,
    /// Largest difference of an autocorrelation from the replicates' beyond their scatter, by channel.
    pub colour: [f64; CHANNELS],
    /// Variance over the replicates', by channel; zero where nothing is measured.
    pub variance: [f64; CHANNELS],
    /// RMS of the innovations on the replicates, by channel: the floor.
    pub floor: [f64; CHANNELS],
    /// The same over all channels.
    pub floor_all: f64,
    /// RMS of the innovations over a replicate's on samples that no fit has seen; zero where nobody asked.
    #[serde(default)]
    pub unseen: f64,
    /// Whether the likelihood of the model is multimodal: a chain of several stages, of which a few moments may go otherwise.
    #[serde(default)]
    pub multimodal: bool,
}

impl Remainder {
    /// Of a fitted model; `mask` weighs the samples that are looked at.
    ///
    /// # Errors
    /// The model cannot be built.
    pub fn of(
        problem: &Problem<'_>,
        fit: &Fit,
        expected: &Noise,
        mask: &[f64],
    ) -> Result<Self, BuildError> {
        let mut remainder = Self {
            drive: match problem.record.drive {
                Drive::Voltage => fit.noise.drive / expected.drive,
                Drive::Current => 1.0,
            },
            torque: fit.noise.torque / expected.torque,
            output: fit.noise.output_times(expected),
            disturbed: fit.noise.coloured[Disturbed::Rotor as usize].deviation / expected.torque,
            multimodal: is_multimodal(fit.model.stages.len()),
            ..Self::default()
        };
        let gains = problem.design(&fit.model, &fit.noise)?.gains;
        let seeds = SEED..SEED + REPLICATES;
        let nulls = null_innovations(&fit.model, problem, &fit.noise, &gains, seeds)?;
        for channel in Channel::ALL {
            let c = channel as usize;
            if !problem.record.has(channel) {
                continue;
            }
            let (own, own_colour) = moments(&fit.innovations, mask, c);
            let replicates: Vec<_> = nulls.iter().map(|null| moments(null, mask, c)).collect();
            let count = replicates.len() as f64;
            let variance = replicates.iter().map(|(v, _)| v).sum::<f64>() / count;
            remainder.variance[c] = own / variance;
            remainder.floor[c] = variance.sqrt();
            for lag in 0..LAGS {
                let colours: Vec<f64> = replicates.iter().map(|(_, colour)| colour[lag]).collect();
                // Errors smaller than a right model's are none, whatever their colour.
                let colour = remainder.variance[c].min(1.0) * beyond(own_colour[lag], &colours);
                remainder.colour[c] = remainder.colour[c].max(colour);
            }
        }
        let rows = nulls.iter().map(|null| rms(null, mask, None));
        remainder.floor_all = rows.sum::<f64>() / nulls.len() as f64;
        Ok(remainder)
    }

    /// Whether it fails on samples that no fit has seen.
    pub fn fails_unseen(&self) -> bool {
        self.unseen > if self.multimodal { UNSEEN_OF_MULTIMODAL } else { UNSEEN }
    }

    /// Whether a joint is disturbed by more than its own friction is expected to wander.
    pub fn is_driven(&self) -> bool {
        self.disturbed > TORQUE_RATIO
    }

    /// Why this is not noise; `plain` of a model to which nothing was added.
    pub fn complaints(&self, plain: bool) -> Vec<String> {
        let mut all = Vec::new();
        let torque = if plain { PLAIN_TORQUE_RATIO } else { TORQUE_RATIO };
        if self.drive > DRIVE_RATIO {
            all.push(format!(
                "it needs {:.1} times the noise on the drive that is expected",
                self.drive
            ));
        }
        for (times, mass) in [(self.torque, "rotor"), (self.output, "output")] {
            if times > torque {
                all.push(format!(
                    "it needs {times:.1} times the noise on the {mass} torque that is expected"
                ));
            }
        }
        if self.is_driven() {
            all.push(format!(
                "a torque on the rotor that is correlated in time is {:.1} times the noise that is expected there",
                self.disturbed
            ));
        }
        if self.fails_unseen() {
            all.push(format!(
                "on samples that no fit has seen the prediction errors are {:.2} times those of bootstrap replicates",
                self.unseen
            ));
        }
        for channel in Channel::ALL {
            let c = channel as usize;
            let column = channel.column();
            if self.colour[c] > AUTOCORRELATION {
                all.push(format!(
                    "the prediction errors of {column} are correlated (by {:.2} more than those of bootstrap replicates)",
                    self.colour[c]
                ));
            }
            if self.variance[c] > 1.0 + VARIANCE {
                all.push(format!(
                    "the prediction errors of {column} scatter {:.2} times as much as those of bootstrap replicates",
                    self.variance[c]
                ));
            }
        }
        all
    }
}

/// How far a value lies from the replicates' mean, beyond their scatter.
fn beyond(own: f64, replicates: &[f64]) -> f64 {
    let count = replicates.len().max(2) as f64;
    let mean = replicates.iter().sum::<f64>() / count;
    let square =
        replicates.iter().map(|replicate| (replicate - mean).powi(2)).sum::<f64>() / (count - 1.0);
    ((own - mean).abs() - SCATTER * square.sqrt()).max(0.0)
}

/// Variance and autocorrelations of one channel over the samples of a mask.
fn moments(rows: &[[f64; CHANNELS]], mask: &[f64], c: usize) -> (f64, [f64; LAGS]) {
    let weight: f64 = mask.iter().sum::<f64>().max(1.0);
    let at = |k: usize| mask[k] * rows[k][c].abs().min(BEYOND).copysign(rows[k][c]);
    let variance = (0..rows.len()).map(|k| at(k).powi(2)).sum::<f64>() / weight;
    let colour = std::array::from_fn(|lag| {
        let products = (lag + 1..rows.len()).map(|k| at(k) * at(k - lag - 1));
        products.sum::<f64>() / weight / variance.max(1e-12)
    });
    (variance, colour)
}

/// RMS of innovations over the samples of a mask: of one channel, or of all that are measured. One of a
/// model that has diverged counts as a million sigmas.
pub fn rms(rows: &[[f64; CHANNELS]], mask: &[f64], channel: Option<usize>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (row, mask) in rows.iter().zip(mask) {
        for (c, e) in row.iter().enumerate() {
            if *e != 0.0 && channel.is_none_or(|only| only == c) {
                sum += mask * e.abs().min(BEYOND).powi(2);
                count += mask;
            }
        }
    }
    if count > 0.0 { (sum / count).sqrt() } else { 0.0 }
}

/// Whether a chain of so many stages has a likelihood of several maxima.
fn is_multimodal(stages: usize) -> bool {
    stages >= MULTIMODAL
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::trial;
    use crate::estimate::filter::Colour;
    use crate::estimate::record::Record;

    #[test]
    fn noise_that_an_effect_may_leave_is_too_much_for_a_plain_model() {
        let complaints = |torque: f64, plain: bool| {
            Remainder { drive: 1.0, torque, ..Remainder::default() }.complaints(plain).len()
        };
        assert_eq!([complaints(1.6, true), complaints(3.0, true)], [0, 1]);
        assert_eq!([complaints(3.0, false), complaints(5.0, false)], [0, 1]);
    }

    #[test]
    fn what_fails_where_no_fit_has_looked_is_not_noise() {
        let left =
            |unseen: f64| Remainder { drive: 1.0, torque: 1.0, unseen, ..Remainder::default() };
        assert!([0.0, 1.0, 1.1].iter().all(|unseen| left(*unseen).complaints(false).is_empty()));
        let multimodal =
            |unseen: f64| Remainder { multimodal: true, ..left(unseen) }.complaints(true).len();
        assert_eq!([multimodal(1.2), multimodal(1.3), left(1.2).complaints(true).len()], [0, 1, 1]);
        let complaints = left(6.6).complaints(false);
        assert!(
            complaints.len() == 1
                && complaints[0].contains("6.60 times those of bootstrap replicates")
        );
    }

    #[test]
    fn a_disturbance_is_a_joints_own_as_long_as_friction_may_wander_by_it() {
        let left = |disturbed: f64| Remainder { disturbed, ..Remainder::default() };
        assert!(!left(3.0).is_driven() && left(3.0).complaints(true).is_empty());
        assert!(left(6.0).is_driven() && left(6.0).complaints(true).len() == 1);
    }

    #[test]
    fn what_replicates_scatter_by_is_theirs() {
        let apart = beyond(0.2, &[0.0, 0.1, -0.1, 0.0, 0.1, -0.1]);
        assert!((apart - (0.2 - SCATTER * 0.008_f64.sqrt())).abs() < 1e-12, "{apart}");
        assert_eq!(beyond(0.2, &[0.0, 0.3, 0.1, 0.2, 0.4, 0.3]), 0.0);
        assert!((beyond(0.2, &[0.01; 6]) - 0.19).abs() < 1e-12);
    }

    #[test]
    fn what_is_not_noise_is_told_by_channel() {
        let mut remainder = Remainder { drive: 1.0, torque: 1.0, ..Remainder::default() };
        remainder.colour[Channel::Motor as usize] = 0.3;
        remainder.variance[Channel::Output as usize] = 2.0;
        let complaints = remainder.complaints(true);
        assert_eq!(complaints.len(), 2);
        assert!(complaints[0].contains("motor_angle_rad") && complaints[0].contains("0.30"));
        assert!(complaints[1].contains("output_angle_rad") && complaints[1].contains("2.00"));
    }

    #[test]
    fn a_channel_varies_and_is_correlated_over_the_samples_of_the_mask() {
        let rows: Vec<[f64; CHANNELS]> = [1.0, -2.0, 3.0, 1e9, 5.0].map(|e| [0.0, e, 7.0]).into();
        let (variance, colour) = moments(&rows, &[1.0, 1.0, 1.0, 0.0, 1.0], 1);
        assert_eq!(variance, 39.0 / 4.0);
        // Products of neighbours −2 − 6, then 3 of two apart and 15, and −10 and 5 of those farther.
        let wanted = [-8.0, 18.0, -10.0, 5.0, 0.0, 0.0, 0.0, 0.0].map(|sum| sum / 4.0 / variance);
        assert!(colour.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12), "{colour:?}");
        assert_eq!(moments(&[[-1e9; CHANNELS]], &[1.0], 0).0, BEYOND * BEYOND);
    }

    #[test]
    fn an_rms_is_of_what_is_measured_of_one_channel_or_of_all() {
        let rows = [[3.0, 0.0, 1e9], [0.0, 4.0, 9.0]];
        let mask = [1.0, 1.0];
        assert_eq!(rms(&rows, &mask, Some(0)), 3.0);
        assert_eq!(rms(&rows[..1], &mask, Some(2)), BEYOND);
        assert_eq!(rms(&rows, &[0.0, 1.0], None), (97.0_f64 / 2.0).sqrt());
        assert_eq!(rms(&rows, &[0.0, 0.0], None), 0.0);
    }

    #[test]
    fn a_right_model_leaves_what_its_replicates_do_and_noise_is_told_by_what_is_expected() {
        let nominal = trial::motor();
        let line = trial::line(12.0).with("amplitude_nm", 0.0);
        let record = Record::new(&trial::log(&nominal, line, 4.0), None);
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask).rough();
        let fit = trial::fitted(&problem, &nominal, &[]).fit;
        let own = fit.noise;
        let mut expected = Noise { drive: 0.5 * own.drive, torque: 0.25 * own.torque, ..own };
        let told = |fit: &Fit, expected: &Noise| {
            Remainder::of(&problem, fit, expected, problem.mask).unwrap()
        };
        let left = told(&fit, &expected);
        assert_eq!(
            (left.drive, left.torque, left.disturbed, left.multimodal),
            (2.0, 4.0, 0.0, false)
        );
        for channel in [Channel::Current as usize, Channel::Motor as usize] {
            assert!((left.variance[channel] - 1.0).abs() < 0.15, "{left:?}");
            assert!((left.floor[channel] - 1.0).abs() < 0.1, "{left:?}");
            assert!(left.colour[channel] < AUTOCORRELATION, "{left:?}");
            let (variance, _) = moments(&fit.innovations, &mask, channel);
            let told = left.variance[channel] * left.floor[channel].powi(2);
            assert!((told / variance - 1.0).abs() < 1e-9, "{told} {variance}");
        }
        let output = Channel::Output as usize;
        assert_eq!((left.variance[output], left.floor[output]), (0.0, 0.0));
        assert!((left.floor_all - 1.0).abs() < 0.1, "{left:?}");
        let mut coloured = fit.clone();
        coloured.noise.coloured[Disturbed::Rotor as usize] =
            Colour { deviation: 3.0 * own.torque, correlation_s: 0.1 };
        expected.torque = own.torque;
        assert!((told(&coloured, &expected).disturbed - 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_chain_of_two_stages_and_more_is_multimodal() {
        assert_eq!([0, 1, 2, 3].map(is_multimodal), [false, false, true, true]);
    }

    #[test]
    fn what_is_at_its_bound_is_no_complaint_and_what_is_beyond_is() {
        let bound = Remainder {
            drive: DRIVE_RATIO,
            torque: TORQUE_RATIO,
            output: TORQUE_RATIO,
            disturbed: TORQUE_RATIO,
            unseen: UNSEEN,
            colour: [AUTOCORRELATION; CHANNELS],
            variance: [1.0 + VARIANCE; CHANNELS],
            ..Remainder::default()
        };
        assert!(bound.complaints(false).is_empty(), "{:?}", bound.complaints(false));
        let loud = Remainder { drive: 2.0 * DRIVE_RATIO, output: 9.0, ..bound };
        let complaints = loud.complaints(false);
        assert!(complaints[0].contains("6.0 times the noise on the drive"), "{complaints:?}");
        assert!(complaints[1].contains("9.0 times the noise on the output"), "{complaints:?}");
        assert_eq!(complaints.len(), 2);
    }
}
