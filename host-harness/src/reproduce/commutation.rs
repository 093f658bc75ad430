//! The three-phase motor beside its DC equivalent at the same voltage: where (10) holds, and where the
//! commutation parts them.

use joint_core::joint::{Drive, Joint, Settings};
use joint_core::motor::inverter::Amplifier;
use joint_core::six_step::Command;

use super::driven::six_step;
use crate::model::Model;

/// Samples, one for each period, over a little more than a turn of the settled motor.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Commutation {
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Currents into the phases, A.
    pub phases_a: [Vec<f64>; 3],
    /// Current that would give the three-phase motor's torque, A.
    pub torque_a: Vec<f64>,
    /// Current of the DC equivalent, A.
    pub equivalent_a: Vec<f64>,
    /// Speed of both, rad/s.
    pub speed: [Vec<f64>; 2],
    /// How long a commutation lasts, s: ten time constants of the winding.
    pub lasting_s: f64,
}

impl Commutation {
    /// Difference of the two torques over that of the DC equivalent, at every sample.
    pub fn difference(&self) -> Vec<f64> {
        let pairs = self.torque_a.iter().zip(&self.equivalent_a);
        pairs.map(|(three, one)| (three - one) / one).collect()
    }

    /// Whether a sample lies in a commutation: the phases at the two ends have changed not long
    /// before, or change with the next sample.
    fn commutes(&self) -> Vec<bool> {
        let ends = |k: usize| {
            let current = |phase: &usize| self.phases_a[*phase][k];
            let by_current = |a: &usize, b: &usize| current(a).total_cmp(&current(b));
            ((0..3).max_by(by_current), (0..3).min_by(by_current))
        };
        let ends: Vec<_> = (0..self.time_s.len()).map(ends).collect();
        let mut last = f64::NEG_INFINITY;
        let mut within = vec![true; ends.len()];
        for k in 1..ends.len().saturating_sub(1) {
            if ends[k] != ends[k - 1] {
                last = self.time_s[k];
            }
            within[k] = ends[k + 1] != ends[k] || self.time_s[k] - last < self.lasting_s;
        }
        within
    }

    /// Largest magnitude of [`Commutation::difference`] outside commutations and in them.
    pub fn apart(&self) -> (f64, f64) {
        let mut most = (0.0_f64, 0.0_f64);
        for (difference, commutes) in self.difference().iter().zip(self.commutes()) {
            let of = if commutes { &mut most.1 } else { &mut most.0 };
            *of = of.max(difference.abs());
        }
        most
    }
}

/// Runs both rotors, without gear, at a voltage that the bus gives whole.
///
/// # Errors
/// A motor that the equations cannot take.
pub fn run(model: &Model, volts: f64) -> Result<Commutation, String> {
    let shown = |error: joint_core::params::ParameterError| error.to_string();
    let rotor = Model { stages: Vec::new(), effects: Vec::new(), ..model.clone() };
    let amplifier = Amplifier {
        bus_v: volts,
        pwm_period_s: 1e-6,
        dead_time_s: 0.0,
        current_bandwidth_rad_per_s: 1e4,
        current_limit_a: 1.0,
    };
    let three = six_step::<0>(&rotor, &amplifier).map_err(shown)?;
    let settings = Settings::new(Drive::Voltage, amplifier.pwm_period_s);
    let one = Joint::<f64, 0>::new(&rotor.motor, &[], &rotor.load, &settings).map_err(shown)?;
    let (mut phases, mut equivalent) = (three.rest(), one.rest());
    let motor = &rotor.motor;
    let winding_s = motor.phase_inductance_h / motor.phase_resistance_ohm;
    let mut found = Commutation { lasting_s: 10.0 * winding_s, ..Commutation::default() };
    for k in 0..100_000 {
        three.step(&mut phases, Command::Voltage(volts), 0.0);
        one.step(&mut equivalent, one.input(volts, 0.0));
        if k >= 97_000 {
            found.time_s.push(f64::from(k) * amplifier.pwm_period_s);
            for (series, value) in found.phases_a.iter_mut().zip(three.phase_currents(&phases)) {
                series.push(value);
            }
            found.torque_a.push(three.torque_current(&phases));
            found.equivalent_a.push(one.current(&equivalent));
            found.speed[0].push(three.joint().speed(&phases.joint, 0));
            found.speed[1].push(one.speed(&equivalent, 0));
        }
    }
    Ok(found)
}
