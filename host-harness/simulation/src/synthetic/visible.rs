//! Whether an effect leaves a gap at all.
//!
//! An effect that changes nothing a sensor shows cannot be found, and to call such a joint adequate
//! is a fair answer. So the run is begun again without the effect, at stretches of it from the true
//! state, under the same voltage and the same disturbances, and once more with it but without the
//! disturbances. The RMS difference of the signals over the stretches, over that of what sensors
//! and disturbances do to them in the same time, is the effect's ratio of signal to noise; of the
//! signals the largest counts. It is per sample, and before any parameter is fitted anew, so an
//! upper bound of what is left then. Stretches are short (50 ms), because in open loop everything
//! drifts away from everything in time.

use std::f64::consts::TAU;
use std::ops::Range;

use joint_core::effect::input_delay::delay_s;

use super::setting::{METHOD, Setting, equations};
use crate::acting::pieces;
use crate::encoders;
use crate::layout::remembers;
use crate::model::Model;
use crate::plant::Snapshot;
use crate::reference::{Disturbance, Equations, ReferenceError, Stepper};

/// Length of a stretch, s, its samples at least and at most, and how many there are.
const STRETCH_S: f64 = 0.05;
const SAMPLES: [usize; 2] = [20, 400];
const STRETCHES: usize = 20;
/// First samples of a stretch that are left out: a late encoder still shows what was before.
const LEFT_OUT: usize = 8;

/// A run with everything that drove it.
pub(super) struct Run {
    /// Instants, s.
    pub time_s: Vec<f64>,
    /// Voltage from each of them on, V.
    pub voltage_v: Vec<f64>,
    /// What the current's sensor took for each, at that instant or as late as its report is, A.
    pub taken_a: Vec<f64>,
    /// What else acted.
    pub disturbance: Disturbance,
    /// The joint at each.
    pub snapshots: Vec<Snapshot>,
    /// The state at the stretches' first samples.
    pub starts: Vec<(usize, Vec<f64>)>,
}

/// The stretches of `count` samples behind a rest.
pub(super) fn windows(count: usize, sample_s: f64, rest: usize) -> Vec<Range<usize>> {
    let length = ((STRETCH_S / sample_s) as usize).clamp(SAMPLES[0], SAMPLES[1]).min(count - 1);
    let many = STRETCHES.min(count / length).max(1);
    let last = count - length;
    (0..many)
        .map(|place| rest + if many > 1 { place * last / (many - 1) } else { 0 })
        .map(|start| start..start + length)
        .collect()
}

/// The ratio of every effect of the model.
pub(super) fn signal_to_noise(
    model: &Model,
    setting: &Setting,
    run: &Run,
    rest: usize,
) -> Result<Vec<f64>, ReferenceError> {
    if model.effects.is_empty() {
        return Ok(Vec::new());
    }
    let windows = windows(run.snapshots.len() - rest, setting.sample_time_s, rest);
    let calm = Disturbance::default();
    let noise = difference(model, None, setting, run, &windows, &calm)?;
    let sensor = &model.sensor;
    let rounding = |counts: f64| if counts > 0.0 { TAU / counts / 12.0_f64.sqrt() } else { 0.0 };
    let own = [
        sensor.current_noise_a,
        rounding(sensor.motor_encoder_counts_per_rev),
        rounding(sensor.output_encoder_counts_per_rev),
    ];
    let seen = [true, true, sensor.output_encoder_counts_per_rev > 0.0];
    (0..model.effects.len())
        .map(|removed| {
            let signal =
                difference(model, Some(removed), setting, run, &windows, &run.disturbance)?;
            let ratios = (0..3).filter(|k| seen[*k]).map(|k| signal[k] / noise[k].hypot(own[k]));
            Ok(ratios.fold(0.0, f64::max))
        })
        .collect()
}

/// RMS difference of current, motor and output angle between the run and one of the same stretches
/// without an effect and under other disturbances.
fn difference(
    model: &Model,
    removed: Option<usize>,
    setting: &Setting,
    run: &Run,
    windows: &[Range<usize>],
    disturbance: &Disturbance,
) -> Result<[f64; 3], ReferenceError> {
    let mut other = model.clone();
    let memory = removed.and_then(|place| {
        let remembering = model.effects[..place].iter().filter(|e| remembers(e.kind)).count();
        remembers(other.effects.remove(place).kind).then_some(remembering)
    });
    let equations = equations(&other, setting)?;
    let mut stepper = Stepper::new(&equations, METHOD);
    let (mut sums, mut count) = ([0.0; 3], 0.0_f64);
    for window in windows {
        let Some((_, start)) = run.starts.iter().find(|(k, _)| *k == window.start) else {
            continue;
        };
        let mut state = start.clone();
        if let Some(slot) = memory {
            state.remove(equations.layout().memory(slot));
        }
        let delay = delay_s(&other.effects).max(0.0);
        let stepped = (&equations, &mut stepper, delay);
        let again = again(stepped, state, run, window, disturbance);
        let time_s = &run.time_s[window.clone()];
        let here = encoders::shown(&other, time_s, &again);
        let true_run = &run.snapshots[window.clone()];
        let there = encoders::shown(model, time_s, true_run);
        for k in LEFT_OUT..window.len() {
            let differences = [
                again[k].measured_current_a - true_run[k].measured_current_a,
                here.motor[k] - there.motor[k],
                here.output[k] - there.output[k],
            ];
            for (sum, difference) in sums.iter_mut().zip(differences) {
                *sum += difference * difference;
            }
            count += 1.0;
        }
    }
    Ok(sums.map(|sum| (sum / count.max(1.0)).sqrt()))
}

fn again(
    (equations, stepper, delay): (&Equations, &mut Stepper<'_>, f64),
    mut state: Vec<f64>,
    run: &Run,
    window: &Range<usize>,
    disturbance: &Disturbance,
) -> Vec<Snapshot> {
    let mut snapshots = vec![equations.snapshot(&state)];
    for k in window.start..window.end - 1 {
        pieces(&run.time_s, k, delay, |source, from, until| {
            let held = disturbance.at(k, run.voltage_v[source], 0.0);
            stepper.advance(&mut state, &held, until - from);
        });
        snapshots.push(equations.snapshot(&state));
    }
    snapshots
}
