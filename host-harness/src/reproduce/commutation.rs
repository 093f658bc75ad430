//! The three-phase motor beside its DC equivalent at the same voltage: where (10) holds, and where the
//! commutation parts them.

use joint_core::joint::{Drive, Joint, Settings};
use joint_core::motor::inverter::Amplifier;
use joint_core::motor::six_step::Command;

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
    let mut found = Commutation::default();
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
