//! Dead time: a voltage lost against the current's sign, absent from the torque. Its softening is
//! where the current's own noise makes it cross zero.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::joint::Drive;
use joint_core::params::Location;

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;
use crate::estimate::record::Channel;

pub(super) const CARD: EffectCard = EffectCard {
    words: "voltage that the bridge loses against the sign of the current",
    residual: Residual::Voltage,
    axis: Axis::Current,
    experiment: "hold the rotor and step the voltage through a staircase around zero",
    reference: None,
    rules: Rules::NONE,
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let current = scene.record.drive == Drive::Current;
    if current || scene.has(Kind::DeadTime, Location::Inverter) {
        return Vec::new();
    }
    let noise = scene.record.sensor_sigma(scene.model, Channel::Current);
    let softening = if scene.record.has(Channel::Current) {
        2.0 * noise
    } else {
        0.01 * scene.largest_current()
    };
    let scale = 0.01 * scene.largest_drive();
    [0.5, 4.0]
        .map(|size| Hypothesis {
            start: EffectParameters::new(Kind::DeadTime, Location::Inverter)
                .with("voltage_v", size * scale)
                .with("softening_a", softening),
            free: vec![Free::Value { value: 0, scale, sigma: 20.0 }],
        })
        .to_vec()
}

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let dead_time = EffectParameters::new(Kind::DeadTime, Location::Inverter)
        .with("voltage_v", 0.05 * joint.size * joint.voltage_v)
        .with("softening_a", 2.0 * joint.current_noise_a);
    Some(dead_time)
}
