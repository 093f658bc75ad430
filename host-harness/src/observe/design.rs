//! From a model to the constants of its observer.

use joint_core::joint::Drive;
use joint_core::observer::{CHANNELS, Column, Design, Level, Regime, SETS, Spread, StageRow};
use nalgebra::DMatrix;

use super::linear::{Linear, Order, decelerations, linearise};
use super::noise::{drive_noise, sensors};
use super::rating::{Rating, breakaway_nm};
use super::riccati::{Median, Uncertain, medians};
use super::twin::{Felt, Motion, Style};
use crate::model::Model;
use crate::plant::{BuildError, Layout, inertias};

/// Samples of the motion that gains are designed along.
const SAMPLES: usize = 6000;

/// What is free in a design, all as shares of ratings and of friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning {
    /// Load's walk as a share of the rated load per root second: steady, transient, varying.
    pub load: [f64; 3],
    /// Load's slope as a share of the rated load per second, the same.
    pub slope: [f64; 3],
    /// Time constant of the slope, s, the same.
    pub leak_s: [f64; 3],
    /// Walk of the missing drive as a share of the rated one per root second.
    pub bias: f64,
    /// Walk of the resistance as a share of it per root second.
    pub ohm: f64,
    /// Walk of the flux as a share of it per root second.
    pub flux: f64,
    /// Walk of friction's level as a share of it per root second, without and with an output encoder.
    pub level: [f64; 2],
    /// Time constant of friction's running mean, s, without and with an output encoder.
    pub mean_deceleration_s: [f64; 2],
    /// Standard deviations of an innovation that count for friction's level.
    pub friction_projection: f64,
    /// Standard deviations that a current may be off before another voltage is taken to be put out.
    pub outlier: f64,
    /// Noise on the drive as a share of the rated one.
    pub drive: f64,
    /// Noise on the rotor as a share of the breakaway torque.
    pub torque: f64,
    /// Walk of every bristle, share of its Coulomb level per root second.
    pub bristle: f64,
    /// Time constant of the projection's mean, s.
    pub smoothing_s: f64,
    /// Alarm, in standard deviations of that mean.
    pub alarm: f64,
    /// How long an alarm holds, s.
    pub hold_s: f64,
    /// Time constant of the share of alarms, s.
    pub alarm_rate_s: f64,
    /// Share of alarms from which on a load is varying.
    pub alarm_rate: f64,
    /// How long a load is varying after that, s.
    pub varying_s: f64,
}

impl Default for Tuning {
    fn default() -> Self {
        Self {
            load: [0.075, 4.7, 0.06],
            slope: [25.0, 32.0, 520.0],
            leak_s: [0.1, 0.035, 0.02],
            bias: 0.001,
            ohm: 0.04,
            flux: 0.002,
            level: [0.002, 0.02],
            mean_deceleration_s: [0.0015, 0.2],
            friction_projection: 1.0,
            outlier: 8.0,
            drive: 1e-3,
            torque: 0.012,
            bristle: 4.0,
            smoothing_s: 0.001,
            alarm: 2.8,
            hold_s: 0.001,
            alarm_rate_s: 0.012,
            alarm_rate: 0.22,
            varying_s: 0.087,
        }
    }
}

/// Designs an observer's constants.
///
/// # Errors
/// The model cannot be built.
pub fn design<const N: usize>(
    model: &Model,
    kind: Drive,
    step_s: f64,
    rating: &Rating,
    tuning: &Tuning,
) -> Result<Design<N>, BuildError> {
    let mut design = gains(model, kind, step_s, rating, tuning)?;
    let off = super::judge::Wrong::default();
    (design.spread, design.turning) =
        super::judge::spread(model, kind, step_s, rating, &design, &off)?;
    Ok(design)
}

