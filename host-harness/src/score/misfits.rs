//! In what a drawn joint differs from what any model here can say: its misfits.
//!
//! They stand in a case's truth, so that scores can be taken apart by them. None of them is an
//! effect, and a joint that has nothing else is adequate.

use joint_core::per_unit::Bases;
use serde::{Deserialize, Serialize};

use crate::model::Model;
use crate::synthetic::{Disturbances, Motion, Reported, Sensing, Setting, Stamps};

/// What a case has beside its effects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Misfits {
    /// The joint's family: direct, demo, small or paper.
    pub rig: String,
    /// Family of its friction.
    pub friction: String,
    /// Exponent of its Stribeck curve; 2 in the model.
    pub stribeck_exponent: f64,
    /// What is done to it in the first record.
    pub motion: Motion,
    /// Length of the first record, s.
    pub duration_s: f64,
    /// Its samples.
    pub samples: usize,
    /// What disturbs it.
    pub disturbance: Disturbances,
    /// What its sensors do.
    pub sensing: Sensing,
    /// Largest relative error of the nominal's parameters that a datasheet gives.
    pub parameter_error: f64,
    /// Level of friction in each record over that of the first.
    pub friction_levels: Vec<f64>,
}

impl Misfits {
    /// Of the first record's setting.
    pub fn of(truth: &Model, setting: &Setting, parameter_error: f64, levels: Vec<f64>) -> Self {
        Self {
            rig: truth.name.clone(),
            friction: setting.friction.name().to_owned(),
            stribeck_exponent: setting.stribeck_exponent,
            motion: setting.motion,
            duration_s: setting.duration_s,
            samples: (setting.duration_s / setting.sample_time_s).round() as usize,
            disturbance: setting.disturbance,
            sensing: setting.sensing,
            parameter_error,
            friction_levels: levels,
        }
    }

    /// The classes by which scores are taken apart: what is classed, and its class.
    pub fn classes(&self) -> [(&'static str, String); 6] {
        let friction = match self.friction.as_str() {
            "lugre" if self.stribeck_exponent < 1.6 => "lugre, exponent 0.5 to 1.6",
            "lugre" => "lugre, exponent 1.6 to 2",
            other => other,
        };
        let torque = self.disturbance.torque;
        let colour = match (torque.deviation, torque.correlation_s) {
            (size, _) if size < 0.01 => "below 1 % of breakaway",
            (_, time) if time < 0.02 => "1 to 5 %, below 20 ms",
            _ => "1 to 5 %, 20 ms and more",
        };
        let mut timing = Vec::new();
        match self.sensing.current {
            Reported::AtOnce => {}
            Reported::Late(_) => timing.push("late current"),
            Reported::Filtered(constant) if constant < 2e-3 => {
                timing.push("current filtered < 2 ms")
            }
            Reported::Filtered(_) => timing.push("current filtered >= 2 ms"),
        }
        match (self.sensing.jitter > 0.0, self.sensing.stamps) {
            (false, _) => {}
            (true, Stamps::Exact) => timing.push("jitter, stamped"),
            (true, Stamps::Even) => timing.push("jitter, unstamped"),
            (true, Stamps::RowBefore) => timing.push("stamps of the row before"),
        }
        let timing = if timing.is_empty() { "exact".to_owned() } else { timing.join(" + ") };
        let length = match self.duration_s {
            time if time < 3.0 => "below 3 s",
            time if time < 8.0 => "3 to 8 s",
            _ => "8 s and more",
        };
        [
            ("rig", self.rig.clone()),
            ("friction", friction.to_owned()),
            ("colour", colour.to_owned()),
            ("timing", timing),
            ("motion", self.motion.name().to_owned()),
            ("length", length.to_owned()),
        ]
    }
}

/// A joint whose level of friction is another one: of every mass, by this factor.
pub fn rubbing_otherwise(model: &Model, factor: f64) -> Model {
    let mut model = model.clone();
    let frictions = model.stages.iter_mut().map(|stage| &mut stage.friction);
    for friction in std::iter::once(&mut model.motor.friction).chain(frictions) {
        friction.coulomb_nm *= factor;
        friction.stribeck_nm *= factor;
    }
    model
}

/// Torque at the output that breaks the joint away, Nm.
pub fn breakaway_at_output_nm(model: &Model) -> f64 {
    let bases = Bases::si(&model.motor, &model.stages);
    let behind = model
        .stages
        .iter()
        .enumerate()
        .map(|(k, stage)| stage.friction.breakaway_nm() * bases.shaft(k + 1).abs());
    let motor = model.motor.friction.breakaway_nm() + behind.sum::<f64>();
    motor / bases.shaft(model.stages.len()).abs()
}
