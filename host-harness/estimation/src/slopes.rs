//! Derivatives of a record's innovations with what moves a model: by differences, of models that are run
//! side by side.

use std::borrow::Cow;

use joint_core::effect::Kind;
use nalgebra::{DMatrix, DVector};

use super::coordinates::Coordinate;
use super::filter::Gains;
use super::fit::Problem;
use super::parameters::Quantity;
use super::record::CHANNELS;
use joint_simulation::model::Model;
use joint_simulation::plant::plant;

/// Step in a coordinate that is short beside everything in the joint.
const SHORT: f64 = 1e-6;

/// Most that rounding may make of a derivative, in innovations: a sensor's last digit may be finer than
/// that of an angle of many turns.
const ROUNDING: f64 = 1e-2;

/// How a coordinate's derivative is taken: by one step that is short, by a long one, or by two long ones.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    Short(f64),
    Long(f64),
    Central(f64),
}

impl Problem<'_> {
    /// Derivative of the residual with each coordinate: over a short step where the joint's constants
    /// follow from it smoothly, else over a long one; those are one-sided from the residual at the model if
    /// that is given, else central.
    pub fn sensitivity(
        &self,
        model: &Model,
        gains: &Gains,
        coordinates: &[Coordinate],
        here: Option<&DVector<f64>>,
    ) -> DMatrix<f64> {
        let short = self.short_step(gains);
        let ways: Vec<Way> = coordinates
            .iter()
            .map(|coordinate| match here {
                _ if !self.long_sighted && self.is_smooth(model, coordinate) => Way::Short(short),
                Some(_) => Way::Long(coordinate.difference_step()),
                None => Way::Central(coordinate.difference_step()),
            })
            .collect();
        let moved = |coordinate: &Coordinate, step: f64| {
            let mut moved = model.clone();
            coordinate.shift(&mut moved, step);
            moved
        };
        // A short step is held against a run of its own kind, so that rounding is the same in both.
        let mut models = vec![model.clone()];
        for (coordinate, way) in coordinates.iter().zip(&ways) {
            match *way {
                Way::Short(step) | Way::Long(step) => models.push(moved(coordinate, step)),
                Way::Central(step) => {
                    models.extend([step, -step].map(|step| moved(coordinate, step)));
                }
            }
        }
        let mut runs = self.innovations_of(&models, gains).into_iter();
        let own = runs.next().flatten();
        let mut jacobian = DMatrix::zeros(self.record.len() * CHANNELS, coordinates.len());
        for (mut column, way) in jacobian.column_iter_mut().zip(ways) {
            let one = runs.next().flatten();
            let (other, step) = match way {
                Way::Short(step) => (own.as_ref().map(|own| Cow::Borrowed(&own[..])), step),
                Way::Long(step) => (None, step),
                Way::Central(step) => (runs.next().flatten().map(Cow::Owned), 2.0 * step),
            };
            let Some(one) = one else { continue };
            let column = column.as_mut_slice().as_chunks_mut::<CHANNELS>().0;
            let mut take = |k: usize, other: &[f64]| {
                for ((slope, one), other) in column[k].iter_mut().zip(&one[k]).zip(other) {
                    *slope = (one - other) / step;
                }
            };
            for k in (0..self.record.len()).filter(|k| self.mask[*k] > 0.0) {
                match (&other, here) {
                    (Some(other), _) => take(k, &other[k]),
                    (None, Some(here)) => take(k, &here.as_slice()[k * CHANNELS..]),
                    (None, None) => {}
                }
            }
        }
        jacobian
    }

    /// A short step that is long beside rounding.
    fn short_step(&self, gains: &Gains) -> f64 {
        let rows = self.record.measured.iter().zip(&*gains.weight);
        let finest = rows
            .flat_map(|(row, weights)| {
                row.iter().zip(weights).map(|(value, weight)| value * weight)
            })
            .fold(0.0, |most: f64, value| most.max(value.abs()));
        (f64::EPSILON * finest / ROUNDING).max(SHORT)
    }

    /// Whether a coordinate moves the joint's constants and nothing else, and those smoothly.
    fn is_smooth(&self, model: &Model, coordinate: &Coordinate) -> bool {
        let outside = |kind: Kind| kind.is_of_a_sensor() || kind == Kind::InputDelay;
        // A delay of the current moves what its sensor shows.
        let delay = *coordinate == Coordinate::Parameter(Quantity::CurrentDelay);
        if delay || coordinate.effect().is_some_and(|e| outside(model.effects[e].kind)) {
            return false;
        }
        let plant = |model: &Model| plant(model, &self.record.grid, self.record.drive).ok();
        let constants = |steps: f64| {
            let mut moved = model.clone();
            coordinate.shift(&mut moved, steps * SHORT);
            Some(plant(&moved)?.constants())
        };
        let (Some(here), Some(one), Some(two)) = (plant(model), constants(1.0), constants(2.0))
        else {
            return false;
        };
        here.moves_smoothly([&one, &two])
    }
}

