//! An eddy-current brake: a torque against the speed with a hump in it. Its critical speed is tried at
//! several shares of the largest.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;

/// Critical speeds that are tried, as shares of the largest.
const SHARES: [f64; 3] = [0.1, 0.3, 0.8];

pub(super) const CARD: EffectCard = EffectCard {
    words: "a conductor between magnets, which drags most at its critical speed",
    residual: Residual::Torque,
    axis: Axis::MotorSpeed,
    experiment: "hold constant speeds from standstill to the highest: the current has a hump at the \
         critical speed, where friction is a dip or a line",
    reference: None,
    rules: Rules::NONE,
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    if scene.has(Kind::EddyBrake, Location::Motor) {
        return Vec::new();
    }
    let scale = 0.05 * scene.torque_scale();
    SHARES
        .map(|share| share * scene.largest_speed().max(1e-9))
        .map(|speed| Hypothesis {
            start: EffectParameters::new(Kind::EddyBrake, Location::Motor)
                .with("critical_speed_rad_per_s", speed),
            free: vec![
                Free::Value { value: 0, scale, sigma: 200.0 },
                Free::Value { value: 1, scale: 0.2 * speed, sigma: 10.0 },
            ],
        })
        .to_vec()
}

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let brake = EffectParameters::new(Kind::EddyBrake, Location::Motor)
        .with("critical_torque_nm", 0.6 * joint.size * joint.motor_torque_nm)
        .with("critical_speed_rad_per_s", 0.2 * joint.speed_rad_per_s);
    Some(brake)
}
