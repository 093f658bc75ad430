//! Transmission error: lines in a stage's wind-up at orders of its input, there at no load too.
//!
//! Gears off their centre have the low orders, and a large one makes what is behind it stick, so that its
//! doubles and triples stand out in the spectrum instead of itself. So the low orders are all tested.
//!
//! Teeth that are not where they should be and marks of an encoder that are not show the same line in what the
//! encoder behind the gear says. Only the torque that it costs to bend the spring tells them apart, and a record may
//! hold little of it.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;
use joint_core::per_unit::Bases;

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::{Alike, Line, Rules};
use crate::estimate::adjoint::Pull;
use crate::estimate::record::{Channel, Record};
use crate::model::Model;

/// Orders that become hypotheses at each stage.
const KEPT: usize = 2;
/// Highest order looked for.
const HIGHEST: f64 = 64.0;
/// Whole orders that are hypotheses wherever the travel shows so much of a period.
const LOW: u32 = 8;
const PERIODS: f64 = 0.7;

pub(super) const CARD: EffectCard = EffectCard {
    words: "gears that do not pass the angle on evenly",
    residual: Residual::Windup,
    axis: Axis::MotorAngle,
    experiment: "turn slowly through full turns without a load, with an encoder behind the last stage: \
         its error repeats with the turn of the stage's input, cogging with the rotor's",
    reference: None,
    rules: Rules { alike: encoder, line: Line { is_of_input: true, ..Line::ANY }, ..Rules::NONE },
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    for (mass, place) in scene.masses().skip(1) {
        let stage = &scene.model.stages[mass - 1];
        let shaft = scene.shaft(mass);
        // Torque of a unit of argument, on the mass behind the spring and against the one before.
        let stiffness = stage.stiffness_nm_per_rad * shaft;
        let shape =
            |pull: &Pull, k: usize| stiffness * (pull.torque[mass][k] - pull.torque[mass - 1][k]);
        let family = scene.family(scene.angle(mass - 1), shape, HIGHEST, PERIODS);
        let amplitude = 0.1 * scene.torque_scale() / shaft.abs() / stage.stiffness_nm_per_rad;
        let mut orders = family.strongest(KEPT + 4);
        orders.retain(|order| !taken(scene, place, *order));
        orders.truncate(KEPT);
        let shown = PERIODS / family.turns();
        for order in (1..=LOW).map(f64::from) {
            if order >= shown && !taken(scene, place, order) && !orders.contains(&order) {
                orders.push(order);
            }
        }
        for order in orders {
            all.push(Hypothesis {
                start: EffectParameters::new(Kind::TransmissionError, place).with("order", order),
                free: vec![Free::Phasor { amplitude: 0, scale: amplitude, sigma: 100.0 }],
            });
        }
    }
    all
}

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let error = EffectParameters::new(Kind::TransmissionError, joint.gear()?)
        .with("amplitude_rad", joint.size * joint.windup_rad())
        .with("order", joint.one_of([1.0, 3.0, 5.0]))
        .with("phase_rad", joint.phase_rad);
    Some(error)
}

/// One sigma of an encoder's line, in amplitudes of what it stands for.
const SIGMA: f64 = 100.0;

/// A line of the output's encoder.
fn encoder(gear: &EffectParameters, model: &Model, record: &Record) -> Option<Alike> {
    let start = seen(model, gear);
    let free = Free::Phasor { amplitude: 0, scale: start.values[0].abs(), sigma: SIGMA };
    let nothing = start.with("amplitude_rad", 0.0);
    record.has(Channel::Output).then(|| Alike {
        hypothesis: Hypothesis { start: nothing, free: vec![free] },
        start,
        constant: None,
    })
}

/// What an encoder would have to show for a transmission error; the law of both is `a sin(n q + φ)`.
fn seen(model: &Model, gear: &EffectParameters) -> EffectParameters {
    let bases = Bases::si(&model.motor, &model.stages);
    let mass = bases.mass(gear.location).unwrap_or(0);
    let output = bases.shaft(model.stages.len());
    let [amplitude, phase, order, ..] = gear.values;
    let turns = bases.shaft(mass.saturating_sub(1)) / output;
    let shown = amplitude * output / bases.shaft(mass);
    EffectParameters::new(Kind::EncoderEccentricity, Location::OutputEncoder)
        .with("order", (order * turns).abs())
        .with("amplitude_rad", shown * turns.signum())
        .with("phase_rad", phase * turns.signum())
}

fn taken(scene: &Scene<'_>, place: Location, order: f64) -> bool {
    scene.model.effects.iter().any(|effect| {
        effect.kind == Kind::TransmissionError
            && effect.location == place
            && (effect.values[2] - order).abs() < 0.25
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::paper;

    #[test]
    fn an_encoder_shows_what_the_gear_adds() {
        let mut model = paper();
        model.stages.truncate(2);
        model.stages[1].reduction = -4.0;
        let bases = Bases::si(&model.motor, &model.stages);
        for stage in [1_u8, 2] {
            let gear = EffectParameters::new(Kind::TransmissionError, Location::Stage(stage))
                .with("order", 3.0)
                .with("amplitude_rad", 0.01)
                .with("phase_rad", 0.7);
            let [amplitude, phase, order, ..] = seen(&model, &gear).values;
            assert!(order > 0.0);
            for k in -5..=5 {
                let motor = 0.37 * f64::from(k);
                let [input, own, output] =
                    [usize::from(stage) - 1, stage.into(), 2].map(|mass| bases.shaft(mass));
                let adds = 0.01 * (3.0 * input * motor + 0.7).sin() * output / own;
                let shows = amplitude * (order * output * motor + phase).sin();
                assert!((adds - shows).abs() < 1e-12, "{adds} {shows}");
            }
        }
    }
}
