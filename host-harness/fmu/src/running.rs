//! The joint while it runs, whatever its number of stages.

use std::f64::consts::TAU;

use joint_core::angle::Angle;
use joint_core::effect::EffectSet;
use joint_core::joint::{Drive, Joint as Core, Settings, State};
use joint_core::params::Stage;
use joint_core::per_unit::Bases;

use crate::joint::{Joint, JointError};

/// Most stages.
const MAX_STAGES: usize = 6;

/// A joint with its state.
pub(crate) trait Running {
    /// One step with held inputs, V or A and Nm; false where the result is no number.
    fn step(&mut self, drive: f64, load: f64) -> bool;
    /// The outputs, in the order of [`Joint::outputs`].
    fn outputs(&self, into: &mut Vec<f64>);
    /// The same joint in the same state.
    fn copy(&self) -> Box<dyn Running>;
    /// The state as bytes.
    fn state(&self) -> Result<Vec<u8>, JointError>;
    /// Back to a state from its bytes.
    fn set_state(&mut self, bytes: &[u8]) -> Result<(), JointError>;
}

/// Where the joint is when it starts, every spring relaxed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Start {
    pub(crate) motor_angle_rad: f64,
    pub(crate) motor_speed_rad_per_s: f64,
}

/// The joint at its start.
pub(crate) fn started(joint: &Joint, start: Start) -> Result<Box<dyn Running>, JointError> {
    match joint.stage.len() {
        0 => built::<0>(joint, start),
        1 => built::<1>(joint, start),
        2 => built::<2>(joint, start),
        3 => built::<3>(joint, start),
        4 => built::<4>(joint, start),
        5 => built::<5>(joint, start),
        6 => built::<6>(joint, start),
        more => Err(JointError(format!("{more} stages; at most {MAX_STAGES} are supported"))),
    }
}

#[derive(Clone)]
struct Built<const N: usize> {
    joint: Core<f64, N, EffectSet<f64>>,
    state: State<f64, N>,
    /// From the motor to each mass.
    shafts: [f64; N],
}

fn built<const N: usize>(joint: &Joint, start: Start) -> Result<Box<dyn Running>, JointError> {
    let wrong = |error: &dyn std::fmt::Display| JointError(error.to_string());
    let stages: &[Stage; N] = joint.stage.as_slice().try_into().map_err(|error| wrong(&error))?;
    let effects = joint.effects()?;
    let settings =
        Settings { effects: &effects, ..Settings::new(Drive::from(joint.input), joint.period_s) };
    let core = Core::<f64, N, EffectSet<f64>>::new(&joint.motor, stages, &joint.load, &settings)
        .map_err(|error| wrong(&error))?;
    let bases = Bases::si(&joint.motor, stages);
    let shafts = std::array::from_fn(|k| bases.shaft(k + 1));
    let mut state = core.rest();
    state.angle = Angle::from_turns(start.motor_angle_rad / TAU);
    for mass in 0..=N {
        // As they are felt at the motor, all speeds are the rotor's; in motion bristles are stretched.
        core.set_speed(&mut state, mass, start.motor_speed_rad_per_s);
        let moves = start.motor_speed_rad_per_s != 0.0;
        let bristle = if moves { start.motor_speed_rad_per_s.signum() } else { 0.0 };
        core.set_bristle(&mut state, mass, bristle);
    }
    core.refresh(&mut state);
    Ok(Box::new(Built { state, joint: core, shafts }))
}

impl<const N: usize> Running for Built<N> {
    fn step(&mut self, drive: f64, load: f64) -> bool {
        let (joint, state) = (&self.joint, &mut self.state);
        if joint.is_current_imposed() {
            joint.set_current(state, joint.imposed_current(drive));
        }
        joint.step(state, joint.input(drive, load));
        joint.saturated(state) == 0
    }

    fn outputs(&self, into: &mut Vec<f64>) {
        let (joint, state) = (&self.joint, &self.state);
        let angle = state.angle.to_turns() * TAU;
        let speed = joint.speed_rad_per_s(state, 0);
        into.clear();
        into.extend([joint.current_a(state), joint.measured_current_a(state)]);
        into.extend([angle, speed, joint.bristle(state, 0), angle, speed]);
        let torques = joint.torques(state);
        into.extend([torques.motor, torques.motor_friction]);
        let mut wound = 0.0;
        for (k, shaft) in self.shafts.iter().enumerate() {
            let deflection = joint.deflection_rad(state, k);
            wound += deflection;
            let behind = (angle - wound) * shaft;
            let speed = joint.speed_rad_per_s(state, k + 1) * shaft;
            let bristle = joint.bristle(state, k + 1) * shaft.signum();
            // What is behind the last stage is the output.
            if let Some(output) = into.get_mut(5..7) {
                output.copy_from_slice(&[behind, speed]);
            }
            into.extend([behind, speed, deflection * shaft, bristle]);
            // At the mass's own side.
            into.extend([torques.stages[k] / shaft, torques.stage_friction[k] / shaft]);
        }
    }

    fn copy(&self) -> Box<dyn Running> {
        Box::new(self.clone())
    }

    fn state(&self) -> Result<Vec<u8>, JointError> {
        postcard::to_stdvec(&self.state).map_err(|error| JointError(error.to_string()))
    }

    fn set_state(&mut self, bytes: &[u8]) -> Result<(), JointError> {
        let unreadable = |error| JointError(format!("these bytes are no state of it: {error}"));
        self.state = postcard::from_bytes(bytes).map_err(unreadable)?;
        Ok(())
    }
}
