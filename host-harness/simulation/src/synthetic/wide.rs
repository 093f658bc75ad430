//! Logs of joints as they are measured: any motion, friction of any family, coloured disturbances,
//! sensors that are late.
//!
//! The run is stepped sample by sample, because a controller chooses the next voltage by what the
//! encoder has shown (its counts; a late or eccentric encoder misleads the log alone). What an effect changes in it is found by starting again without it.

use std::f64::consts::TAU;

use joint_core::effect::Kind;
use joint_core::effect::input_delay::delay_s;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::motion::Driver;
use super::sensing::{bus_reading, instants};
use super::setting::{METHOD, Setting, equations};
use super::visible::{self, Run};
use super::{amplitude_v, breakaway_nm, normal, rounded};
use crate::acting::pieces;
use crate::encoders;
use crate::log::Log;
use crate::model::Model;
use crate::reference::{Disturbance, ReferenceError, Stepper};

/// The joint rests before its log begins, s: from and to.
const REST_S: [f64; 2] = [0.05, 0.15];
/// Smallest share of a sample that is stepped on its own.
const LEAST: f64 = 1e-6;

/// A log, and what in it a fair answer can go by.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    /// What was measured.
    pub log: Log,
    /// By effect of the model: RMS of what its removal changes in the signals over that of their
    /// noise ([`visible`]).
    pub signal_to_noise: Vec<f64>,
}

/// Runs the joint in this setting and writes down what its log says.
///
/// # Errors
/// The model or the setting makes no sense to the reference, or the run diverges.
pub fn record_wide(
    model: &Model,
    setting: &Setting,
    seed: u64,
) -> Result<Recorded, ReferenceError> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let sample = setting.sample_time_s;
    let rest_s = random.random_range(REST_S[0]..REST_S[1]);
    let (count, rest) = ((setting.duration_s / sample).round(), (rest_s / sample).round());
    if !(count >= 2.0 && rest >= 1.0 && count + rest < 1e9) {
        return Err(ReferenceError::Inputs("the setting has no length, or none that fits"));
    }
    let (count, rest) = (count as usize, rest as usize);
    let driver = setting.motion.driver(model, count, sample, &mut random);
    let reference = match &driver {
        Driver::Closed(controller) => Some(controller.reference_rad.clone()),
        Driver::Open(_) => None,
    };
    let own = instants(count, sample, setting.sensing.jitter, &mut random);
    let begin = rest as f64 * sample;
    let mut time_s: Vec<f64> = (0..rest).map(|k| k as f64 * sample).collect();
    time_s.extend(own.iter().map(|time| begin + time));

    let disturbance = disturbance(model, setting, &time_s, &mut random);
    let run = run(model, setting, driver, rest, time_s, disturbance)?;
    let voltage = run.voltage_v[rest..].to_vec();
    let snapshots = &run.snapshots[rest..];

    let sensor = &model.sensor;
    let flowing: Vec<f64> = run.snapshots.iter().map(|s| s.measured_current_a).collect();
    let reported = setting.sensing.current.of(&run.taken_a, &run.time_s);
    let noise = sensor.current_noise_a;
    let current = reported[rest..].iter();
    let current: Vec<f64> =
        current.map(|i| rounded(i + noise * normal(&mut random), 0.5 * noise)).collect();
    let shown = encoders::shown(model, &own, snapshots);
    let zeroed = |counts: f64, angles: &[f64]| -> Vec<f64> {
        angles.iter().map(|angle| counted(angle - angles[0], counts)).collect()
    };
    let counts = sensor.output_encoder_counts_per_rev;
    let bus = setting.sensing.bus_ripple.map(|ripple| {
        let supply = supply(model);
        let pairs = voltage.iter().zip(&flowing[rest..]);
        pairs
            .map(|(u, i)| bus_reading([supply[0], supply[1], ripple], *u, *i, &mut random))
            .map(|reading| rounded(reading, 1e-3 * supply[0]))
            .collect()
    });
    let log = Log {
        time_s: setting.sensing.stamps.of(&own, sample),
        voltage_v: Some(voltage),
        current_a: Some(current),
        motor_angle_rad: zeroed(sensor.motor_encoder_counts_per_rev, &shown.motor),
        output_angle_rad: (counts > 0.0 && !model.stages.is_empty())
            .then(|| zeroed(counts, &shown.output)),
        bus_v: bus,
        reference_angle_rad: reference,
        ..Log::default()
    };
    let signal_to_noise = visible::signal_to_noise(model, setting, &run, rest)?;
    Ok(Recorded { log, signal_to_noise })
}

