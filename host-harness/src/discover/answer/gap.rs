//! The gap: how far predictions miss on samples that no fit has seen.

use super::findings::Gap;
use crate::discover::checks::goodness_of_fit::{Remainder, rms};
use crate::estimate::abreast::Rows;
use crate::estimate::filter::Noise;
use crate::estimate::fit::{Fit, Problem};
use crate::estimate::record::{CHANNELS, Channel, Record};
use crate::plant::BuildError;

/// How far predictions miss on the samples of `mask`.
pub(crate) fn gap(
    record: &Record,
    before: &[[f64; CHANNELS]],
    after: &[[f64; CHANNELS]],
    floor: &Remainder,
    mask: &[f64],
) -> Gap {
    let signals = Channel::ALL
        .into_iter()
        .filter(|channel| record.has(*channel))
        .map(|channel| {
            let c = channel as usize;
            let own = |rows| rms(rows, mask, Some(c));
            (channel.column().to_owned(), [own(before), own(after), floor.floor[c]])
        })
        .collect();
    Gap {
        before: rms(before, mask, None),
        after: rms(after, mask, None),
        floor: floor.floor_all,
        unit: "noise sigmas, held-out part",
        signals,
    }
}

/// Innovations for show: NaN where nothing is measured.
pub(crate) fn shown(record: &Record, rows: &[[f64; CHANNELS]]) -> Vec<[f64; CHANNELS]> {
    rows.iter()
        .zip(&record.measured)
        .map(|(row, measured)| {
            std::array::from_fn(|c| if measured[c].is_finite() { row[c] } else { f64::NAN })
        })
        .collect()
}

/// Noise that is at most twice what is expected.
pub(crate) fn believable(noise: &Noise, expected: &Noise) -> Noise {
    Noise {
        drive: noise.drive.min(2.0 * expected.drive),
        torque: noise.torque.min(2.0 * expected.torque),
        output: noise.output.min(2.0 * expected.output),
        ..*noise
    }
}

/// What a fit makes of every sample at a noise: at the first of two `steps`, or at the finer ones where a moment
/// that no fit has seen makes the filter diverge; and at which.
///
/// # Errors
/// The model cannot be built.
pub(crate) fn run_everywhere<'r>(
    steps: [&'r Record; 2],
    fit: &Fit,
    noise: &Noise,
) -> Result<(&'r Record, Rows), BuildError> {
    let run = |record: &Record| {
        let every = vec![1.0; record.len()];
        let design = Problem::new(record, &every).design(&fit.model, noise)?;
        Ok::<Rows, BuildError>(design.innovations)
    };
    let [coarse, fine] = steps;
    let rows = run(coarse)?;
    match rows.iter().flatten().all(|error| error.is_finite()) {
        true => Ok((coarse, rows)),
        false => Ok((fine, run(fine)?)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::actuator;
    use crate::discover::state::stage::Stage;
    use crate::discover::trial;
    use crate::estimate::noise;
    use crate::synthetic::{Experiment, record};

    #[test]
    fn a_joint_too_stiff_for_the_step_diverges_and_not_at_finer_steps() {
        let truth = actuator();
        let experiment = Experiment { sample_time_s: 4e-3, ..Experiment::clean(6.0) };
        let log = record(&truth, &experiment, 3).unwrap();
        let [coarse, fine] = [1, 64].map(|steps| Record::new(&log, Some(steps)));
        let mask = vec![1.0; fine.len()];
        let problem = Problem::new(&fine, &mask);
        let expected = noise::expected(&truth, &fine);
        let Stage { fit, .. } = trial::fitted(&problem, &truth, &[]);
        let mut stiff = fit.clone();
        stiff.model.stages[0].stiffness_nm_per_rad *= 1e3;
        let at = |fit: &Fit, first| run_everywhere([first, &fine], fit, &expected).unwrap();
        for (fit, first, taken) in [(&fit, &fine, &fine), (&stiff, &coarse, &fine)] {
            let (record, rows) = at(fit, first);
            assert!(std::ptr::eq(record, taken));
            assert!(rows.iter().flatten().all(|error| error.is_finite()));
        }
    }
}