#[cfg(test)]
mod tests {
    use joint_core::effect::EffectParameters;
    use joint_core::params::Location;

    use super::*;
    use crate::filter::{Equation, Linearisation, Observer, Walk};
    use crate::record::Record;
    use crate::{noise, replicate};
    use joint_simulation::log::Log;
    use joint_simulation::plant::micro_steps;
    use joint_simulation::scenario::paper;

    /// A joint with several laws, among them one that remembers and one of a sensor.
    fn joint() -> Model {
        let mut model = paper();
        model.sensor.motor_encoder_counts_per_rev = 4096.0;
        model.sensor.output_encoder_counts_per_rev = 65536.0;
        model.sensor.current_noise_a = 1e-3;
        let torque = model.motor.friction.coulomb_nm;
        model.effects = vec![
            EffectParameters::new(Kind::Cogging, Location::Motor)
                .with("order", 6.0)
                .with("amplitude_nm", 0.3 * torque)
                .with("phase_rad", 0.4),
            EffectParameters::new(Kind::Coating, Location::Output)
                .with("stiffness_nm_per_rad", 1e-3)
                .with("hysteresis_nm", 1e-4)
                .with("width_rad", 0.01),
            EffectParameters::new(Kind::EncoderEccentricity, Location::Encoder)
                .with("amplitude_rad", 0.01),
        ];
        model
    }

    /// The record of a sine, as the joint itself would have made it.
    fn record(model: &Model) -> Record {
        let time_s: Vec<f64> = (0..3000).map(|k| f64::from(k) * 1e-4).collect();
        let log = Log {
            voltage_v: Some(time_s.iter().map(|t| 3.0 * (40.0 * t).sin()).collect()),
            current_a: Some(vec![0.0; time_s.len()]),
            motor_angle_rad: vec![0.0; time_s.len()],
            output_angle_rad: Some(vec![0.0; time_s.len()]),
            time_s,
            ..Log::default()
        };
        let blank = Record::new(&log, Some(micro_steps(model, 1e-4)));
        replicate::replicate(model, &blank, &noise::expected(model, &blank), 1).unwrap()
    }

    /// Step of the differences that slopes are held against.
    const DIFFERENCE: f64 = 1e-6;

    /// The joint with that many stages at most, and without the laws of those that are gone.
    fn shortened(stages: usize) -> Model {
        let mut model = joint();
        if stages < model.stages.len() {
            model.stages.truncate(stages);
            model.effects.truncate(1);
        }
        model
    }

    #[test]
    fn the_next_state_changes_with_this_one_as_differences_say() {
        for stages in [0, 1, 2, 3] {
            assert_changes_as_differences_say(&shortened(stages));
        }
    }

