//! What drives use today, beside which an observer has to show its worth.
//!
//! All of them get the same model and the same samples. Friction is the Stribeck curve at the
//! estimated speed, springs are linear in the filters' gains; each has one or two free numbers, which
//! [`tuned`] finds by search on a motion of the model itself.

use std::f64::consts::TAU;

use joint_core::params::Friction;
use joint_core::per_unit::Bases;
use nalgebra::{DMatrix, DVector};

use super::design::{breakaway_nm, sensors};
use super::rating::Rating;
use super::run::Seen;
use crate::model::Model;
use crate::plant::{inertias, output_shaft};

/// One of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Baseline {
    /// Momentum observer at the motor: what is left of the torque balance, low-passed.
    Disturbance,
    /// Steady-state Kalman filter of the joint as one inertia.
    Rigid,
    /// The same of the chain with its springs.
    Flexible,
    /// Spring torque from the difference of both encoders, less the output's acceleration.
    Spring,
    /// LuGre run open-loop on the measured speed: friction only.
    LuGre,
}

impl Baseline {
    /// All of them.
    pub const ALL: [Baseline; 5] =
        [Self::Disturbance, Self::Rigid, Self::Flexible, Self::Spring, Self::LuGre];

    /// Its name in a table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Disturbance => "disturbance observer",
            Self::Rigid => "Kalman filter, rigid joint",
            Self::Flexible => "Kalman filter, flexible chain",
            Self::Spring => "spring torque, both encoders",
            Self::LuGre => "LuGre, open loop",
        }
    }

    /// Whether it has something to say of such a joint.
    pub fn applies(self, stages: usize, output: bool) -> bool {
        match self {
            Self::Spring => stages > 0 && output,
            Self::Flexible => stages > 0,
            _ => true,
        }
    }

    fn knobs(self) -> Vec<[f64; 2]> {
        let pairs = |first: &[f64], second: &[f64]| {
            first.iter().flat_map(|a| second.iter().map(|b| [*a, *b])).collect()
        };
        match self {
            Self::Disturbance | Self::Spring => {
                pairs(&[20.0, 40.0, 80.0, 160.0, 320.0, 640.0, 1280.0, 2560.0], &[1.0])
            }
            Self::Rigid | Self::Flexible => pairs(&[0.3, 1.0, 3.0, 10.0, 30.0], &[0.01, 0.1, 1.0]),
            Self::LuGre => pairs(&[100.0, 300.0, 1000.0, 3000.0], &[1.0]),
        }
    }
}

/// What a baseline says of one sample; NaN where it says nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guess {
    /// Load at the output, Nm.
    pub load: f64,
    /// Wind-up of the last stage, rad.
    pub windup: f64,
    /// Friction of the joint at the motor, Nm.
    pub friction: f64,
}

const NOTHING: Guess = Guess { load: f64::NAN, windup: f64::NAN, friction: f64::NAN };

/// The knobs with the smallest error on a motion whose loads (for LuGre: frictions) are known.
pub fn tuned(
    baseline: Baseline,
    model: &Model,
    rating: &Rating,
    step_s: f64,
    seen: &[Seen],
    truth: &[Guess],
) -> [f64; 2] {
    let mut best = (f64::INFINITY, [1.0; 2]);
    for knobs in baseline.knobs() {
        let guesses = run(baseline, knobs, model, rating, step_s, seen);
        let squares = guesses.iter().zip(truth).skip(seen.len() / 10);
        let sum: f64 = squares
            .map(|(guess, truth)| match baseline {
                Baseline::LuGre => (guess.friction - truth.friction).powi(2),
                _ => (guess.load - truth.load).powi(2),
            })
            .sum();
        if sum < best.0 {
            best = (sum, knobs);
        }
    }
    best.1
}

/// Runs a baseline over samples that stand one step apart.
pub fn run(
    baseline: Baseline,
    knobs: [f64; 2],
    model: &Model,
    rating: &Rating,
    step_s: f64,
    seen: &[Seen],
) -> Vec<Guess> {
    match baseline {
        Baseline::Disturbance => disturbance(knobs[0], model, step_s, seen),
        Baseline::Spring => spring(knobs[0], model, step_s, seen),
        Baseline::LuGre => lugre(knobs[0], model, step_s, seen),
        Baseline::Rigid => kalman(&Chain::rigid(model), knobs, model, rating, step_s, seen),
        Baseline::Flexible => kalman(&Chain::flexible(model), knobs, model, rating, step_s, seen),
    }
}