/// The same without standard deviations, which take the longest.
///
/// # Errors
/// The model cannot be built.
pub fn gains<const N: usize>(
    model: &Model,
    kind: Drive,
    step_s: f64,
    rating: &Rating,
    tuning: &Tuning,
) -> Result<Design<N>, BuildError> {
    let felt = Felt {
        drive: drive_noise(model, kind, rating, tuning.drive),
        torque: tuning.torque * breakaway_nm(model),
    };
    let sigma = sensors(model);
    let motion = Motion {
        truth: model,
        kind,
        step_s,
        rating,
        felt,
        style: Style::Creep,
        samples: SAMPLES,
        seed: 1,
    };
    let motion = motion.run()?;
    let linear = linearise(model, kind, step_s, &motion, &sigma)?;
    Ok(assemble(model, kind, step_s, rating, tuning, &linear))
}

fn assemble<const N: usize>(
    model: &Model,
    kind: Drive,
    step_s: f64,
    rating: &Rating,
    tuning: &Tuning,
    linear: &Linear,
) -> Design<N> {
    let root = step_s.sqrt();
    let mean_deceleration = tuning.mean_deceleration_s.map(|time_s| 1.0 - (-step_s / time_s).exp());
    let all = sensors(model);
    let held = settled(&linear.held, 3);
    let free: Vec<bool> = settled(&linear.held.iter().map(|h| !h).collect::<Vec<_>>(), 3);
    let uncertain = |speed: usize, output: bool| Uncertain {
        drive: drive_noise(model, kind, rating, tuning.drive),
        torque: tuning.torque * breakaway_nm(model),
        sensors: [
            if kind == Drive::Current { f64::INFINITY } else { all[0] },
            all[1],
            if output { all[2] } else { f64::INFINITY },
        ],
        load: tuning.load[speed] * rating.load_nm * root,
        slope: tuning.slope[speed] * rating.load_nm * step_s,
        leak: (-step_s / tuning.leak_s[speed]).exp(),
        bias: tuning.bias * rating.drive * root,
        ohm: tuning.ohm * root,
        flux: tuning.flux * root,
        level: tuning.level[usize::from(output)] * root,
        mean_deceleration: mean_deceleration[usize::from(output)],
        bristle: tuning.bristle * root,
    };
    let mut sets = [[Column::filled(0.0); CHANNELS]; SETS];
    let mut sigma = [1.0; CHANNELS];
    let mut scale = [0.0; 2];
    let mut projection = [[0.0; CHANNELS]; 2];
    let mut levels = [[0.0; CHANNELS]; 2];
    for output in [false, true] {
        if output && !all[2].is_finite() {
            for regime in [Regime::Steady, Regime::Transient, Regime::Varying, Regime::Held] {
                for hardened in [false, true] {
                    sets[regime.row(true, hardened)] = sets[regime.row(false, hardened)];
                }
            }
            projection[1] = projection[0];
            levels[1] = levels[0];
            continue;
        }
        let both = |mask: &[bool], hardened: bool| -> Vec<bool> {
            mask.iter().zip(&linear.hardened).map(|(m, b)| *m && *b == hardened).collect()
        };
        let masks = [
            free.clone(),
            both(&free, false),
            both(&free, true),
            both(&held, false),
            both(&held, true),
        ];
        let slow = medians(linear, &uncertain(0, output), &masks);
        let fast = medians(linear, &uncertain(1, output), &masks);
        let varying = medians(linear, &uncertain(2, output), &masks);
        let Some(steady) = slow[0].clone() else { continue };
        if !output {
            scale = steady.scale;
        }
        if !output || sigma[2] == 1.0 {
            for (own, found) in sigma.iter_mut().zip(steady.sigma) {
                if found > 0.0 {
                    *own = found;
                }
            }
        }
        let or = |a: &Option<Median>, b: &Option<Median>| {
            a.clone().or_else(|| b.clone()).unwrap_or_else(|| steady.clone())
        };
        for hardened in [false, true] {
            let k = usize::from(hardened);
            let still = or(&slow[1 + k], &slow[0]);
            // Where both ends are measured a held rotor hides nothing. What suits an output that is held
            // too, as most of those samples have it, rings with one that slides.
            let held = if output { still.clone() } else { or(&slow[3 + k], &slow[3]) };
            let rows = [
                (Regime::Steady, still),
                (Regime::Transient, or(&fast[1 + k], &fast[0])),
                (Regime::Varying, or(&varying[1 + k], &varying[0])),
                (Regime::Held, held),
            ];
            for (regime, median) in rows {
                sets[regime.row(output, hardened)] = columns(linear.order, &median, &sigma);
            }
        }
        levels[usize::from(output)] = steady.level;
        let projections =
            sets[Regime::Steady.row(output, false)].each_ref().map(|column| column.load);
        let size = projections.iter().map(|v| v * v).sum::<f64>().sqrt().max(1e-300);
        projection[usize::from(output)] = projections.map(|v| v / size);
    }
    let smoothing = 1.0 - (-step_s / tuning.smoothing_s).exp();
    let settled = ((0.02 / step_s) as u16).max(50);
    Design {
        sets,
        ohm: scale[0] * sigma[0],
        flux: scale[1] * sigma[0],
        level: level(model, step_s, tuning, mean_deceleration, &levels, &sigma),
        outlier: tuning.outlier,
        push: model.motor.torque_constant_nm_per_a * step_s / inertias(model)[0],
        confirmed: (0.25 / step_s).min(30_000.0) as u16,
        hardened: super::linear::bend(model),
        sigma,
        gate: 40.0,
        leak: [0, 1, 2, 0].map(|k: usize| (-step_s / tuning.leak_s[k]).exp()),
        projection,
        smoothing,
        alarm: tuning.alarm * (smoothing / (2.0 - smoothing)).sqrt(),
        hold: (tuning.hold_s / step_s).round().max(1.0) as u16,
        alarm_rate: 1.0 - (-step_s / tuning.alarm_rate_s).exp(),
        varying: (tuning.alarm_rate, (tuning.varying_s / step_s).round().max(1.0) as u16),
        settled,
        inconsistent: 12.0,
        most_load_nm: 4.0 * rating.load_nm,
        most_bias: 0.6 * rating.drive,
        most_ohm: 0.5,
        most_flux: 0.1,
        most_current_a: rating.current_a,
        spread: [Spread::filled(0.0); SETS],
        turning: [0.0; 2],
    }
}

