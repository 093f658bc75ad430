//! Masses on hinges, with what acts on each by itself: viscous friction and drag, gravity, a coating's spring.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::{Friction, Location};

use super::GRAVITY;
use crate::model::Model;
use crate::plant::inertias;

/// A body that turns about its hinge.
pub(in crate::export) struct Mass {
    pub(in crate::export) mass_kg: f64,
    /// Of its own centre from the axis, x and z at angle zero.
    pub(in crate::export) offset_m: [f64; 2],
    /// About its own centre.
    pub(in crate::export) inertia_kg_m2: f64,
    /// Coefficients of the speed and of its square, which keeps the speed's sign.
    pub(in crate::export) damping: [f64; 2],
    /// Coefficients of the angle and of its cube.
    pub(in crate::export) stiffness: [f64; 2],
}

/// The effects of a kind at a place.
pub(super) fn at(
    model: &Model,
    kind: Kind,
    place: Location,
) -> impl Iterator<Item = &EffectParameters> {
    model.effects.iter().filter(move |own| own.kind == kind && own.location == place)
}

/// A mass's name; mass 0 is the rotor.
pub(super) fn name(mass: usize, masses: usize) -> String {
    match mass {
        0 => "rotor".to_owned(),
        k if k + 1 == masses => "output".to_owned(),
        k => format!("stage{k}"),
    }
}

/// The friction of every mass, from the rotor on.
pub(in crate::export) fn frictions(model: &Model) -> impl Iterator<Item = &Friction> {
    [&model.motor.friction].into_iter().chain(model.stages.iter().map(|stage| &stage.friction))
}

/// What is in proportion to speed: where there is no bristle, its damping acts as the oil's.
fn viscous(friction: &Friction) -> f64 {
    let bristle = if friction.coulomb_nm > 0.0 { 0.0 } else { friction.sigma1_nm_s_per_rad };
    friction.sigma2_nm_s_per_rad + bristle
}

pub(in crate::export) fn masses(model: &Model, lost: &mut Vec<String>) -> Vec<Mass> {
    let mut shaft = 1.0;
    let reductions = [1.0].into_iter().chain(model.stages.iter().map(|stage| stage.reduction));
    let own = inertias(model).into_iter().zip(frictions(model)).zip(reductions);
    let mut masses: Vec<Mass> = own
        .map(|((reflected, friction), reduction)| {
            shaft /= reduction;
            Mass {
                mass_kg: 1e-3,
                offset_m: [0.0; 2],
                inertia_kg_m2: reflected / (shaft * shaft),
                damping: [viscous(friction), 0.0],
                stiffness: [0.0; 2],
            }
        })
        .collect();
    let last = masses.len() - 1;
    let sum = |kind, place, key: &str| {
        at(model, kind, place).filter_map(|effect| effect.get(key)).sum::<f64>()
    };
    masses[0].damping[1] = sum(Kind::QuadraticDrag, Location::Motor, "coefficient_nm_s2");
    let coating = |key| sum(Kind::Coating, Location::Output, key);
    masses[last].stiffness =
        [coating("stiffness_nm_per_rad"), coating("cubic_stiffness_nm_per_rad3")];
    if let Some([gravity_nm, phase]) = gravity(model, last) {
        hang(&mut masses[last], gravity_nm, phase, lost);
    }
    masses
}

/// Amplitude and phase of what pulls on the last mass.
fn gravity(model: &Model, last: usize) -> Option<[f64; 2]> {
    let own = [model.load.gravity_nm, model.load.gravity_phase_rad];
    let found = model.effects.iter().filter(|effect| {
        effect.kind == Kind::Gravity && (last == 0 || effect.location == Location::Output)
    });
    let (mut sine, mut cosine) = (own[0] * own[1].sin(), own[0] * own[1].cos());
    for effect in found {
        let amplitude = effect.get("amplitude_nm").unwrap_or(0.0);
        let phase = effect.get("phase_rad").unwrap_or(0.0);
        sine += amplitude * phase.sin();
        cosine += amplitude * phase.cos();
    }
    let amplitude = sine.hypot(cosine);
    (amplitude != 0.0).then(|| [amplitude, sine.atan2(cosine)])
}

/// A pendulum of this torque, of the same inertia about the hinge.
fn hang(mass: &mut Mass, gravity_nm: f64, phase: f64, lost: &mut Vec<String>) {
    // Half of the inertia is the offset's: m g l is the torque, and m l² that half.
    let arm = 0.5 * mass.inertia_kg_m2 * GRAVITY / gravity_nm;
    if !(arm.is_finite() && arm > 0.0) {
        lost.push("gravity: there is no inertia for it to act on".to_owned());
        return;
    }
    mass.mass_kg = gravity_nm / (GRAVITY * arm);
    mass.inertia_kg_m2 *= 0.5;
    mass.offset_m = [arm * phase.sin(), -arm * phase.cos()];
}
