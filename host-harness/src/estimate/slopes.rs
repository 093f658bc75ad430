//! Derivatives of a run through its filter: of the innovations with what moves the joint's constants,
//! and of the joint's states over one interval.

use joint_core::effect::Kind;
use joint_core::scalar::Scalar;
use nalgebra::DVector;
use rayon::prelude::*;

use super::coordinates::Coordinate;
use super::filter::{Equation, Gains, Observer, Walk};
use super::fit::Problem;
use super::record::{CHANNELS, Channel};
use crate::model::Model;
use crate::plant::{Layout, inertias, plant as plant_of};
use crate::tangent::{Constants, Dual, LANES, Slopes, Tangent};

/// Steps over which an encoder's errors are differenced, rad and rad/s.
const SHAFT_STEP: f64 = 1e-6;

/// What the innovations change with: a plant's tangent, and how each mass's inertia moves along.
pub struct Directions {
    /// The plant.
    pub tangent: Box<dyn Tangent>,
    /// By mass.
    pub inertia: Vec<Dual>,
}

/// Whether a law concerns what a sensor shows, not what the joint does.
pub(super) fn is_of_a_sensor(kind: Kind) -> bool {
    matches!(
        kind,
        Kind::EncoderEccentricity | Kind::SensorDelay | Kind::CurrentOffset | Kind::CurrentGain
    )
}

/// Step in a coordinate over which the joint's constants are differenced: they follow from the
/// parameters smoothly and to the last digit.
const CONSTANTS_STEP: f64 = 1e-6;

impl Problem<'_> {
    /// Derivative of the residual with each coordinate that moves the joint's numbers and nothing else.
    pub(super) fn tangents(
        &self,
        model: &Model,
        gains: &Gains,
        coordinates: &[Coordinate],
    ) -> Vec<Option<DVector<f64>>> {
        let mut columns = vec![None; coordinates.len()];
        let Ok(plant) = plant_of(model, &self.record.grid, self.record.drive) else {
            return columns;
        };
        let inertia = inertias(model);
        let moved: Vec<(usize, Constants, Vec<f64>)> = coordinates
            .iter()
            .enumerate()
            .filter_map(|(number, coordinate)| {
                if coordinate.effect().is_some_and(|e| is_of_a_sensor(model.effects[e].kind)) {
                    return None;
                }
                let moved = [1.0, 2.0].map(|steps| {
                    let mut moved = model.clone();
                    coordinate.shift(&mut moved, steps * CONSTANTS_STEP);
                    moved
                });
                let constants = |model| plant_of(model, &self.record.grid, self.record.drive);
                let [one, two] = moved.each_ref().map(|m| constants(m).ok()?.constants());
                let (one, two) = (one?, two?);
                let smooth = plant.moves_smoothly([&one, &two]);
                smooth.then(|| (number, one, inertias(&moved[0])))
            })
            .collect();
        if moved.is_empty() {
            return columns;
        }
        let observer = self.observer(model, &*plant);
        let passes = moved.len().div_ceil(LANES);
        let found: Vec<(usize, DVector<f64>)> = moved
            .par_chunks(moved.len().div_ceil(passes))
            .flat_map_iter(|chunk| {
                let apart: Vec<_> = chunk.iter().map(|(_, c, _)| (c, CONSTANTS_STEP)).collect();
                let slope = |mass: usize, other: &[f64]| {
                    ((other[mass] - inertia[mass]) / CONSTANTS_STEP) as f32
                };
                let inertia = (0..inertia.len()).map(|mass| {
                    let mut dual = Dual::constant(inertia[mass]);
                    for (lane, (.., other)) in dual.slopes.iter_mut().zip(chunk) {
                        *lane = slope(mass, other);
                    }
                    dual
                });
                let directions = plant
                    .tangent(&apart)
                    .map(|tangent| Directions { tangent, inertia: inertia.collect() });
                let rows = directions.map(|along| observer.innovation_slopes(gains, &along));
                let rows = rows.unwrap_or_default();
                let column = |lane: usize| {
                    let masked = rows.iter().zip(self.mask);
                    let values = masked.flat_map(|(row, weight)| {
                        row.map(
                            |channel| {
                                if *weight > 0.0 { f64::from(channel[lane]) } else { 0.0 }
                            },
                        )
                    });
                    DVector::from_iterator(self.record.len() * CHANNELS, values)
                };
                let columns: Vec<_> = (0..if rows.is_empty() { 0 } else { chunk.len() })
                    .map(|lane| (chunk[lane].0, column(lane)))
                    .collect();
                columns
            })
            .collect();
        for (number, column) in found {
            columns[number] = Some(column);
        }
        columns
    }
}

