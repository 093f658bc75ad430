//! What a log can tell at all: its motion against what each parameter and effect needs.
//!
//! No fit finds a resistance without a voltage, or an asymmetry in a joint that turns one way. What is said
//! here is necessary, not sufficient: `identify` says with errors what a log determines.

use joint_core::effect::Kind;
use serde::Serialize;

use super::torque_balance::TorqueBalance;
use super::windows::{Windows, scatter, travel};
use super::{Case, Check, Finding};
use crate::plant::output_shaft;

/// Standard deviations of a speed in a window beyond which its sign is known.
const MOVING: f64 = 3.0;
/// Samples of a window.
const WIDTH: usize = 20;
/// Share of a log's moving windows that both directions need.
const BOTH: f64 = 0.05;
/// Ratio of the fastest to the slowest tenth of the speeds from which on a curve of friction shows.
const RANGE: f64 = 3.0;
/// Turns of travel that a line of low order needs, and one of teeth or magnets.
const TURN: f64 = 0.25;
const TEETH: f64 = 0.02;
/// Reversals under load that a gap or a hysteresis needs.
const REVERSALS: usize = 3;
/// Seconds of motion within which nothing warms.
const WARMS_S: f64 = 1.0;

pub(super) const CHECK: Check =
    Check { name: "excitation", compares: "the motion with what parameters and effects need", run };

/// How a log moves its joint, and what it cannot tell.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Excitation {
    /// Samples.
    pub samples: usize,
    /// Length, s.
    pub duration_s: f64,
    /// Lowest and highest rotor speed, rad/s.
    pub speed_rad_per_s: [f64; 2],
    /// Changes of the speed's sign.
    pub reversals: usize,
    /// Travel of the rotor, turns.
    pub motor_turns: f64,
    /// Travel of the output, turns.
    pub output_turns: f64,
    /// Columns that are there, beside the time.
    pub columns: Vec<&'static str>,
    /// Parameters that nothing in the log depends on, each with the reason.
    pub parameters_untold: Vec<(String, String)>,
    /// Kinds of effects that it cannot show, each with the reason.
    pub effects_untold: Vec<(String, String)>,
}

/// How a log moves its joint.
pub fn excitation(case: &Case<'_>) -> Excitation {
    let (model, log) = (case.model, case.log);
    let windows = Windows::of(&log.time_s, WIDTH);
    let (speeds, _) = windows.derivatives(&log.time_s, &log.motor_angle_rad);
    let slowest = MOVING * windows.noise().0 * scatter(&log.motor_angle_rad);
    let moving: Vec<f64> = speeds.into_iter().filter(|w| w.abs() > slowest).collect();
    let extreme = |sign: f64| moving.iter().map(|w| sign * w).fold(0.0, f64::max) * sign;
    let reversals = moving.windows(2).filter(|pair| pair[0] * pair[1] < 0.0).count();
    let ahead = moving.iter().filter(|w| **w > 0.0).count();
    let both =
        ahead.min(moving.len() - ahead) as f64 >= BOTH * moving.len() as f64 && reversals > 0;
    let mut sizes: Vec<f64> = moving.iter().map(|w| w.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let tenth = |share: f64| sizes.get((share * sizes.len() as f64) as usize).copied();
    let range = tenth(0.9).unwrap_or(0.0) > RANGE * tenth(0.1).unwrap_or(f64::INFINITY);
    let turns = |angle: &[f64]| travel(angle) / std::f64::consts::TAU;
    let motor_turns = turns(&log.motor_angle_rad);
    let output_turns = match &log.output_angle_rad {
        Some(output) => turns(output),
        None => motor_turns * output_shaft(model).abs(),
    };
    let duration_s = log.time_s.last().unwrap_or(&0.0) - log.time_s.first().unwrap_or(&0.0);
    let seen = Seen {
        voltage: log.voltage_v.is_some(),
        current: log.current_a.is_some(),
        output: log.output_angle_rad.is_some(),
        moves: !moving.is_empty(),
        both,
        range,
        reversals,
        motor_turns,
        output_turns,
        moving_s: duration_s * moving.len() as f64 / windows.len().max(1) as f64,
    };
    let possible = |kind: &Kind| {
        let places = kind.spec().locations;
        places.iter().any(|place| match place {
            joint_core::params::Location::Stage(_) => !model.stages.is_empty(),
            _ => true,
        })
    };
    let effects = Kind::ALL.iter().filter(|kind| possible(kind));
    let effects_untold = effects
        .filter_map(|kind| Some((kind.spec().kind.to_owned(), seen.lacking(*kind)?.to_owned())));
    Excitation {
        samples: log.len(),
        duration_s,
        speed_rad_per_s: [extreme(-1.0), extreme(1.0)],
        reversals,
        motor_turns,
        output_turns,
        columns: log.columns().into_iter().skip(1).map(|(name, _)| name).collect(),
        parameters_untold: seen.parameters(model.stages.len(), case.balance.as_ref()),
        effects_untold: effects_untold.collect(),
    }
}

/// What effects are asked of.
struct Seen {
    voltage: bool,
    current: bool,
    output: bool,
    moves: bool,
    both: bool,
    range: bool,
    reversals: usize,
    motor_turns: f64,
    output_turns: f64,
    moving_s: f64,
}

impl Seen {
    /// Why a kind of effect cannot show; `None` where it can.
    fn lacking(&self, kind: Kind) -> Option<&'static str> {
        let unless = |there: bool, why: &'static str| (!there).then_some(why);
        if !self.moves {
            return Some("the joint does not move");
        }
        match kind {
            Kind::AsymmetricFriction => unless(self.both, "the joint turns one way"),
            Kind::Backlash | Kind::StructuralHysteresis => {
                unless(self.reversals >= REVERSALS, "the motion hardly reverses")
            }
            Kind::HardeningStiffness => unless(self.output, "no output_angle_rad"),
            Kind::TransmissionError => unless(
                self.output || self.motor_turns > TEETH,
                "no output_angle_rad and too little travel",
            ),
            Kind::Cogging | Kind::TorqueRipple => {
                unless(self.motor_turns > TEETH, "the rotor hardly turns")
            }
            Kind::EncoderEccentricity => {
                unless(self.motor_turns > TURN || self.output_turns > TURN, "too little travel")
            }
            Kind::Gravity | Kind::PositionDependentFriction => {
                unless(self.output_turns > TEETH, "the output hardly travels")
            }
            Kind::QuadraticDrag => unless(self.range, "the speed hardly varies"),
            Kind::DeadTime | Kind::SupplySag | Kind::CurrentLimit => unless(self.voltage, "no u_v"),
            Kind::WindingHeating => unless(
                self.voltage && self.moving_s > WARMS_S,
                "no u_v, or too short for a winding to warm",
            ),
            Kind::LubricantWarming => {
                unless(self.moving_s > WARMS_S, "too short for a lubricant to warm")
            }
            Kind::CurrentOffset | Kind::CurrentGain => unless(self.current, "no i_a"),
            Kind::SensorDelay => {
                unless(self.current && self.voltage || self.output, "one measured channel alone")
            }
            _ => None,
        }
    }

    /// Parameters that nothing in the log depends on.
    fn parameters(&self, stages: usize, balance: Option<&TorqueBalance>) -> Vec<(String, String)> {
        let mut all = Vec::new();
        let mut untold = |keys: &str, why: &str| all.push((keys.to_owned(), why.to_owned()));
        if !self.voltage {
            untold("phase_resistance_ohm, phase_inductance_h", "no u_v");
        } else if !self.current {
            untold("phase_inductance_h", "no i_a: resistance and torque constant only together");
        }
        if !self.voltage || !self.current {
            untold(
                "torque_constant_nm_per_a",
                "current or voltage alone: torques only in proportion to it",
            );
        }
        if stages > 0 && !self.output {
            untold("stiffness_nm_per_rad, damping_nm_s_per_rad", "no output_angle_rad");
        }
        if !self.both {
            untold("coulomb_nm", "the joint turns one way: a constant torque looks the same");
        }
        if !self.range {
            untold("sigma2_nm_s_per_rad, stribeck_nm", "the speed hardly varies");
        }
        if balance.is_none() {
            untold(
                "rotor_inertia_kg_m2",
                "the motion is too small or too short for its torque balance",
            );
        }
        all
    }
}

