//! The loop that the host and the chip both run over a log.
//!
//! It is generic over nothing but the number of stages: one f32 joint with the effects that its
//! parameter block names. What the chip computes is trusted because this same code, compiled for
//! the host, gives the same bits.

use joint_core::effect::EffectSet;
use joint_core::joint::{Input, Joint, State};

use crate::samples::Sample;

/// The joint that is replayed.
pub type ReplayedJoint<const N: usize> = Joint<f32, N, EffectSet<f32>>;

/// Numbers in a row of states of a joint with that many stages.
pub const fn row_numbers(stages: usize) -> usize {
    5 + 3 * stages
}

/// Steps the joint once for each sample and hands over the states after it, per-unit: current,
/// whole turns, part of a turn, rotor speed, rotor bristle; then deflection, speed and bristle of
/// every stage.
///
/// # Errors
/// The first that `put` returns.
pub fn steps<const N: usize, Error>(
    joint: &ReplayedJoint<N>,
    state: &mut State<f32, N>,
    samples: impl Iterator<Item = Sample>,
    put: impl FnMut(f32) -> Result<(), Error>,
) -> Result<(), Error> {
    steps_by(joint, state, samples, |joint, state, input| joint.step(state, input), put)
}

/// The same with a step that may be watched.
///
/// # Errors
/// The first that `put` returns.
pub fn steps_by<const N: usize, Error>(
    joint: &ReplayedJoint<N>,
    state: &mut State<f32, N>,
    samples: impl Iterator<Item = Sample>,
    mut step: impl FnMut(&ReplayedJoint<N>, &mut State<f32, N>, Input<f32>),
    mut put: impl FnMut(f32) -> Result<(), Error>,
) -> Result<(), Error> {
    for sample in samples {
        step(joint, state, joint.input(sample.input, sample.load));
        // Whole turns are exact in f32 up to 2^24.
        put(state.current)?;
        put(state.angle.whole as f32)?;
        put(state.angle.part)?;
        put(state.rotor.speed)?;
        put(state.rotor.bristle.zeta)?;
        for stage in &state.stages {
            put(stage.deflection)?;
            put(stage.mass.speed)?;
            put(stage.mass.bristle.zeta)?;
        }
    }
    Ok(())
}