/// Friction of one mass, reflected to the motor.
struct Law<'a> {
    own: &'a Friction,
    shaft: f64,
}

impl Law<'_> {
    /// Stribeck curve, smooth over `width` rad/s of the motor about zero.
    fn at(&self, motor_speed: f64, width: f64) -> f64 {
        let speed = motor_speed * self.shaft;
        let bell = match self.own.stribeck_velocity_rad_per_s {
            scale if scale > 0.0 => (-(speed / scale).powi(2)).exp(),
            _ => 0.0,
        };
        let level = self.own.coulomb_nm + self.own.stribeck_nm * bell;
        let sign = (motor_speed / width.max(1e-12)).tanh();
        (level * sign + self.own.sigma2_nm_s_per_rad * speed) * self.shaft
    }

    /// A tenth of the Stribeck velocity, and no less than an explicit step bears.
    fn width(&self, step_s: f64, inertia: f64) -> f64 {
        let narrow = 0.1 * self.own.stribeck_velocity_rad_per_s / self.shaft;
        narrow.max(2.0 * self.own.breakaway_nm() * self.shaft * step_s / inertia)
    }
}

fn laws(model: &Model) -> Vec<Law<'_>> {
    let bases = Bases::si(&model.motor, &model.stages);
    let stages = model.stages.iter().enumerate();
    std::iter::once(Law { own: &model.motor.friction, shaft: 1.0 })
        .chain(
            stages.map(|(k, stage)| Law { own: &stage.friction, shaft: bases.shaft(k + 1).abs() }),
        )
        .collect()
}

/// Linear stiffness of every spring at the motor, and the cubic one of the last.
fn stiffness(model: &Model) -> Vec<(f64, f64)> {
    let bases = Bases::si(&model.motor, &model.stages);
    let stages = model.stages.iter().enumerate();
    stages
        .map(|(k, stage)| {
            let square = bases.shaft(k + 1).powi(2);
            let cubic = stage.cubic_stiffness_nm_per_rad3 * square * square;
            (stage.stiffness_nm_per_rad * square, cubic)
        })
        .collect()
}

/// Holds what is missing.
fn held(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut last = 0.0;
    values
        .map(|value| {
            if value.is_finite() {
                last = value;
            }
            last
        })
        .collect()
}

fn torque(model: &Model, seen: &[Seen]) -> Vec<f64> {
    let current = seen.iter().map(|s| if s.current.is_finite() { s.current } else { f64::NAN });
    held(current).iter().map(|i| i * model.motor.torque_constant_nm_per_a).collect()
}

/// Speed from an angle by a low-passed difference.
fn speeds(angles: &[f64], cutoff: f64, step_s: f64) -> Vec<f64> {
    let share = 1.0 - (-TAU * cutoff * step_s).exp();
    let mut speed = 0.0;
    let mut last = angles.first().copied().unwrap_or(0.0);
    angles
        .iter()
        .map(|angle| {
            speed += share * ((angle - last) / step_s - speed);
            last = *angle;
            speed
        })
        .collect()
}

fn disturbance(cutoff: f64, model: &Model, step_s: f64, seen: &[Seen]) -> Vec<Guess> {
    let laws = laws(model);
    let inertia: f64 = inertias(model).iter().sum();
    let shaft = output_shaft(model);
    let torque = torque(model, seen);
    let speed = speeds(&held(seen.iter().map(|s| s.motor)), 2.0 * cutoff, step_s);
    let pull = (TAU * cutoff).min(0.5 / step_s);
    let stiffness = stiffness(model);
    let (mut sum, mut left) = (inertia * speed.first().copied().unwrap_or(0.0), 0.0);
    torque
        .iter()
        .zip(&speed)
        .map(|(torque, speed)| {
            let friction: f64 =
                laws.iter().map(|law| law.at(*speed, law.width(step_s, inertia))).sum();
            // The residual of the momentum is the torque that acts beside the known ones.
            left = pull * (inertia * speed - sum);
            sum += step_s * (torque - friction + left);
            // The load is positive against positive motion.
            let load = -left / shaft;
            let windup = stiffness.last().map_or(f64::NAN, |k| -left / k.0 * shaft);
            Guess { load, windup, friction }
        })
        .collect()
}