fn run(case: &Case<'_>) -> Vec<Finding> {
    let seen = excitation(case);
    let listed = |untold: &[(String, String)]| {
        untold.iter().map(|(what, why)| format!("{what} ({why})")).collect::<Vec<_>>().join("; ")
    };
    let mut all = vec![Finding::note(format!(
        "{} samples over {:.3} s, speed {:.3} to {:.3} rad/s, {} reversals, rotor {:.3} turns, output {:.3}",
        seen.samples,
        seen.duration_s,
        seen.speed_rad_per_s[0],
        seen.speed_rad_per_s[1],
        seen.reversals,
        seen.motor_turns,
        seen.output_turns
    ))];
    if seen.speed_rad_per_s == [0.0, 0.0] && seen.motor_turns > 0.0 {
        all.push(
            Finding::warning(
                "the joint never moves faster than its encoder scatters: nothing can be told",
            )
            .help("drive it through several reversals, at several speeds"),
        );
    }
    if !seen.parameters_untold.is_empty() {
        all.push(Finding::note(format!("cannot tell: {}", listed(&seen.parameters_untold))));
    }
    if !seen.effects_untold.is_empty() {
        all.push(Finding::note(format!("cannot show: {}", listed(&seen.effects_untold))));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::super::made::actuator_and_log;
    use super::*;

    fn untold(seen: &Excitation, kind: &str) -> bool {
        seen.effects_untold.iter().any(|(name, _)| name == kind)
    }

    #[test]
    fn a_rich_log_shows_friction_both_ways_and_one_without_voltage_no_dead_time() {
        let (model, mut log) = actuator_and_log();
        let seen = excitation(&Case::new(&model, &log));
        assert!(seen.reversals > 3 && !untold(&seen, "asymmetric-friction"), "{seen:?}");
        assert!(!untold(&seen, "dead-time"));
        log.voltage_v = None;
        let seen = excitation(&Case::new(&model, &log));
        assert!(untold(&seen, "dead-time") && untold(&seen, "supply-sag"));
        assert!(seen.parameters_untold.iter().any(|(keys, _)| keys.contains("resistance")));
    }

    #[test]
    fn a_joint_that_only_flickers_by_a_count_is_told() {
        let (model, mut log) = actuator_and_log();
        let count = std::f64::consts::TAU / 16384.0;
        let flicker = |k: usize| count * f64::from(u8::from((k * 7919).is_multiple_of(5)));
        log.motor_angle_rad = (0..log.len()).map(flicker).collect();
        log.output_angle_rad = None;
        let told = run(&Case::new(&model, &log));
        assert!(told.iter().any(|told| told.message.contains("never moves faster")), "{told:?}");
    }

    #[test]
    fn a_joint_that_turns_one_way_shows_no_asymmetry() {
        let (model, mut log) = actuator_and_log();
        let (mut angle, mut before) = (0.0, log.motor_angle_rad[0]);
        for value in &mut log.motor_angle_rad {
            angle += (*value - before).abs();
            before = std::mem::replace(value, angle);
        }
        assert!(untold(&excitation(&Case::new(&model, &log)), "asymmetric-friction"));
    }
}
