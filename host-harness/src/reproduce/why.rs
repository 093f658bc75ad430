//! What stands behind the rows that disagree: runs with one thing changed, which show the cause.

use super::scene::{Load, Scene};
use super::trace::{Trace, peak};
use super::{friction_loss, prescribed, scene};
use crate::model::Model;
use joint_core::params::Friction;

/// Stiffness, Nm/rad, and inertia, kg m², of the second stage with which the shock at the start of
/// figure 8 has both its wind-up and its speed.
const STIFFER: [f64; 2] = [27.0, 4.5e-7];

/// Measured causes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Why {
    /// Unloaded angle error without friction on the stages, rad at the motor.
    pub frictionless_angle: f64,
    /// The same with a tenth of the stages' friction levels.
    pub light_angle: f64,
    /// Wind-up, rad, and speed, rad/s, at the motor in the shock of figure 8 with [`STIFFER`].
    pub stiffer: [f64; 2],
    /// The same with the joint as it is and the load as a sine that begins at zero.
    pub gentle: [f64; 2],
    /// Share of the speed lost if the stages' friction, at any load, were what the gear's catalogue
    /// efficiency takes at its nominal load.
    pub loss_at_catalogue: f64,
}

/// Runs the changed joints; `gear` is the gear's efficiency as it is, `catalogue` what it should be.
///
/// # Errors
/// A data file or a model that is not admissible.
pub fn measure(model: &Model, gear: f64, catalogue: f64) -> Result<Why, String> {
    let scenes = scene::built_in()?;
    let of = |file: &str| {
        let found = scenes.iter().find(|(name, _)| *name == file);
        found.map(|(_, scene)| scene.clone()).ok_or_else(|| format!("no scenario {file}"))
    };
    let run = |model: &Model, scene: &Scene| -> Result<Trace, String> {
        prescribed::run(model, scene).map_err(|error| error.to_string())
    };
    let (free, sine) = (of("figure06")?, of("figure08")?);
    let angle = |share: f64| Ok::<_, String>(peak(&run(&rubbing(model, share), &free)?.windup()));
    let shock = |model: &Model, scene: &Scene| {
        let trace = run(model, scene)?;
        Ok::<_, String>([peak(&trace.windup()), peak(trace.output())])
    };
    let mut stiffer = model.clone();
    if let Some(stage) = stiffer.stages.last_mut() {
        [stage.stiffness_nm_per_rad, stage.inertia_kg_m2] = STIFFER;
    }
    let gentle = Scene { load: Load { phase_rad: 0.0, ..sine.load.clone() }, ..sine.clone() };
    let share = (1.0 / catalogue - 1.0) / (1.0 / gear - 1.0);
    Ok(Why {
        frictionless_angle: angle(0.0)?,
        light_angle: angle(0.1)?,
        stiffer: shock(&stiffer, &sine)?,
        gentle: shock(model, &gentle)?,
        loss_at_catalogue: friction_loss(&rubbing(model, share))?,
    })
}

/// The joint with this share of its stages' friction.
fn rubbing(model: &Model, share: f64) -> Model {
    let mut changed = model.clone();
    for stage in &mut changed.stages {
        let Friction { sigma0_nm_per_rad, coulomb_nm, stribeck_nm, .. } = stage.friction;
        stage.friction = if share > 0.0 {
            Friction {
                sigma0_nm_per_rad: share * sigma0_nm_per_rad,
                coulomb_nm: share * coulomb_nm,
                stribeck_nm: share * stribeck_nm,
                ..stage.friction
            }
        } else {
            Friction::default()
        };
    }
    changed
}