fn spring(cutoff: f64, model: &Model, step_s: f64, seen: &[Seen]) -> Vec<Guess> {
    let (laws, shaft) = (laws(model), output_shaft(model));
    let (Some(last), Some(inertia)) = (laws.last(), inertias(model).last().copied()) else {
        return vec![NOTHING; seen.len()];
    };
    let stiffness = stiffness(model);
    let motor = held(seen.iter().map(|s| s.motor));
    let output = held(seen.iter().map(|s| s.output / shaft));
    let speed = speeds(&output, 2.0 * cutoff, step_s);
    let motor_speed = speeds(&motor, 2.0 * cutoff, step_s);
    let width = last.width(step_s, inertia);
    let pull = (TAU * cutoff).min(0.5 / step_s);
    let mut sum = 0.0;
    (0..seen.len())
        .map(|k| {
            let torque = series(&stiffness, motor[k] - output[k]);
            let left = pull * (inertia * speed[k] - sum);
            sum += step_s * (torque - last.at(speed[k], width) + left);
            let windup = stiffness.last().map_or(f64::NAN, |own| bent(*own, torque)) * shaft;
            let friction = laws.iter().map(|law| law.at(motor_speed[k], width)).sum();
            Guess { load: -left / shaft, windup, friction }
        })
        .collect()
}

/// Deflection of a spring under a torque, by Newton's method.
fn bent((linear, cubic): (f64, f64), torque: f64) -> f64 {
    let mut x = torque / linear;
    for _ in 0..8 {
        x -= (linear * x + cubic * x.powi(3) - torque) / (linear + 3.0 * cubic * x * x);
    }
    x
}

/// Torque through springs in series that are wound up by so much together.
fn series(stiffness: &[(f64, f64)], wound: f64) -> f64 {
    let soft: f64 = stiffness.iter().map(|own| 1.0 / own.0).sum();
    let mut torque = wound / soft;
    for _ in 0..8 {
        let mut left = -wound;
        let mut slope = 0.0;
        for own in stiffness {
            let x = bent(*own, torque);
            left += x;
            slope += 1.0 / (own.0 + 3.0 * own.1 * x * x);
        }
        torque -= left / slope;
    }
    torque
}

fn lugre(cutoff: f64, model: &Model, step_s: f64, seen: &[Seen]) -> Vec<Guess> {
    let laws = laws(model);
    let speed = speeds(&held(seen.iter().map(|s| s.motor)), cutoff, step_s);
    let mut bristles = vec![0.0; laws.len()];
    speed
        .iter()
        .map(|motor| {
            let mut friction = 0.0;
            for (law, z) in laws.iter().zip(&mut bristles) {
                let (own, speed) = (law.own, motor * law.shaft);
                let bell = (-(speed / own.stribeck_velocity_rad_per_s.max(1e-12)).powi(2)).exp();
                let level = (own.coulomb_nm + own.stribeck_nm * bell).max(1e-300);
                // ż = v − σ0 |v| z / g, exact over a step: stable at any speed.
                let rate = own.sigma0_nm_per_rad * speed.abs() / level;
                let steady = level / own.sigma0_nm_per_rad.max(1e-300) * speed.signum();
                let before = *z;
                *z = steady + (*z - steady) * (-rate * step_s).exp();
                let bending = (*z - before) / step_s;
                let torque = own.sigma0_nm_per_rad * *z
                    + own.sigma1_nm_s_per_rad * bending
                    + own.sigma2_nm_s_per_rad * speed;
                friction += torque * law.shaft;
            }
            Guess { friction, ..NOTHING }
        })
        .collect()
}

/// Masses and springs, reflected to the motor.
struct Chain {
    inertia: Vec<f64>,
    springs: Vec<(f64, f64)>,
}

impl Chain {
    fn rigid(model: &Model) -> Self {
        Self { inertia: vec![inertias(model).iter().sum()], springs: Vec::new() }
    }

    fn flexible(model: &Model) -> Self {
        Self { inertia: inertias(model), springs: stiffness(model) }
    }

    /// Rotor angle, deflections, speeds, load torque at the motor.
    fn size(&self) -> usize {
        2 * self.inertia.len() + 1
    }

    fn speed(&self, mass: usize) -> usize {
        self.inertia.len() + mass
    }

    /// Continuous dynamics, then what a torque on each mass does.
    fn continuous(&self) -> (DMatrix<f64>, DMatrix<f64>) {
        let (size, masses) = (self.size(), self.inertia.len());
        let mut a = DMatrix::zeros(size, size);
        let mut b = DMatrix::zeros(size, masses);
        a[(0, self.speed(0))] = 1.0;
        for (k, (stiffness, _)) in self.springs.iter().enumerate() {
            a[(1 + k, self.speed(k))] = 1.0;
            a[(1 + k, self.speed(k + 1))] = -1.0;
            a[(self.speed(k), 1 + k)] -= stiffness / self.inertia[k];
            a[(self.speed(k + 1), 1 + k)] += stiffness / self.inertia[k + 1];
        }
        a[(self.speed(masses - 1), size - 1)] = 1.0 / self.inertia[masses - 1];
        for (mass, inertia) in self.inertia.iter().enumerate() {
            b[(self.speed(mass), mass)] = 1.0 / inertia;
        }
        (a, b)
    }
}

