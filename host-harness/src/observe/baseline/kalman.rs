//! Steady-state Kalman filter of the joint as one inertia, or of the chain with its springs.

use joint_core::per_unit::Bases;
use nalgebra::{DMatrix, DVector};

use super::super::noise::sensors;
use super::super::rating::Rating;
use super::super::rating::breakaway_nm;
use super::super::run::Seen;
use super::super::score::Guess;
use super::common::{laws, stiffness, torque, wound};
use crate::model::Model;
use crate::plant::{inertias, output_shaft};

/// Masses and springs, reflected to the motor.
pub(super) struct Chain {
    inertia: Vec<f64>,
    springs: Vec<(f64, f64)>,
}

impl Chain {
    pub(super) fn rigid(model: &Model) -> Self {
        Self { inertia: vec![inertias(model).iter().sum()], springs: Vec::new() }
    }

    pub(super) fn flexible(model: &Model) -> Self {
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

pub(super) fn kalman(
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
    let bases = Bases::si(&model.motor, &model.stages);
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
        let [first, windup] = match chain.springs.len() {
            0 => wound(model, -left),
            stages => [x[1] * bases.shaft(1), x[stages] * shaft],
        };
        guesses.push(Guess { load: -left / shaft, first, windup, friction });
        x = &f * &x + &g * &push;
        if !x.iter().all(|v| v.is_finite()) {
            x.fill(0.0);
            x[0] = seen.motor;
        }
    }
    guesses
}
