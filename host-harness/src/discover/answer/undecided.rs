//! The fourth answer: logs that cannot tell.

use std::time::Instant;

use super::findings::{Angles, Answer, Disturbance, Findings, Gap, Shape, Verdict, Whereabouts};
use super::next_experiment::advice;
use crate::discover::checks::goodness_of_fit::Remainder;
use crate::discover::evidence::FreeRun;
use crate::estimate::record::{CHANNELS, Record};
use crate::model::Model;

/// The findings where `lacking` says what the logs lack: the nominal as it was given, and no figure.
pub(crate) fn undecided(
    nominal: &Model,
    record: &Record,
    lacking: Vec<String>,
    began: Instant,
) -> Findings {
    let silent = vec![[f64::NAN; CHANNELS]; record.len()];
    let next_experiment = advice(Answer::Undecided, &[], None, false, None, "");
    let gap = Gap {
        before: 0.0,
        after: 0.0,
        floor: 0.0,
        unit: "noise sigmas, held-out part",
        signals: Default::default(),
    };
    Findings {
        verdict: Verdict {
            verdict: Answer::Undecided,
            effects: Vec::new(),
            possible: Vec::new(),
            unnamed: Vec::new(),
            whereabouts: Whereabouts { equation: "none".into(), ..Whereabouts::default() },
            gap,
            budget: None,
            free_run: FreeRun::default(),
            next_experiment,
            seconds: began.elapsed().as_secs_f64(),
            reasons: lacking,
        },
        nominal: nominal.clone(),
        refitted: nominal.clone(),
        improved: nominal.clone(),
        time_s: record.time_s.clone(),
        held_out: vec![false; record.len()],
        before: silent.clone(),
        after: silent,
        disturbance: Disturbance {
            before: vec![0.0; record.len()],
            after: vec![0.0; record.len()],
            ..Disturbance::default()
        },
        shape: Shape::default(),
        courses: Vec::new(),
        angles: Angles::default(),
        orders: Vec::new(),
        parameters: Vec::new(),
        scores: Vec::new(),
        noises: Vec::new(),
        left: Remainder::default(),
        experiment: None,
    }
}
