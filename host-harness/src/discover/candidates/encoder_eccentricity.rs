//! Encoder eccentricity: an error that is fixed to the encoder's own angle, once or twice a turn.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::{Line, Rules};
use crate::estimate::record::Channel;

/// A disc off its centre, and a tilted one.
const ORDERS: [f64; 2] = [1.0, 2.0];

pub(super) const CARD: EffectCard = EffectCard {
    words: "an encoder's disc that is off its centre or tilted",
    residual: Residual::MeasuredAngle,
    axis: Axis::MotorAngle,
    experiment: "turn through full turns at several constant speeds: an encoder's error stays the same \
         angle, and the torque that it feigns grows with the square of the speed; a real torque \
         does not",
    reference: None,
    rules: Rules { line: Line { orders: &ORDERS, ..Line::ANY }, ..Rules::NONE },
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    for (channel, place) in
        [(Channel::Motor, Location::Encoder), (Channel::Output, Location::OutputEncoder)]
    {
        if !scene.record.has(channel) || scene.has(Kind::EncoderEccentricity, place) {
            continue;
        }
        let scale = (5.0 * scene.record.sensor_sigma(scene.model, channel)).max(1e-4);
        all.extend(ORDERS.map(|order| Hypothesis {
            start: EffectParameters::new(Kind::EncoderEccentricity, place).with("order", order),
            free: vec![Free::Phasor { amplitude: 0, scale, sigma: 100.0 }],
        }));
    }
    all
}

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let disc = EffectParameters::new(Kind::EncoderEccentricity, Location::Encoder)
        .with("amplitude_rad", 0.015 * joint.size)
        .with("phase_rad", joint.phase_rad);
    Some(disc)
}
