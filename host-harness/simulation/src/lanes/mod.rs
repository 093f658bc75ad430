//! Joints side by side: several that differ by their numbers alone, run together in the time of one or
//! two.
//!
//! A search runs thousands of joints that differ by a step in one parameter each, and a filter's design
//! one joint from states a step apart. All of them take the same operations, so they are computed in
//! numbers of several lanes ([`Lanes`]), through the same step as any other number takes, and with the
//! same bits.

mod alike;
mod linear;
mod number;

use std::any::Any;
use std::f64::consts::TAU;

use joint_core::angle::Angle;
use joint_core::effect::{EffectSet, MEMORIES};
use joint_core::joint::{Joint, Mass, StageState, State};
use joint_core::number::Number;
use joint_core::work::Work;

pub use linear::Linear;
pub use linear::linear;
pub use number::{LANES, Lanes};

use alike::{Alike, Plain};

use crate::layout::Layout;
use crate::wide;

/// The constants of a plant's joints, one for each distinct interval.
pub struct Constants(Box<dyn Any + Send + Sync>);

/// Joints in plain numbers.
type Joints<const N: usize> = Vec<Plain<N>>;

/// Plants side by side.
pub trait Abreast: Send + Sync {
    /// Advances their states over the interval after sample `k`, as
    /// [`crate::plant::Plant::propagate_switched`] does each.
    fn propagate(&self, k: usize, states: &mut [Lanes], drives: [Lanes; 2], load: f64);
}

/// The constants of joints, to be laid beside those of others.
pub fn constants<const N: usize>(joints: &Joints<N>) -> Constants {
    Constants(Box::new(joints.clone()))
}

/// Joints side by side, by their constants, of which there is one at least and no more than lanes; `None`
/// where they differ by more than their numbers.
pub fn abreast<const N: usize>(
    constants: &[&Constants],
    serves: &[u32],
    switched: bool,
) -> Option<Box<dyn Abreast>> {
    let joints: Vec<&Joints<N>> =
        constants.iter().map(|own| own.0.downcast_ref()).collect::<Option<_>>()?;
    Some(Box::new(Built::new(&joints, serves, switched)?))
}

/// Whether joints move smoothly to others, a step away and two.
pub fn is_smooth<const N: usize>(joints: &Joints<N>, [one, two]: [&Constants; 2]) -> bool {
    let [Some(one), Some(two)] = [one, two].map(|own| own.0.downcast_ref::<Joints<N>>()) else {
        return false;
    };
    joints.len() == one.len().min(two.len())
        && joints.iter().zip(one).zip(two).all(|((here, one), two)| {
            Alike::of([here, one, two]).is_some_and(|alike| alike.moves_smoothly())
        })
}

struct Built<const N: usize> {
    joints: Vec<Woven<N>>,
    serves: Vec<u32>,
    /// Whether an interval has two parts, each with a joint of its own.
    switched: bool,
}

impl<const N: usize> Built<N> {
    /// Of the joints of each plant; lanes that nobody asked for do as the last plant does.
    fn new(plants: &[&Joints<N>], serves: &[u32], switched: bool) -> Option<Self> {
        let last = plants.last()?;
        let joints = (0..last.len())
            .map(|j| {
                let own = |lane: usize| plants.get(lane).unwrap_or(last).get(j);
                let own = (0..LANES).map(own).collect::<Option<Vec<_>>>()?;
                let lanes: [_; LANES] = own.try_into().ok()?;
                Some(Woven::new(Alike::of(lanes)?.side_by_side()))
            })
            .collect::<Option<_>>()?;
        Some(Self { joints, serves: serves.to_vec(), switched })
    }

    /// The joints of the parts of the interval after sample `k`, each with its drive of those before and
    /// after the switch.
    #[inline(always)]
    fn parts<D>(&self, k: usize, drives: [D; 2]) -> impl Iterator<Item = (&Woven<N>, D)> {
        let parts = 1 + usize::from(self.switched);
        let first = parts * self.serves[k.min(self.serves.len() - 1)] as usize;
        self.joints[first..first + parts].iter().zip(drives.into_iter().skip(2 - parts))
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

    /// Fills in a state that is [`empty`].
    #[inline(always)]
    fn unpack(&self, flat: &[Lanes], state: &mut State<Lanes, N>) {
        let layout = Layout { stages: N, memories: 0 };
        let turns = flat[Layout::ANGLE].over(Lanes::all(TAU));
        // Rounded half away from zero, without a call for every lane.
        let whole = Lanes(turns.0.map(|turns| {
            let whole = turns.trunc();
            whole + if (turns - whole).abs() >= 0.5 { 1.0_f64.copysign(turns) } else { 0.0 }
        }));
        state.angle = Angle { whole, part: turns - whole, lost: Lanes::ZERO };
        state.current = flat[Layout::CURRENT] * self.current[1];
        let masses = [&mut state.rotor].into_iter();
        let masses = masses.chain(state.stages.iter_mut().map(|stage| &mut stage.mass));
        for (k, mass) in masses.enumerate() {
            mass.speed = flat[layout.speed(k)] * self.speed[1];
            mass.bristle.zeta = flat[layout.bristle(k)];
        }
        for (k, stage) in state.stages.iter_mut().enumerate() {
            stage.deflection = flat[layout.deflection(k)] * self.angle[1];
        }
        for (memory, value) in state.memory.iter_mut().zip(flat.iter().skip(layout.len())) {
            *memory = *value;
        }
    }

    #[inline(always)]
    fn pack(&self, state: &State<Lanes, N>, flat: &mut [Lanes]) {
        let layout = Layout { stages: N, memories: 0 };
        let Angle { whole, part, lost } = state.angle;
        flat[Layout::CURRENT] = state.current * self.current[0];
        flat[Layout::ANGLE] = (whole + part - lost) * Lanes::all(TAU);
        let masses = [&state.rotor].into_iter().chain(state.stages.iter().map(|s| &s.mass));
        for (k, mass) in masses.enumerate() {
            flat[layout.speed(k)] = mass.speed * self.speed[0];
            flat[layout.bristle(k)] = mass.bristle.zeta;
        }
        for (k, stage) in state.stages.iter().enumerate() {
            flat[layout.deflection(k)] = stage.deflection * self.angle[0];
        }
        for (value, memory) in flat.iter_mut().skip(layout.len()).zip(&state.memory) {
            *value = *memory;
        }
    }

    /// Advances states, and answers with the rotor's angles to the last digit.
    #[inline(always)]
    fn step(&self, flat: &mut [Lanes], drive: Lanes, load: f64) -> Angle<Lanes> {
        let mut state = empty();
        self.unpack(flat, &mut state);
        self.joint.refresh(&mut state);
        self.joint.step(&mut state, self.joint.input(drive, Lanes::all(load)));
        self.pack(&state, flat);
        state.angle
    }
}

#[inline(always)]
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
    fn propagate(&self, k: usize, states: &mut [Lanes], drives: [Lanes; 2], load: f64) {
        for (joint, drive) in self.parts(k, drives) {
            wide::run(Advance { joint, states: &mut *states, drive, load });
        }
    }
}

/// One step of joints side by side.
struct Advance<'a, const N: usize> {
    joint: &'a Woven<N>,
    states: &'a mut [Lanes],
    drive: Lanes,
    load: f64,
}

impl<const N: usize> Work for Advance<'_, N> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.joint.step(self.states, self.drive, self.load);
    }
}
