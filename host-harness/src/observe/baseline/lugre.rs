//! LuGre run open-loop on the measured speed, exact over a step.

use super::super::run::Seen;
use super::super::score::Guess;
use super::common::{held, laws, speeds};
use crate::model::Model;

pub(super) fn lugre(cutoff: f64, model: &Model, step_s: f64, seen: &[Seen]) -> Vec<Guess> {
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
            Guess { friction, ..Guess::NOTHING }
        })
        .collect()
}