/// Voltage and source resistance of the joint's supply: those of its sag, or a stiff one.
fn supply(model: &Model) -> [f64; 2] {
    let sag = model.effects.iter().find(|effect| effect.kind == Kind::SupplySag);
    match sag {
        Some(sag) => ["bus_voltage_v", "source_resistance_ohm"].map(|key| {
            let keys = sag.kind.spec().parameters.iter().position(|spec| spec.key == key);
            keys.map_or(0.0, |place| sag.values[place])
        }),
        None => [1.6 * amplitude_v(model), 0.0],
    }
}

fn counted(angle: f64, counts: f64) -> f64 {
    rounded(angle, if counts > 0.0 { TAU / counts } else { 0.0 })
}

fn disturbance(
    model: &Model,
    setting: &Setting,
    time_s: &[f64],
    random: &mut ChaCha8Rng,
) -> Disturbance {
    let own = &setting.disturbance;
    let (breakaway, volts) = (breakaway_nm(model), own.voltage * amplitude_v(model));
    let torque_nm = own.torque.at(time_s, random);
    let friction_change = own.friction.at(time_s, random);
    let white = |value: f64, random: &mut ChaCha8Rng| value + own.white_torque * normal(random);
    Disturbance {
        torque_nm: torque_nm.into_iter().map(|own| breakaway * white(own, random)).collect(),
        drive: time_s.iter().map(|_| volts * normal(random)).collect(),
        // Friction keeps its sign.
        friction_change: friction_change.into_iter().map(|change| change.max(-0.9)).collect(),
    }
}

fn run(
    model: &Model,
    setting: &Setting,
    mut driver: Driver,
    rest: usize,
    time_s: Vec<f64>,
    disturbance: Disturbance,
) -> Result<Run, ReferenceError> {
    let equations = equations(model, setting)?;
    // What acts late was chosen before.
    let delay = delay_s(&model.effects).max(0.0);
    let mut stepper = Stepper::new(&equations, METHOD);
    let mut state = equations.rest();
    let counts = model.sensor.motor_encoder_counts_per_rev;
    let late_s = setting.sensing.current.late_s(setting.sample_time_s);
    let least_s = LEAST * setting.sample_time_s;
    let mut taken_a = Vec::new();
    let mut run = Run {
        voltage_v: Vec::with_capacity(time_s.len()),
        taken_a: Vec::new(),
        snapshots: Vec::with_capacity(time_s.len()),
        starts: Vec::new(),
        disturbance,
        time_s,
    };
    let windows = visible::windows(run.time_s.len() - rest, setting.sample_time_s, rest);
    let mut zero = 0.0;
    for k in 0..run.time_s.len() {
        let snapshot = equations.snapshot(&state);
        if k == rest {
            zero = snapshot.motor_angle_rad;
        }
        let voltage = match (&mut driver, k.checked_sub(rest)) {
            (_, None) => 0.0,
            (Driver::Open(voltage), Some(own)) => voltage.get(own).copied().unwrap_or(0.0),
            (Driver::Closed(controller), Some(own)) => {
                let angle = counted(snapshot.motor_angle_rad - zero, counts);
                controller.voltage(own, angle, run.time_s[k] - run.time_s[k - 1])
            }
        };
        run.snapshots.push(snapshot);
        run.voltage_v.push(voltage);
        if windows.iter().any(|window| window.start == k) {
            run.starts.push((k, state.clone()));
        }
        if let Some(next) = run.time_s.get(k + 1) {
            pieces(&run.time_s, k, delay, |source, from, until| {
                let held = run.disturbance.at(k, run.voltage_v[source], 0.0);
                let mut reached = from;
                let taken = |row: &f64| row - late_s < until - least_s;
                while late_s > 0.0 && run.time_s.get(taken_a.len()).is_some_and(taken) {
                    // What was before the log is as its first state.
                    let ahead = run.time_s[taken_a.len()] - late_s - reached;
                    if ahead > least_s {
                        stepper.advance(&mut state, &held, ahead);
                        reached += ahead;
                    }
                    taken_a.push(equations.snapshot(&state).measured_current_a);
                }
                stepper.advance(&mut state, &held, until - reached);
            });
            if state.iter().any(|value| !value.is_finite()) {
                return Err(ReferenceError::Diverged(*next));
            }
        }
    }
    if late_s > 0.0 {
        taken_a.resize(run.time_s.len(), equations.snapshot(&state).measured_current_a);
        run.taken_a = taken_a;
    } else {
        run.taken_a = run.snapshots.iter().map(|s| s.measured_current_a).collect();
    }
    Ok(run)
}
