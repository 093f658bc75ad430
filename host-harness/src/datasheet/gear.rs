//! The gear's part of a starting model.
//!
//! A catalogue states a ratio, an efficiency at full torque and a backlash. Stiffness it seldom states,
//! friction never; both follow from the torque that the gear is made for.

use super::Datasheet;
use super::table::{Line, Slip, Table, assumed, no_load_speed, stated};

/// Continuous torque of a motor over the Coulomb part of its no-load torque, where the gear's own torque is not
/// stated: 30 to 70 on small motors.
const TORQUE_OVER_FRICTION: f64 = 40.0;
/// Wind-up of a servo gear under its continuous torque.
const WINDUP_RAD: f64 = 5e-3;
/// Damping ratio of steel gears in grease.
const DAMPING_RATIO: f64 = 0.05;
/// Share of the loss at full torque that is there without load: Coulomb friction. The rest grows with the load.
const UNLOADED_SHARE: f64 = 0.5;
/// Efficiency of one mesh of a planetary gear, and the largest ratio that one has.
const MESH_EFFICIENCY: f64 = 0.9;
const MESH_RATIO: f64 = 6.6;
/// Angle at a stage's output by which its bristles bend before they slip.
const PRESLIDING_RAD: f64 = 5e-4;
/// Stribeck velocity at the rotor, brought to the output by the ratio.
const STRIBECK_RAD_PER_S: f64 = 3.0;
/// A stage without inertia takes this share of what lies before it, as the model reader does.
const INERTIA_SHARE: f64 = 0.01;

/// The stages' tables.
pub(super) fn tables(sheet: &Datasheet, rotor_kg_m2: f64, rotor_coulomb_nm: f64) -> Vec<Table> {
    let count = sheet.gears.len();
    if count == 0 {
        return Vec::new();
    }
    let whole: f64 = sheet.gears.iter().product::<f64>().abs();
    let (efficiency, efficiency_note) = efficiency(sheet, whole);
    let (torque, torque_note) = match sheet.gear_torque_nm {
        Some(torque) => (torque, "the gear's continuous torque"),
        None => (
            TORQUE_OVER_FRICTION * rotor_coulomb_nm * whole * efficiency,
            "a continuous torque of 40 times the motor's Coulomb friction",
        ),
    };
    let speed = sheet.torque_constant().and_then(|(constant, _)| no_load_speed(sheet, constant));
    let mut before = rotor_kg_m2;
    let mut so_far = 1.0;
    let mut tables = Vec::new();
    for (k, ratio) in sheet.gears.iter().enumerate() {
        so_far *= ratio.abs();
        let behind = whole / so_far;
        let own_torque = torque / behind;
        let is_last = k + 1 == count;
        let inner = before * ratio * ratio;
        let load = sheet.load_inertia_kg_m2.filter(|_| is_last).unwrap_or(0.0);
        let mass = if load > 0.0 { load } else { INERTIA_SHARE * inner };
        let (stiffness_nm_per_rad, stiffness) = match sheet.gear_stiffness_nm_per_rad {
            Some(whole) => {
                let own = count as f64 * whole / (behind * behind);
                let note = match count {
                    1 => "the gear's stiffness at its output",
                    _ => "the gear's stiffness, its compliance shared equally among the stages",
                };
                (own, stated("stiffness_nm_per_rad", own, note))
            }
            None => {
                let own = own_torque / WINDUP_RAD;
                let note = format!("winds up by 5 mrad under {torque_note}");
                (own, assumed("stiffness_nm_per_rad", own, note))
            }
        };
        let between = inner * mass / (inner + mass);
        let lines = vec![
            // In full: over many turns a rounded ratio drifts from the encoder behind it.
            Line {
                value: format!("{ratio:?}"),
                ..stated("reduction", *ratio, "gear ratio, input over output turns")
            },
            stiffness,
            assumed(
                "damping_nm_s_per_rad",
                2.0 * DAMPING_RATIO * (stiffness_nm_per_rad * between).sqrt(),
                "damping ratio 0.05",
            ),
        ];
        tables.push(Table { header: "[[stage]]", lines });
        let own_efficiency = efficiency.powf(1.0 / count as f64);
        let coulomb_nm = UNLOADED_SHARE * (1.0 - own_efficiency) * own_torque;
        let note = format!("half of the loss of {efficiency_note} under {torque_note}");
        let viscous = match speed {
            Some(speed) => assumed(
                "sigma2_nm_s_per_rad",
                0.5 * coulomb_nm / (speed / so_far),
                "half as much again at the no-load speed",
            ),
            None => assumed("sigma2_nm_s_per_rad", 0.0, "no no-load speed is given"),
        };
        if coulomb_nm > 0.0 {
            let slip = Slip {
                coulomb: assumed("coulomb_nm", coulomb_nm, note),
                coulomb_nm,
                viscous,
                presliding_rad: PRESLIDING_RAD,
                stribeck_rad_per_s: STRIBECK_RAD_PER_S / so_far,
                inertia_kg_m2: mass,
            };
            tables.push(Table { header: "[stage.friction]", lines: slip.lines() });
        }
        before = inner + mass;
    }
    tables
}

/// The gear's largest efficiency, with where it comes from.
fn efficiency(sheet: &Datasheet, ratio: f64) -> (f64, String) {
    if let Some(efficiency) = sheet.gear_efficiency {
        return (efficiency, format!("an efficiency of {:.0} %", 100.0 * efficiency));
    }
    let meshes =
        sheet.gear_meshes.map_or_else(|| (ratio.ln() / MESH_RATIO.ln()).ceil().max(1.0), f64::from);
    let efficiency = MESH_EFFICIENCY.powf(meshes);
    (efficiency, format!("{meshes} meshes of 90 %"))
}

/// The catalogue's backlash as an effect of the last stage.
pub(super) fn backlash(sheet: &Datasheet) -> Option<Table> {
    let width = sheet.gear_backlash_rad.filter(|_| !sheet.gears.is_empty())?;
    let text = |key, value: String, note: &str| Line {
        key,
        value: format!("\"{value}\""),
        note: note.to_owned(),
        assumed: false,
    };
    Some(Table {
        header: "[[effect]]",
        lines: vec![
            text("kind", "backlash".to_owned(), "an effect beside the plain model"),
            text("location", format!("stage{}", sheet.gears.len()), "all of it at the last stage"),
            stated("width_rad", width, "backlash at the output"),
        ],
    })
}
