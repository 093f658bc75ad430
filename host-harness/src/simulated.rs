//! A simulation as the columns of a log, with every state beside them.

use crate::encoders;
use crate::log::{CURRENT, Log, MOTOR_ANGLE, OUTPUT_ANGLE};
use crate::model::Model;
use crate::plant::{Snapshot, StageSnapshot};

/// The log's own columns, with simulated current and angles for the measured ones, then every
/// state; a current that is the input stays as it is.
///
/// The states are `current_a`, `motor_speed_rad_per_s`, `motor_bristle`, and of each stage
/// `stageK_angle_rad`, `stageK_speed_rad_per_s`, `stageK_windup_rad` and `stageK_bristle`, angles
/// and speeds at the stage's own side.
pub fn columns(model: &Model, log: &Log, snapshots: &[Snapshot]) -> Vec<(String, Vec<f64>)> {
    let all = |of: &dyn Fn(&Snapshot) -> f64| snapshots.iter().map(of).collect::<Vec<f64>>();
    let shown = encoders::shown(model, &log.time_s, snapshots);
    let current = || encoders::late_current(model, &all(&|s| s.measured_current_a), &log.time_s);
    let mut columns: Vec<(String, Vec<f64>)> = log
        .columns()
        .into_iter()
        .map(|(name, measured)| {
            let values = match name {
                CURRENT if log.voltage_v.is_some() => current(),
                MOTOR_ANGLE => shown.motor.clone(),
                OUTPUT_ANGLE => shown.output.clone(),
                _ => measured.to_vec(),
            };
            (name.to_owned(), values)
        })
        .collect();
    columns.push(("current_a".to_owned(), all(&|s| s.current_a)));
    columns.push(("motor_speed_rad_per_s".to_owned(), all(&|s| s.motor_speed_rad_per_s)));
    columns.push(("motor_bristle".to_owned(), all(&|s| s.motor_bristle)));
    let stages = snapshots.first().map_or(0, |s| s.stages.len());
    for k in 0..stages {
        let mut push = |name: &str, of: fn(&StageSnapshot) -> f64| {
            let values = all(&|s| s.stages.get(k).map_or(f64::NAN, of));
            columns.push((format!("stage{}_{name}", k + 1), values));
        };
        push("angle_rad", |stage| stage.angle_rad);
        push("speed_rad_per_s", |stage| stage.speed_rad_per_s);
        push("windup_rad", |stage| stage.windup_rad);
        push("bristle", |stage| stage.bristle);
    }
    columns
}
