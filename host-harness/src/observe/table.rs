//! What the observer found, as the columns of a file.

use std::fmt::Write as _;

use super::run::Found;

/// The header of a joint with that many stages.
pub fn header(stages: usize) -> String {
    let mut names = vec!["motor_velocity_rad_per_s".to_owned(), "motor_friction_nm".to_owned()];
    names.extend((1..=stages).map(|k| format!("stage{k}_friction_nm")));
    names.push("total_friction_at_motor_nm".to_owned());
    names.extend((1..=stages).map(|k| format!("stage{k}_windup_rad")));
    names.extend(
        [
            "output_angle_rad",
            "output_velocity_rad_per_s",
            "load_torque_nm",
            "drive_bias",
            "resistance_error",
            "torque_constant_error",
            "friction_error",
        ]
        .map(str::to_owned),
    );
    let mut spread = vec!["motor_velocity_rad_per_s_std".to_owned()];
    spread.push("total_friction_at_motor_nm_std".to_owned());
    spread.extend((1..=stages).map(|k| format!("stage{k}_windup_rad_std")));
    spread.extend(
        ["output_angle_rad_std", "output_velocity_rad_per_s_std", "load_torque_nm_std"]
            .map(str::to_owned),
    );
    format!("t_s,{},{},status", names.join(","), spread.join(","))
}

/// The rows; friction of a stage stands at its own side, as `shafts` say.
pub fn rows<const N: usize>(time_s: &[f64], found: &[Found<N>], shafts: &[f64; N]) -> String {
    let mut text = String::new();
    for (time, found) in time_s.iter().zip(found) {
        let e = &found.estimate;
        let s = &e.spread;
        let _ = write!(text, "{time}");
        let mut put = |value: f64| {
            let _ = write!(text, ",{value:.9e}");
        };
        put(e.motor_velocity);
        put(e.motor_friction);
        e.stage_friction.iter().zip(shafts).for_each(|(v, shaft)| put(v / shaft));
        put(e.total_friction);
        e.windup.iter().for_each(|v| put(*v));
        put(found.output_angle);
        put(e.output_velocity);
        put(e.load);
        put(e.bias);
        put(e.resistance);
        put(e.flux);
        put(e.friction);
        put(s.motor_velocity);
        put(s.total_friction);
        s.windup.iter().for_each(|v| put(*v));
        put(s.output_angle);
        put(s.output_velocity);
        put(s.load);
        let _ = writeln!(text, ",{}", e.status);
    }
    text
}
