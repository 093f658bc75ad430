//! The joint with its derivatives: with every state, for the filter's design, and with every
//! parameter, for a fit.
//!
//! By differences each derivative costs a run of the joint. Here one run in numbers that carry their
//! derivatives along ([`Dual`]) gives [`LANES`] of them at once, through the same step as any other
//! number takes.

mod dual;
mod linear;
mod weave;

use std::f64::consts::TAU;

use joint_core::angle::Angle;
use joint_core::effect::{EffectSet, MEMORIES};
use joint_core::joint::{Joint, Mass, StageState, State};
use joint_core::scalar::Scalar;

pub use dual::{Dual, LANES, Slopes};
pub use linear::Linear;
pub(crate) use linear::linear;

use crate::plant::Layout;

/// The constants of a plant's joints, one for each distinct interval, as they travel.
pub type Constants = Vec<Vec<u8>>;

/// A plant whose constants have derivatives.
pub trait Tangent<const L: usize = LANES>: Send + Sync {
    /// Advances a state over the interval after sample `k`, as [`crate::plant::Plant::propagate`],
    /// and its derivatives with it.
    fn propagate(&self, k: usize, state: &mut [Dual<L>], drive: Dual<L>, load: f64);
}

/// The constants of joints, to be laid beside those of others.
pub(crate) fn constants<const N: usize>(
    joints: &[Joint<f64, N, EffectSet<f64>>],
) -> Option<Constants> {
    joints.iter().map(weave::constants).collect()
}

/// Joints with the derivatives that others show, each a step apart; `None` where they differ by more
/// than their numbers.
pub(crate) fn tangent<const N: usize>(
    joints: &[Joint<f64, N, EffectSet<f64>>],
    serves: &[u32],
    apart: &[(&Constants, f64)],
) -> Option<Box<dyn Tangent>> {
    Some(Box::new(built::<N, LANES>(joints, serves, apart)?))
}

fn built<const N: usize, const L: usize>(
    joints: &[Joint<f64, N, EffectSet<f64>>],
    serves: &[u32],
    apart: &[(&Constants, f64)],
) -> Option<Built<N, L>> {
    let joints = constants(joints)?
        .iter()
        .enumerate()
        .map(|(j, base)| {
            let others = apart.iter().map(|(other, step)| Some((&**other.get(j)?, 1.0 / step)));
            let others: Vec<_> = others.collect::<Option<_>>()?;
            weave::woven(base, &others).ok().map(Woven::new)
        })
        .collect::<Option<Vec<Woven<N, L>>>>()?;
    Some(Built { joints, serves: serves.to_vec() })
}

/// Whether joints move smoothly to others, a step away and two.
pub(crate) fn is_smooth<const N: usize>(
    joints: &[Joint<f64, N, EffectSet<f64>>],
    [one, two]: [&Constants; 2],
) -> bool {
    let Some(here) = constants(joints) else { return false };
    here.len() == one.len().min(two.len())
        && here.iter().zip(one).zip(two).all(|((here, one), two)| {
            weave::is_smooth::<Joint<Dual, N, EffectSet<Dual>>>(here, one, two)
        })
}

struct Built<const N: usize, const L: usize> {
    joints: Vec<Woven<N, L>>,
    serves: Vec<u32>,
}

struct Woven<const N: usize, const L: usize> {
    joint: Joint<Dual<L>, N, EffectSet<Dual<L>>>,
    /// What one of each is in SI.
    current: Dual<L>,
    speed: Dual<L>,
    angle: Dual<L>,
}

impl<const N: usize, const L: usize> Woven<N, L> {
    fn new(joint: Joint<Dual<L>, N, EffectSet<Dual<L>>>) -> Self {
        let mut one = empty();
        one.current = Dual::ONE;
        one.rotor.speed = Dual::ONE;
        let [current, speed] = [joint.current(&one), joint.speed(&one, 0)];
        Self { current, speed, angle: joint.angle_unit(), joint }
    }

    fn unpack(&self, flat: &[Dual<L>]) -> State<Dual<L>, N> {
        let layout = Layout { stages: N, memories: 0 };
        let mut state = empty();
        let [per_current, per_speed, per_angle] =
            [self.current, self.speed, self.angle].map(|unit| Dual::ONE.over(unit));
        let turns = flat[Layout::ANGLE] * Dual::constant(1.0 / TAU);
        state.angle = Angle::from_turns(turns.value);
        state.angle.part.slopes = turns.slopes;
        state.current = flat[Layout::CURRENT] * per_current;
        let masses = [&mut state.rotor].into_iter();
        let masses = masses.chain(state.stages.iter_mut().map(|stage| &mut stage.mass));
        for (k, mass) in masses.enumerate() {
            mass.speed = flat[layout.speed(k)] * per_speed;
            mass.bristle.zeta = flat[layout.bristle(k)];
        }
        for (k, stage) in state.stages.iter_mut().enumerate() {
            stage.deflection = flat[layout.deflection(k)] * per_angle;
        }
        for (memory, value) in state.memory.iter_mut().zip(flat.iter().skip(layout.len())) {
            *memory = *value;
        }
        self.joint.refresh(&mut state);
        state
    }

    fn pack(&self, state: &State<Dual<L>, N>, flat: &mut [Dual<L>]) {
        let layout = Layout { stages: N, memories: 0 };
        flat[Layout::CURRENT] = state.current * self.current;
        flat[Layout::ANGLE] = state.angle.part * Dual::constant(TAU);
        flat[Layout::ANGLE].value = state.angle.to_turns() * TAU;
        let masses = [&state.rotor].into_iter().chain(state.stages.iter().map(|s| &s.mass));
        for (k, mass) in masses.enumerate() {
            flat[layout.speed(k)] = mass.speed * self.speed;
            flat[layout.bristle(k)] = mass.bristle.zeta;
        }
        for (k, stage) in state.stages.iter().enumerate() {
            flat[layout.deflection(k)] = stage.deflection * self.angle;
        }
        for (value, memory) in flat.iter_mut().skip(layout.len()).zip(&state.memory) {
            *value = *memory;
        }
    }
}

fn empty<const N: usize, const L: usize>() -> State<Dual<L>, N> {
    State {
        current: Dual::ZERO,
        angle: Angle::default(),
        rotor: Mass::default(),
        stages: [StageState::default(); N],
        memory: [Dual::ZERO; MEMORIES],
    }
}

impl<const N: usize, const L: usize> Tangent<L> for Built<N, L> {
    fn propagate(&self, k: usize, flat: &mut [Dual<L>], drive: Dual<L>, load: f64) {
        let woven = &self.joints[self.serves[k.min(self.serves.len() - 1)] as usize];
        let mut state = woven.unpack(flat);
        let input = woven.joint.input(drive, Dual::constant(load));
        woven.joint.step(&mut state, input);
        woven.pack(&state, flat);
    }
}
