//! From logs to an answer: the whole workflow on one page.
//!
//! The search runs on seven tenths of the record, in blocks; the rest is kept to measure the gap,
//! so that neither a parameter nor a name was chosen on it. Whether what is left is noise then decides whether what was
//! found is all there is.

mod conclusion;
mod confidence;
mod decision;
pub mod experiment;
mod explained;
pub mod findings;
mod force_error;
mod gap;
mod located;
mod named;
mod next_experiment;
mod possible;
mod reasons;
mod rows;
mod searched;
mod split;
mod undecided;
mod whereabouts;

use std::time::Instant;

use indicatif::ProgressBar;
use joint_core::effect::Kind;

use self::conclusion::Conclusion;
use self::explained::Explained;
use self::findings::Findings;
use self::located::Located;
use self::searched::Searched;
use self::split::Split;
use self::undecided::undecided;
use super::checks::alike::ask_alike;
use super::error::DiscoverError;
use super::evidence::excitation::cannot_tell;
use crate::estimate::fit::Problem;
use crate::estimate::record::Record;
use crate::interrupt;
use crate::log::Log;
use crate::model::Model;
use crate::preflight::{self, LEAST_SAMPLES};

/// Samples that are looked at; longer logs are thinned to stretches.
const MOST_SAMPLES: usize = 60_000;

/// Finds what a model misses in logs of its joint.
///
/// # Errors
/// The model cannot be built, or the logs do not fit together or are too short.
pub fn discover(
    nominal: &Model,
    logs: &[Log],
    bar: &ProgressBar,
) -> Result<Findings, DiscoverError> {
    discover_beside(nominal, (logs, &[]), &[], bar)
}

/// The same with other records of the joint, to which nothing is fitted: an effect that they speak against
/// is only possible; and without kinds that are `withdrawn`, as if they were not on the list.
///
/// # Errors
/// As [`discover`]; or another record is driven by another quantity.
pub fn discover_beside(
    nominal: &Model,
    (logs, others): (&[Log], &[Log]),
    withdrawn: &[Kind],
    bar: &ProgressBar,
) -> Result<Findings, DiscoverError> {
    let began = Instant::now();
    let whole = Record::join(logs, None)?;
    let samples = whole.len();
    if samples < LEAST_SAMPLES {
        return Err(DiscoverError::Short(samples));
    }
    let coarse = whole.thinned(MOST_SAMPLES);
    let lacking = cannot_tell(&coarse);
    if !lacking.is_empty() {
        return Ok(undecided(nominal, &coarse, lacking, began));
    }
    let split = Split::of(&coarse);
    let measured = preflight::measured(nominal, logs);
    let known = (withdrawn, &measured[..]);

    // Steps 1 to 4: the nominal refitted, hypotheses scored, the best refitted in full.
    let searched = Searched::of(&coarse, &split.fitted, nominal, known, bar)?;
    let Searched { record, micro_steps, late, mut explained } = searched;
    let given = nominal;
    let nominal = late.as_ref().unwrap_or(nominal);
    // Step 5: every effect asked on samples that no fit has seen, and what stays again at finer steps.
    let others = (others, MOST_SAMPLES);
    let mut unseen = explained.confirm((&record, micro_steps), &split, others)?;
    let stepped = explained.step(record, micro_steps, &split)?;
    if stepped.micro_steps != micro_steps {
        unseen = explained.confirm((&stepped.record, stepped.micro_steps), &split, others)?;
    }
    if !interrupt::asked() {
        let problems =
            [&stepped.record, &stepped.finest].map(|own| Problem::new(own, &split.fitted));
        ask_alike(problems.each_ref(), &mut explained.found);
    }
    // Steps 6 to 8, and 11: whether the rest is noise, the gap, where it is, and what to measure next.
    bar.set_message("locating what is left, and what to measure next");
    let Explained { shape, found, left } = &explained;
    let nominal = shape.as_ref().unwrap_or(nominal);
    let located = Located::of((&stepped, &split), found, nominal, micro_steps)?;
    // Steps 9 and 10: what was found in proportion, and the answer.
    let conclusion = Conclusion { given, nominal, found, stepped: &stepped, split: &split, bar };
    conclusion.findings(located, left.clone(), &unseen, (logs, samples), began)
}
