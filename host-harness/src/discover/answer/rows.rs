//! Tables of an answer: parameters and noises before and after.

use joint_core::joint::Drive;
use nalgebra::DMatrix;

use super::findings::{NoiseRow, ParameterRow};
use crate::discover::state::search::Search;
use crate::estimate::coordinates::Coordinate;
use crate::estimate::fit::Fit;
use crate::estimate::record::{Channel, Record};
use crate::model::Model;

/// Every parameter of the nominal, the refitted and the improved model.
pub(crate) fn parameter_rows(
    nominal: &Model,
    before: &Fit,
    after: &Fit,
    covariance: &DMatrix<f64>,
) -> Vec<ParameterRow> {
    after
        .coordinates
        .iter()
        .enumerate()
        .filter_map(|(k, coordinate)| match coordinate {
            Coordinate::Parameter(quantity) => {
                let models = [nominal, &before.model, &after.model];
                Some(ParameterRow::new(models, *quantity, covariance[(k, k)].sqrt()))
            }
            _ => None,
        })
        .collect()
}

/// Every noise: what is expected, and what the refitted and the improved model need.
pub(crate) fn noise_rows(found: &Search, record: &Record) -> Vec<NoiseRow> {
    let (before, after) = (&found.before.fit.noise, &found.after.fit.noise);
    let mut rows = vec![NoiseRow {
        name: "rotor torque",
        unit: "Nm",
        expected: found.expected.torque,
        before: before.torque,
        after: after.torque,
    }];
    if found.expected.output > 0.0 {
        rows.push(NoiseRow {
            name: "output torque at the motor",
            unit: "Nm",
            expected: found.expected.output,
            before: before.output,
            after: after.output,
        });
    }
    if record.drive == Drive::Voltage {
        rows.push(NoiseRow {
            name: "voltage",
            unit: "V",
            expected: found.expected.drive,
            before: before.drive,
            after: after.drive,
        });
    }
    for channel in Channel::ALL.into_iter().filter(|channel| record.has(*channel)) {
        let c = channel as usize;
        rows.push(NoiseRow {
            name: channel.column(),
            unit: if channel == Channel::Current { "A" } else { "rad" },
            expected: found.expected.sensors[c],
            before: before.sensors[c],
            after: after.sensors[c],
        });
    }
    rows
}
