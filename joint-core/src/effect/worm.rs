//! The mesh of a worm stage: friction that grows with the load, and may lock.
//!
//! The worm's thread is a wedge of lead angle λ with friction angle φ = atan μ. Driving the wheel
//! against a torque T takes `η T tan(λ + φ)/tan λ` at the worm; let go with it, the worm must still be
//! held by `η T tan(λ − φ)/tan λ`, and pushed where φ ≥ λ: the stage locks itself. What this differs
//! from the ideal `η T` is friction on the worm, a level that its LuGre friction takes on:
//! `g(v) (1 + A |η T|/α0)`, with `A = tan(λ + φ)/tan λ − 1` where the worm drives and
//! `A = 1 − tan(λ − φ)/tan λ` where the load does. T is the torque of the stage's spring and damper.
//!
//! Source: the screw's efficiency, as in every text on machine elements; μ is that of the flank over
//! the cosine of the pressure angle.

use super::hooks::{Effects, Rubbing};
use crate::batch::batch;
use crate::params::Stage;
use crate::per_unit::Bases;
use crate::scalar::Scalar;

/// The mesh of one worm stage, per-unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct Worm<S: Scalar> {
    /// The mass of the worm, 0 at the rotor.
    mass: u8,
    /// A/α0 where the worm drives, and where the load does.
    driving: S::Gain,
    driven: S::Gain,
}

batch!(Worm<Scalar>: driving, driven; mass);

impl<S: Scalar> Worm<S> {
    /// Of the worm that is this mass; `None` where the stage behind it is none.
    pub(crate) fn new(mass: usize, stage: &Stage, bases: &Bases<'_>) -> Option<Self> {
        let [driving, driven] = friction(stage)?;
        let unit = libm::fabs(bases.torque_at(mass)) / bases.coulomb_at(mass);
        Some(Self {
            mass: u8::try_from(mass).ok()?,
            driving: S::gain(driving * unit),
            driven: S::gain(driven * unit),
        })
    }
}

impl<S: Scalar> Effects<S> for Worm<S> {
    fn has_levels(&self) -> bool {
        true
    }

    fn has_level(&self, mass: usize) -> bool {
        mass == usize::from(self.mass)
    }

    #[inline(always)]
    fn inverse_level(&self, mass: usize, at: Rubbing<S>) -> S {
        if mass != usize::from(self.mass) {
            return S::ONE;
        }
        let (helps, load) = (at.passed_on.along(at.speed).below(S::ZERO), at.passed_on.abs());
        let share = S::choose(helps, load.times(self.driven), load.times(self.driving));
        S::ONE.over(S::ONE + share)
    }
}

/// Mesh friction over the ideal torque, A, where the worm drives and where the load does.
fn friction(stage: &Stage) -> Option<[f64; 2]> {
    let (lead, angle) = angles(stage)?;
    let ideal = libm::tan(lead);
    Some([libm::tan(lead + angle) / ideal - 1.0, 1.0 - libm::tan(lead - angle) / ideal])
}

fn angles(stage: &Stage) -> Option<(f64, f64)> {
    let lead = stage.worm_lead_angle_rad;
    (lead > 0.0).then(|| (lead, libm::atan(stage.worm_friction_coefficient)))
}

/// Efficiency of a worm stage's mesh with the worm driving; `None` where the stage is no worm.
pub fn efficiency(stage: &Stage) -> Option<f64> {
    let (lead, angle) = angles(stage)?;
    Some(libm::tan(lead) / libm::tan(lead + angle))
}

/// Efficiency with the wheel driving; zero or less where the stage locks itself.
pub fn back_efficiency(stage: &Stage) -> Option<f64> {
    let (lead, angle) = angles(stage)?;
    Some(libm::tan(lead - angle) / libm::tan(lead))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_worm_locks_from_the_friction_angle_on() {
        let stage = |mu| Stage {
            worm_lead_angle_rad: 0.1,
            worm_friction_coefficient: mu,
            ..Stage::default()
        };
        assert!(back_efficiency(&stage(0.1_f64.tan() * 0.99)).unwrap() > 0.0);
        assert!(back_efficiency(&stage(0.1_f64.tan() * 1.01)).unwrap() < 0.0);
        assert_eq!(efficiency(&stage(0.0)), Some(1.0));
        assert_eq!(efficiency(&Stage::default()), None);
    }
}