fn columns<const N: usize>(
    order: Order,
    median: &Median,
    sigma: &[f64; CHANNELS],
) -> [Column<f64, N>; CHANNELS] {
    let layout = order.plant;
    let gain: &DMatrix<f64> = &median.gain;
    std::array::from_fn(|c| {
        let at = |row: usize| gain[(row, c)] * sigma[c];
        Column {
            current: at(Layout::CURRENT),
            angle: at(Layout::ANGLE),
            speed: at(layout.speed(0)),
            stages: std::array::from_fn(|k| StageRow {
                deflection: at(layout.deflection(k)),
                speed: at(layout.speed(k + 1)),
            }),
            load: at(order.load()),
            slope: at(order.slope()),
            bias: at(order.bias()),
        }
    })
}

fn level<const N: usize>(
    model: &Model,
    step_s: f64,
    tuning: &Tuning,
    smoothing: [f64; 2],
    found: &[[f64; CHANNELS]; 2],
    sigma: &[f64; CHANNELS],
) -> Level<N> {
    let decelerations = decelerations(model, step_s);
    let angles = found.map(|[_, motor, output]| [motor * sigma[1], output * sigma[2]]);
    let size = angles.map(|[motor, output]| motor.hypot(output));
    let unit = |k: usize| angles[k].map(|v| if size[k] > 0.0 { v / size[k] } else { 0.0 });
    Level {
        rotor: decelerations[0],
        stages: std::array::from_fn(|k| decelerations[k + 1]),
        smoothing,
        projection: [unit(0), unit(1)],
        gain: size,
        most_projection: tuning.friction_projection,
        most: 0.3,
    }
}

/// Where something has been so for that many samples.
fn settled(so: &[bool], samples: usize) -> Vec<bool> {
    let mut since = 0;
    so.iter()
        .map(|so| {
            since = if *so { since + 1 } else { 0 };
            since > samples
        })
        .collect()
}