fn kalman(
    chain: &Chain,
    [walk, noise]: [f64; 2],
    model: &Model,
    rating: &Rating,
    step_s: f64,
    seen: &[Seen],
) -> Vec<Guess> {
    let (size, masses) = (chain.size(), chain.inertia.len());
    let (a, b) = chain.continuous();
    let mut whole = DMatrix::zeros(size + masses, size + masses);
    whole.view_mut((0, 0), (size, size)).copy_from(&(a * step_s));
    whole.view_mut((0, size), (size, masses)).copy_from(&(b * step_s));
    let exact = whole.exp();
    let f = exact.view((0, 0), (size, size)).into_owned();
    let g = exact.view((0, size), (size, masses)).into_owned();
    let shaft = output_shaft(model);
    let all = sensors(model);
    // One inertia has no wind-up between the encoders: an output angle would only disturb it.
    let sees = !chain.springs.is_empty() && seen.iter().any(|s| s.output.is_finite());
    let channels = if sees { 2 } else { 1 };
    let mut h = DMatrix::zeros(channels, size);
    h[(0, 0)] = 1.0;
    let mut r = DMatrix::zeros(channels, channels);
    r[(0, 0)] = all[1].powi(2);
    if sees {
        h[(1, 0)] = 1.0;
        (0..chain.springs.len()).for_each(|k| h[(1, 1 + k)] = -1.0);
        r[(1, 1)] = (all[2] / shaft).powi(2);
    }
    let mut q = DMatrix::zeros(size, size);
    q[(size - 1, size - 1)] = (walk * rating.load_nm * shaft).powi(2) * step_s;
    for mass in 0..masses {
        let kick = g.column(mass) * (noise * breakaway_nm(model));
        q += &kick * kick.transpose();
    }
    let mut p = &q * 100.0 + DMatrix::identity(size, size) * 1e-12;
    let mut gain = DMatrix::zeros(size, channels);
    for _ in 0..1500 {
        let ph = &p * h.transpose();
        let Some(inverse) = (&h * &ph + &r).try_inverse() else { break };
        gain = &ph * inverse;
        p -= &gain * ph.transpose();
        p = &f * &p * f.transpose() + &q;
        p = (&p + p.transpose()) * 0.5;
    }
    let laws = laws(model);
    let total: f64 = chain.inertia.iter().sum();
    let torque = torque(model, seen);
    let mut x = DVector::<f64>::zeros(size);
    x[0] = seen.iter().map(|s| s.motor).find(|v| v.is_finite()).unwrap_or(0.0);
    let mut push = DVector::zeros(masses);
    let mut guesses = Vec::with_capacity(seen.len());
    for (k, seen) in seen.iter().enumerate() {
        let mut error = DVector::zeros(channels);
        let shows = &h * &x;
        if seen.motor.is_finite() {
            error[0] = seen.motor - shows[0];
        }
        if sees && seen.output.is_finite() {
            error[1] = seen.output / shaft - shows[1];
        }
        x += &gain * error;
        push.fill(0.0);
        push[0] = torque[k];
        let mut friction = 0.0;
        for (mass, law) in laws.iter().enumerate() {
            // A rigid joint has all its friction at one speed.
            let own = mass.min(masses - 1);
            let inertia = if masses == 1 { total } else { chain.inertia[own] };
            let felt = law.at(x[chain.speed(own)], law.width(step_s, inertia));
            push[own] -= felt;
            friction += felt;
        }
        for (stage, (_, cubic)) in chain.springs.iter().enumerate() {
            let extra = cubic * x[1 + stage].powi(3);
            push[stage] -= extra;
            push[stage + 1] += extra;
        }
        let left = x[size - 1];
        let windup = match chain.springs.len() {
            0 => stiffness(model).last().map_or(f64::NAN, |own| bent(*own, -left)),
            stages => x[stages],
        };
        guesses.push(Guess { load: -left / shaft, windup: windup * shaft, friction });
        x = &f * &x + &g * &push;
        if !x.iter().all(|v| v.is_finite()) {
            x.fill(0.0);
            x[0] = seen.motor;
        }
    }
    guesses
}
