//! A line of a gear, or of the encoder behind it.
//!
//! Teeth that are not where they should be and marks of an encoder that are not show the same line in what
//! the encoder behind the gear says. Only the torque that it costs to bend the spring tells them apart, and
//! a record may hold little of it. So where the gear is named, the encoder is fitted in its place, and is
//! its rival.

use joint_core::effect::{EffectParameters, Kind};
use joint_core::params::Location;
use joint_core::per_unit::Bases;

use super::bootstrap::stays_ahead;
use crate::discover::state::rounds::Contender;
use crate::discover::state::search::Search;
use crate::discover::state::stage::Stage;
use crate::estimate::coordinates::Coordinate;
use crate::estimate::fit::Problem;
use crate::estimate::record::Channel;
use crate::estimate::refit::cost;
use crate::model::Model;
use crate::plant::BuildError;

/// What stands against the gear.
const ENCODER: (Kind, Location) = (Kind::EncoderEccentricity, Location::OutputEncoder);
/// One sigma of the prior, in amplitudes of what is replaced.
const SIGMA: f64 = 100.0;

/// Fits a line of the output's encoder in the place of each transmission error that was named; what cannot
/// be fitted is no rival.
pub(crate) fn ask_encoder(problem: &Problem<'_>, search: &mut Search) {
    if !problem.record.has(Channel::Output) || search.withdrawn.contains(&ENCODER.0) {
        return;
    }
    for k in 0..search.rounds.len() {
        if search.rounds[k].name.0 != Kind::TransmissionError {
            continue;
        }
        let Ok(stage) = instead(problem, search, search.place(k)) else { continue };
        let after = &search.after.fit;
        let gain = search.rounds[k].gain + cost(after) - cost(&stage.fit);
        if !gain.is_finite() {
            continue;
        }
        let contender = Contender { name: ENCODER, gain };
        let ahead = |rival: &Stage| stays_ahead(after, &[&rival.fit], problem.mask);
        search.rounds[k].rivalled(contender, stage, ahead);
    }
}

/// The fit with the encoder's line in the place of the model's effect number `place`.
fn instead(problem: &Problem<'_>, search: &Search, place: usize) -> Result<Stage, BuildError> {
    let model = &search.after.fit.model;
    let line = seen(model, &model.effects[place]);
    let scale = line.values[0].abs();
    let part = |sine| Coordinate::Phasor { effect: place, amplitude: 0, sine, scale, sigma: SIGMA };
    let lines = [line.with("amplitude_rad", 0.0), line];
    let parts = [false, true].map(part);
    search.after.instead(problem, &search.expected, place, lines, &parts)
}

/// What an encoder would have to show for a transmission error; the law of both is `a sin(n q + φ)`.
fn seen(model: &Model, gear: &EffectParameters) -> EffectParameters {
    let bases = Bases::si(&model.motor, &model.stages);
    let mass = bases.mass(gear.location).unwrap_or(0);
    let output = bases.shaft(model.stages.len());
    let [amplitude, phase, order, ..] = gear.values;
    let turns = bases.shaft(mass.saturating_sub(1)) / output;
    let shown = amplitude * output / bases.shaft(mass);
    EffectParameters::new(ENCODER.0, ENCODER.1)
        .with("order", (order * turns).abs())
        .with("amplitude_rad", shown * turns.signum())
        .with("phase_rad", phase * turns.signum())
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