    fn assert_changes_as_differences_say(model: &Model) {
        let record = record(model);
        let plant = plant(model, &record.grid, record.drive).unwrap();
        let observer = Observer::new(model, &*plant, &record);
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask);
        let noise = noise::expected(model, &record);
        let n = observer.layout.len();
        let mut along = Cow::Owned(Linearisation::default());
        let (_, run) = observer.design_along(&mut along, &noise, &problem.walks(&noise, model));
        let likely = problem.deviance_along(&along, model, &noise).unwrap();
        let designed = problem.design_along(&mut along, model, &noise).unwrap().deviance;
        assert!((likely - designed).abs() < 1e-9 * designed.abs(), "{likely} {designed}");
        for k in [300, 1100, 1700] {
            let mut state = run.states[k][..n].to_vec();
            let inputs = [record.drive_values[k], record.load_nm[k]];
            let (mut transition, mut by_drive) = (Vec::new(), Vec::new());
            let steps = vec![1e-7; n + 1];
            let derivatives = (&mut transition, &mut by_drive);
            let held = ([inputs[0]; 2], inputs[1]);
            plant.linear().propagate(k, &mut state, held, &steps, derivatives);
            let mut plain = run.states[k][..n].to_vec();
            plant.propagate(k, &mut plain, inputs[0], inputs[1]);
            assert_eq!(state, plain);
            let next = |state: usize, moved: f64, drive: f64| {
                let mut x = run.states[k][..n].to_vec();
                x[state] += moved;
                plant.propagate(k, &mut x, record.drive_values[k] + drive, record.load_nm[k]);
                x
            };
            for j in 0..n {
                let step = 1e-5 * run.states.iter().fold(0.0, |most: f64, x| most.max(x[j].abs()));
                let (up, down) = (next(j, step, 0.0), next(j, -step, 0.0));
                for i in 0..n {
                    let wanted = (up[i] - down[i]) / (2.0 * step);
                    let found = along.transition[(k * n + i) * n + j];
                    let rounding = 1e-10 * up[i].abs() / step;
                    let off = (found - wanted).abs();
                    assert!(off < 1e-3 * wanted.abs() + rounding, "{k} {i} {j}: {found} {wanted}");
                }
            }
            let (up, down) = (next(0, 0.0, 1e-3), next(0, 0.0, -1e-3));
            for i in 0..n {
                let (wanted, found) = ((up[i] - down[i]) / 2e-3, along.drive[k * n + i]);
                let off = (found - wanted).abs();
                assert!(
                    off < 1e-3 * wanted.abs() + 1e-9 * up[i].abs(),
                    "{k} {i}: {found} {wanted}"
                );
            }
        }
    }

    #[test]
    fn slopes_of_a_run_are_those_of_its_differences() {
        let model = joint();
        let record = record(&model);
        let mask = vec![1.0; record.len()];
        let push = Walk::random(Equation::Torque(1), 1e-9, 1e-6);
        let problem = Problem::new(&record, &mask).pushed(push);
        let mut off = model.clone();
        Quantity::Stiffness(1).shift(&mut off, 0.05);
        let gains = problem.design(&off, &noise::expected(&off, &record)).unwrap().gains;
        let mut coordinates: Vec<Coordinate> =
            Quantity::of(&off, record.drive).into_iter().map(Coordinate::Parameter).collect();
        let value = |effect, value, scale| Coordinate::Effect { effect, value, scale, sigma: 1.0 };
        let amplitude = off.effects[0].values[1];
        coordinates.extend([
            value(0, 0, 0.1),
            Coordinate::Phasor {
                effect: 0,
                amplitude: 1,
                sine: true,
                scale: amplitude,
                sigma: 1.0,
            },
            value(1, 0, 1e-4),
            value(1, 1, 1e-5),
            value(2, 0, 1e-3),
        ]);
        let smooth = |coordinate: &Coordinate| problem.is_smooth(&off, coordinate);
        let columns = problem.sensitivity(&off, &gains, &coordinates, None);
        let near = |coordinate: &Coordinate| {
            let side = |step: f64| {
                let mut moved = off.clone();
                coordinate.shift(&mut moved, step);
                problem.residual(&problem.innovations(&moved, &gains).unwrap())
            };
            (side(DIFFERENCE) - side(-DIFFERENCE)) / (2.0 * DIFFERENCE)
        };
        let mut missing = Vec::new();
        for (coordinate, column) in coordinates.iter().zip(columns.column_iter()) {
            if !smooth(coordinate) {
                missing.push(coordinate);
                continue;
            }
            let wanted = near(coordinate);
            let error = (column - &wanted).norm() / wanted.norm();
            // One step bends, two round, and long ones step over a standstill.
            assert!(error < 2e-3 + 5e-3 / wanted.norm(), "{coordinate:?}: {error:e}");
        }
        // What a sensor shows is not the joint's.
        assert_eq!(missing, [&coordinates[coordinates.len() - 1]]);
    }

    #[test]
    fn models_run_side_by_side_have_the_bits_of_each_alone() {
        let mut model = joint();
        model.sensor.current_delay_s = 1.3e-4;
        let record = record(&model);
        let mask: Vec<f64> = (0..record.len()).map(|k| f64::from(u8::from(k < 2500))).collect();
        let push = Walk::random(Equation::Torque(1), 1e-9, 1e-6);
        let problem = Problem::new(&record, &mask).pushed(push);
        let gains = problem.design(&model, &noise::expected(&model, &record)).unwrap().gains;
        let mut models: Vec<Model> = Quantity::of(&model, record.drive)
            .into_iter()
            .map(|quantity| {
                let mut moved = model.clone();
                quantity.shift(&mut moved, 0.02);
                moved
            })
            .collect();
        // Others are run apart; what cannot be built is told.
        models.insert(3, shortened(1));
        let mut broken = model.clone();
        broken.motor.rotor_inertia_kg_m2 = -1.0;
        models.insert(5, broken);
        let runs = problem.innovations_of(&models, &gains);
        for (number, (model, run)) in models.iter().zip(&runs).enumerate() {
            let alone = problem.innovations(model, &gains).ok();
            assert_eq!(alone.is_some(), number != 5);
            if let (Some(run), Some(alone)) = (run, &alone) {
                assert!(run == alone, "{number}");
            }
            assert_eq!(run.is_some(), alone.is_some());
        }
    }
}
