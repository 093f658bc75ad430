//! A joint in place of sensors, for a board without a motor, and for an emulated one.
//!
//! It is the same joint under a voltage that reverses and rests and a load that comes and goes, in
//! single precision, so that host and chip see the very same samples.

use joint_core::joint::{Drive, Joint, Settings, State};
use joint_core::params::ParameterError;

use crate::joint::{LOAD, MOTOR, MOTOR_COUNTS, PERIOD_S, STAGES};

const N: usize = STAGES.len();
/// Volts, each for so many periods.
const VOLTAGES: [f32; 5] = [3.0, -4.5, 0.0, 0.4, 6.0];
const HELD: u32 = 400;
const LOAD_NM: f32 = 0.004;

/// What a converter and an encoder's timer would show.
#[derive(Debug)]
pub struct StandIn {
    joint: Joint<f32, N>,
    state: State<f32, N>,
    periods: u32,
}

impl StandIn {
    /// At rest.
    ///
    /// # Errors
    /// Parameters that the equations cannot take.
    pub fn start() -> Result<Self, ParameterError> {
        let settings = Settings { micro_steps: Some(1), ..Settings::new(Drive::Voltage, PERIOD_S) };
        let joint = Joint::<f32, N>::new(&MOTOR, &STAGES, &LOAD, &settings)?;
        let state = joint.rest();
        Ok(Self { joint, state, periods: 0 })
    }

    /// The current, A, and the encoder's counts; then a period passes.
    pub fn read(&mut self) -> (f32, i32) {
        let angle = &self.state.angle;
        let counts = MOTOR_COUNTS as f32;
        // Towards minus infinity, as an encoder counts; the part is −½ to ½.
        let part = (angle.part * counts + counts) as i32 - MOTOR_COUNTS;
        let shown = (
            self.joint.current(&self.state),
            angle.whole.wrapping_mul(MOTOR_COUNTS).wrapping_add(part),
        );
        let place = (self.periods / HELD) as usize % VOLTAGES.len();
        let volts = VOLTAGES.get(place).copied().unwrap_or_default();
        let load = if self.periods / 1_000 % 2 == 1 { LOAD_NM } else { 0.0 };
        self.joint.step(&mut self.state, self.joint.input(volts, load));
        self.periods = self.periods.wrapping_add(1);
        shown
    }
}