impl Observer<'_> {
    /// Derivatives of [`Observer::innovations`] along directions that leave the sensors as they are:
    /// by sample and channel, one for each direction.
    pub fn innovation_slopes(&self, gains: &Gains, along: &Directions) -> Vec<[Slopes; CHANNELS]> {
        let designed = gains.order - gains.walks.len();
        let own = self.layout.len();
        let common = designed.min(own);
        let mut x = Vec::new();
        let mut slopes = vec![[[0.0; LANES]; CHANNELS]; self.record.len()];
        for (k, row) in slopes.iter_mut().enumerate() {
            if self.is_idle(k) {
                continue;
            }
            if self.record.starts.contains(&k) {
                let start = self.start(k, own + gains.walks.len());
                x = start.into_iter().map(Dual::constant).collect();
            }
            for channel in Channel::ALL {
                let c = channel as usize;
                let weight = gains.weight[k][c];
                if weight == 0.0 {
                    continue;
                }
                let shown = self.shown_along(channel, &x, &gains.walks);
                let measured = Dual::constant(self.late.measured[k][c]);
                let error = (measured - shown).scaled(weight);
                if !error.value.is_finite() {
                    continue;
                }
                row[c] = error.slopes;
                let slot = (k * CHANNELS + c) * gains.order;
                let (states, walks) = gains.gain[slot..slot + gains.order].split_at(designed);
                let corrected = x.iter_mut().zip(&states[..common]);
                for (value, gain) in corrected {
                    *value = *value + error.scaled(*gain);
                }
                for (value, gain) in x[own..].iter_mut().zip(walks) {
                    *value = *value + error.scaled(*gain);
                }
            }
            self.advance_along(k, &mut x, &gains.walks, along);
        }
        slopes
    }

    fn shown_along(&self, channel: Channel, x: &[Dual], walks: &[Walk]) -> Dual {
        let n = self.layout.len();
        let values: Vec<f64> = x.iter().map(|value| value.value).collect();
        let mut shown = Dual::constant(0.0);
        let mut add = |by: f64, of: &Dual| {
            if by != 0.0 {
                shown = shown + of.scaled(by);
            }
        };
        for (walk, value) in walks.iter().zip(&x[n..]) {
            add(f64::from(u8::from(walk.equation == Equation::Sensor(channel))), value);
        }
        match channel {
            Channel::Current => {
                let slope = self.plant.measured_current(1.0) - self.plant.measured_current(0.0);
                add(slope, &x[Layout::CURRENT]);
            }
            Channel::Motor | Channel::Output => {
                let output = channel == Channel::Output;
                let (mass, shaft) =
                    if output { (self.layout.stages, self.shaft) } else { (0, 1.0) };
                let wound = if output { self.layout.stages } else { 0 };
                let [by_angle, by_speed] = self.encoder_slopes(channel, &values);
                add(shaft * by_angle, &x[Layout::ANGLE]);
                for stage in 0..wound {
                    add(-shaft * by_angle, &x[self.layout.deflection(stage)]);
                }
                add(shaft * by_speed, &x[self.layout.speed(mass)]);
            }
        }
        // The value is the one that a run without derivatives has.
        Dual { value: self.shown(channel, &values, walks), ..shown }
    }

    /// How what an encoder shows changes with its shaft's angle and speed.
    fn encoder_slopes(&self, channel: Channel, x: &[f64]) -> [f64; 2] {
        let caught_up = self.late.by[channel as usize];
        if !self.sensor_errors {
            return [1.0, caught_up];
        }
        let output = channel == Channel::Output;
        let wound = if output { self.layout.stages } else { 0 };
        let (mass, shaft) = if output { (self.layout.stages, self.shaft) } else { (0, 1.0) };
        let deflection: f64 = (0..wound).map(|k| x[self.layout.deflection(k)]).sum();
        let angle = (x[Layout::ANGLE] - deflection) * shaft;
        let speed = x[self.layout.speed(mass)] * shaft;
        let error = |angle, speed| self.plant.encoder_error(output, angle, speed);
        let here = error(angle, speed);
        let by_angle = (error(angle + SHAFT_STEP, speed) - here) / SHAFT_STEP;
        let by_speed = (error(angle, speed + 1.0) - here) / 1.0;
        [1.0 + by_angle, caught_up + by_speed]
    }

    fn advance_along(&self, k: usize, x: &mut [Dual], walks: &[Walk], along: &Directions) {
        let n = self.layout.len();
        let interval = self.record.grid.interval(k);
        let mut drive = Dual::constant(self.record.drive_values[k]);
        for (walk, value) in walks.iter().zip(&x[n..]) {
            if walk.equation == Equation::Voltage {
                drive = drive + *value;
            }
        }
        along.tangent.propagate(k, &mut x[..n], drive, self.record.load_nm[k]);
        for (j, walk) in walks.iter().enumerate() {
            if let Equation::Torque(mass) = walk.equation {
                let torque = x[n + j];
                self.push_along(x, mass, torque, interval, along.inertia[mass]);
            }
        }
    }

    /// [`Observer::push`] with derivatives.
    fn push_along(&self, x: &mut [Dual], mass: usize, torque: Dual, interval: f64, inertia: Dual) {
        let gained = (torque * Dual::constant(interval)).over(inertia);
        let moved = gained * Dual::constant(0.5 * interval);
        let speed = self.layout.speed(mass);
        x[speed] = x[speed] + gained;
        if mass == 0 {
            x[Layout::ANGLE] = x[Layout::ANGLE] + moved;
        } else {
            let before = self.layout.deflection(mass - 1);
            x[before] = x[before] - moved;
        }
        if mass < self.layout.stages {
            let behind = self.layout.deflection(mass);
            x[behind] = x[behind] + moved;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use joint_core::effect::EffectParameters;
    use joint_core::params::Location;

    use super::*;
    use crate::estimate::filter::Linearisation;
    use crate::estimate::parameters::Quantity;
    use crate::estimate::record::Record;
    use crate::estimate::{noise, twin};
    use crate::log::Log;
    use crate::scenario::paper;

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
        let blank = Record::new(&log, Some(crate::plant::micro_steps(model, 1e-4)));
        twin::twin(model, &blank, &noise::expected(model, &blank), 1).unwrap()
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
        let plant = plant_of(model, &record.grid, record.drive).unwrap();
        let observer = Observer::new(model, &*plant, &record);
        let mask = vec![1.0; record.len()];
        let problem = Problem::new(&record, &mask);
        let noise = noise::expected(model, &record);
        let n = observer.layout.len();
        let mut along = Cow::Owned(Linearisation::default());
        let (_, run) = observer.design_along(&mut along, &noise, &problem.walks());
        let likely = problem.deviance_along(&along, model, &noise).unwrap();
        let designed = problem.design_along(&mut along, model, &noise).unwrap().deviance;
        assert!((likely - designed).abs() < 1e-9 * designed.abs(), "{likely} {designed}");
        for k in [300, 1100, 1700] {
            let mut state = run.states[k][..n].to_vec();
            let inputs = [record.drive_values[k], record.load_nm[k]];
            let (mut transition, mut by_drive) = (Vec::new(), Vec::new());
            let linear = plant.linear(n).unwrap();
            linear.propagate(k, &mut state, inputs, &mut transition, &mut by_drive);
            let mut plain = run.states[k][..n].to_vec();
            plant.propagate(k, &mut plain, inputs[0], inputs[1]);
            for (carried, plain) in state.iter().zip(&plain) {
                assert!((carried - plain).abs() <= 1e-11 * plain.abs(), "{carried} {plain}");
            }
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
        let push = Walk { equation: Equation::Torque(1), initial: 1e-9, rate: 1e-6 };
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
        let columns = problem.tangents(&off, &gains, &coordinates);
        let near = |coordinate: &Coordinate| {
            let side = |step: f64| {
                let mut moved = off.clone();
                coordinate.shift(&mut moved, step);
                problem.residual(&problem.innovations(&moved, &gains).unwrap())
            };
            (side(DIFFERENCE) - side(-DIFFERENCE)) / (2.0 * DIFFERENCE)
        };
        let mut missing = Vec::new();
        for (coordinate, column) in coordinates.iter().zip(&columns) {
            let Some(column) = column else {
                missing.push(coordinate);
                continue;
            };
            let wanted = near(coordinate);
            let error = (column - &wanted).norm() / wanted.norm();
            // Short ones round; long ones step over a standstill.
            assert!(error < 1e-4 + 5e-3 / wanted.norm(), "{coordinate:?}: {error:e}");
        }
        // What a sensor shows is not the joint's.
        assert_eq!(missing, [&coordinates[coordinates.len() - 1]]);
    }
}
