//! One free run.

use std::ops::Range;

use joint_core::effect::Memory;
use joint_core::joint::Drive;

use crate::encoders;
use crate::grid::Grid;
use crate::inputs::Missing;
use crate::layout::Layout;
use crate::log::Log;
use crate::model::Model;
use crate::plant::{BuildError, Inputs, Plant, Snapshot, StageSnapshot, output_shaft, plant};

/// What the sensors show of a run at one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shown {
    pub(super) motor_rad: f64,
    /// The motor's, where there is no gear.
    pub(super) output_rad: f64,
    pub(super) current_a: f64,
}

/// A model over a log's inputs.
pub(super) struct Runner<'a> {
    model: &'a Model,
    /// The log's own times, s.
    time_s: Vec<f64>,
    /// What acts, and by instant of that the sample of the log.
    inputs: Inputs,
    samples: Vec<usize>,
    missing: Missing,
    driven: Box<dyn Plant>,
    /// The joint while its drive lets go: no current.
    open: Box<dyn Plant>,
    layout: Layout,
    shaft: f64,
}

impl<'a> Runner<'a> {
    pub(super) fn new(model: &'a Model, log: &Log) -> Result<Self, BuildError> {
        let (inputs, missing) = Inputs::swinging(log);
        let (inputs, samples) = inputs.acting(model).unwrap_or((inputs, (0..log.len()).collect()));
        let grid = Grid::new(&inputs.time_s, None);
        Ok(Self {
            driven: plant(model, &grid, inputs.drive)?,
            open: plant(model, &grid, Drive::Current)?,
            layout: Layout::of(model),
            shaft: output_shaft(model),
            time_s: log.time_s.clone(),
            model,
            inputs,
            samples,
            missing,
        })
    }

    pub(super) fn missing(&self) -> &Missing {
        &self.missing
    }

    /// The run from a state over a range of samples.
    pub(super) fn run(&self, start: &[f64], range: Range<usize>) -> Vec<Shown> {
        let mut state = start.to_vec();
        let mut states = Vec::with_capacity(range.len());
        let instant = |sample: usize| self.samples.partition_point(|own| *own < sample);
        for k in instant(range.start)..instant(range.end) {
            let given = self.inputs.drive_values[k];
            let free = given.is_nan();
            if free {
                state[Layout::CURRENT] = 0.0;
            } else if self.inputs.drive == Drive::Current {
                state[Layout::CURRENT] = given;
            }
            if states.len() == self.samples[k] - range.start {
                states.push(state.clone());
            }
            let (plant, drive) = if free { (&self.open, 0.0) } else { (&self.driven, given) };
            plant.propagate(k, &mut state, drive, self.inputs.load_nm[k]);
        }
        self.shown(&states, range)
    }

    /// The same for a joint that goes on at its speed.
    pub(super) fn coasting(&self, start: &[f64], range: Range<usize>) -> Vec<Shown> {
        let begin = self.time_s[range.start];
        let speed = start[self.layout.speed(0)];
        let states: Vec<Vec<f64>> = range
            .clone()
            .map(|k| {
                let mut state = start.to_vec();
                state[Layout::ANGLE] += speed * (self.time_s[k] - begin);
                state
            })
            .collect();
        self.shown(&states, range)
    }

    /// What the encoders and the current sensor show of states, late ones included.
    fn shown(&self, states: &[Vec<f64>], range: Range<usize>) -> Vec<Shown> {
        let snapshots: Vec<Snapshot> = states.iter().map(|state| self.snapshot(state)).collect();
        let time_s = &self.time_s[range];
        let angles = encoders::shown(self.model, time_s, &snapshots);
        let current = |state: &Vec<f64>| {
            self.driven.measured_current(state[Layout::CURRENT], &self.memory(state))
        };
        let currents: Vec<f64> = states.iter().map(current).collect();
        let currents = match self.inputs.drive {
            Drive::Voltage => encoders::late_current(self.model, &currents, time_s),
            Drive::Current => currents,
        };
        let each = angles.motor.into_iter().zip(angles.output).zip(currents);
        each.map(|((motor_rad, output_rad), current_a)| Shown { motor_rad, output_rad, current_a })
            .collect()
    }

    /// What the effects remember in a state.
    fn memory(&self, state: &[f64]) -> Memory<f64> {
        std::array::from_fn(|slot| state.get(self.layout.memory(slot)).copied().unwrap_or(0.0))
    }

    /// Of a state what encoders see of it.
    fn snapshot(&self, state: &[f64]) -> Snapshot {
        let motor_angle_rad = state[Layout::ANGLE];
        let stages = self.layout.stages;
        let wound: f64 = (0..stages).map(|stage| state[self.layout.deflection(stage)]).sum();
        let angle_rad = (motor_angle_rad - wound) * self.shaft;
        let last = StageSnapshot { angle_rad, ..StageSnapshot::default() };
        Snapshot { motor_angle_rad, stages: vec![last; stages.min(1)], ..Snapshot::default() }
    }
}
