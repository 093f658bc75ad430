//! Joints side by side: several that differ by their numbers alone, run together in the time of one or
//! two.
//!
//! A search runs thousands of joints that differ by a step in one parameter each, and a filter's design
//! one joint from states a step apart. All of them take the same operations, so they are computed in
//! numbers of several lanes ([`Lanes`]), through the same step as any other number takes, and with the
//! same bits.

mod linear;
mod number;
mod weave;

use std::f64::consts::TAU;

use joint_core::angle::Angle;
use joint_core::effect::{EffectSet, MEMORIES};
use joint_core::joint::{Joint, Mass, StageState, State};
use joint_core::scalar::Scalar;

pub use linear::Linear;
pub(crate) use linear::linear;
pub use number::{LANES, Lanes};

use crate::plant::Layout;

/// The constants of a plant's joints, one for each distinct interval, as they travel.
pub type Constants = Vec<Vec<u8>>;

/// Plants side by side.
pub trait Abreast: Send + Sync {
    /// Advances their states over the interval after sample `k`, as [`crate::plant::Plant::propagate`]
    /// does each.
    fn propagate(&self, k: usize, states: &mut [[f64; LANES]], drive: [f64; LANES], load: f64);
}

/// The constants of joints, to be laid beside those of others.
pub(crate) fn constants<const N: usize>(
    joints: &[Joint<f64, N, EffectSet<f64>>],
) -> Option<Constants> {
    joints.iter().map(weave::constants).collect()
}

/// Joints side by side, by their constants, of which there is one at least and no more than lanes; `None`
/// where they differ by more than their numbers.
pub(crate) fn abreast<const N: usize>(
    constants: &[&Constants],
    serves: &[u32],
) -> Option<Box<dyn Abreast>> {
    Some(Box::new(Built::<N>::new(constants, serves)?))
}

/// Whether joints move smoothly to others, a step away and two.
pub(crate) fn is_smooth<const N: usize>(
    joints: &[Joint<f64, N, EffectSet<f64>>],
    [one, two]: [&Constants; 2],
) -> bool {
    let Some(here) = constants(joints) else { return false };
    here.len() == one.len().min(two.len())
        && here.iter().zip(one).zip(two).all(|((here, one), two)| {
            weave::is_smooth::<Joint<Lanes, N, EffectSet<Lanes>>>([here, one, two])
        })
}

struct Built<const N: usize> {
    joints: Vec<Woven<N>>,
    serves: Vec<u32>,
}

impl<const N: usize> Built<N> {
    fn new(constants: &[&Constants], serves: &[u32]) -> Option<Self> {
        let last = constants.last()?;
        let joints = (0..last.len())
            .map(|j| {
                // Lanes that nobody asked for do as the last one does.
                let lane = |lane: usize| Some(&**constants.get(lane).unwrap_or(last).get(j)?);
                let lanes = (0..LANES).map(lane).collect::<Option<Vec<&[u8]>>>()?;
                weave::woven(lanes).ok().map(Woven::new)
            })
            .collect::<Option<_>>()?;
        Some(Self { joints, serves: serves.to_vec() })
    }

    fn joint(&self, k: usize) -> &Woven<N> {
        &self.joints[self.serves[k.min(self.serves.len() - 1)] as usize]
    }
}

struct Woven<const N: usize> {
    joint: Joint<Lanes, N, EffectSet<Lanes>>,
    /// What one of each is in SI, and one over it.
    current: [Lanes; 2],
    speed: [Lanes; 2],
    angle: [Lanes; 2],
}

impl<const N: usize> Woven<N> {
    fn new(joint: Joint<Lanes, N, EffectSet<Lanes>>) -> Self {
        let mut one = empty();
        one.current = Lanes::ONE;
        one.rotor.speed = Lanes::ONE;
        let [current, speed, angle] =
            [joint.current(&one), joint.speed(&one, 0), joint.angle_unit()]
                .map(|unit| [unit, Lanes::ONE.over(unit)]);
        Self { current, speed, angle, joint }
    }

    fn unpack(&self, flat: &[[f64; LANES]]) -> State<Lanes, N> {
        let layout = Layout { stages: N, memories: 0 };
        let mut state = empty();
        let turns = flat[Layout::ANGLE].map(|angle| angle / TAU);
        // Rounded half away from zero, without a call for every lane.
        let whole = turns.map(|turns| {
            let whole = turns.trunc();
            whole + if (turns - whole).abs() >= 0.5 { 1.0_f64.copysign(turns) } else { 0.0 }
        });
        state.angle =
            Angle { whole: Lanes(whole), part: Lanes(turns) - Lanes(whole), lost: Lanes::ZERO };
        state.current = Lanes(flat[Layout::CURRENT]) * self.current[1];
        let masses = [&mut state.rotor].into_iter();
        let masses = masses.chain(state.stages.iter_mut().map(|stage| &mut stage.mass));
        for (k, mass) in masses.enumerate() {
            mass.speed = Lanes(flat[layout.speed(k)]) * self.speed[1];
            mass.bristle.zeta = Lanes(flat[layout.bristle(k)]);
        }
        for (k, stage) in state.stages.iter_mut().enumerate() {
            stage.deflection = Lanes(flat[layout.deflection(k)]) * self.angle[1];
        }
        for (memory, value) in state.memory.iter_mut().zip(flat.iter().skip(layout.len())) {
            *memory = Lanes(*value);
        }
        self.joint.refresh(&mut state);
        state
    }

    fn pack(&self, state: &State<Lanes, N>, flat: &mut [[f64; LANES]]) {
        let layout = Layout { stages: N, memories: 0 };
        let Angle { whole, part, lost } = state.angle;
        flat[Layout::CURRENT] = (state.current * self.current[0]).0;
        flat[Layout::ANGLE] = ((whole + part - lost) * Lanes::all(TAU)).0;
        let masses = [&state.rotor].into_iter().chain(state.stages.iter().map(|s| &s.mass));
        for (k, mass) in masses.enumerate() {
            flat[layout.speed(k)] = (mass.speed * self.speed[0]).0;
            flat[layout.bristle(k)] = mass.bristle.zeta.0;
        }
        for (k, stage) in state.stages.iter().enumerate() {
            flat[layout.deflection(k)] = (stage.deflection * self.angle[0]).0;
        }
        for (value, memory) in flat.iter_mut().skip(layout.len()).zip(&state.memory) {
            *value = memory.0;
        }
    }

    fn step(&self, state: &mut State<Lanes, N>, drive: [f64; LANES], load: f64) {
        let input = self.joint.input(Lanes(drive), Lanes::all(load));
        self.joint.step(state, input);
    }
}

fn empty<const N: usize>() -> State<Lanes, N> {
    State {
        current: Lanes::ZERO,
        angle: Angle::default(),
        rotor: Mass::default(),
        stages: [StageState::default(); N],
        memory: [Lanes::ZERO; MEMORIES],
    }
}

impl<const N: usize> Abreast for Built<N> {
    fn propagate(&self, k: usize, flat: &mut [[f64; LANES]], drive: [f64; LANES], load: f64) {
        let joint = self.joint(k);
        let mut state = joint.unpack(flat);
        joint.step(&mut state, drive, load);
        joint.pack(&state, flat);
    }
}
