//! What the host designs and the drive only uses.
//!
//! A steady-state filter corrects by constants. They are designed in SI, where a person can read
//! them ([`Design`]), and turned once into the joint's own units ([`Gains`]), which travel in the
//! parameter block.

use crate::observer::column::{CHANNELS, Column, StageRow, summed};
use crate::observer::turn::Geared;
use crate::params::{Motor, Stage};
use crate::per_unit::Bases;
use crate::scalar::Scalar;
use crate::settings::Drive;

/// Sets of gains: one for each [`Regime`], without and with an output encoder.
pub const SETS: usize = 4 * Regime::COUNT;

/// What the joint is doing, as far as gains and standard deviations depend on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Regime {
    /// It moves and the innovations are what noise makes them.
    #[default]
    Steady,
    /// The innovations' running mean has left its noise: the load has changed.
    Transient,
    /// The load has kept changing for some time.
    Varying,
    /// The rotor is held by its own friction; what lies beyond is seen by an output encoder only.
    Held,
}

impl Regime {
    /// How many there are.
    pub const COUNT: usize = 4;

    /// Whether a row is one with an output encoder.
    pub const fn has_output(row: usize) -> bool {
        (row / Self::COUNT) % 2 == 1
    }

    /// The number of the regime that a row is of.
    #[inline(always)]
    pub(crate) const fn of_row(row: u8) -> usize {
        row as usize % Self::COUNT
    }

    /// The set of gains, or row of standard deviations, that belongs to it.
    #[inline(always)]
    pub const fn row(self, output: bool, hardened: bool) -> usize {
        self.row_of(output as usize, hardened)
    }

    /// The same for the place of the sensors' constants.
    #[inline(always)]
    pub(crate) const fn row_of(self, sensors: usize, hardened: bool) -> usize {
        self as usize + Self::COUNT * sensors + 2 * Self::COUNT * hardened as usize
    }
}

/// Place of constants that go with an output encoder, after those that go with none: a place takes fewer
/// instructions than a choice.
pub(crate) const WITH_OUTPUT: usize = 1;

/// The constants of sensors that are in use, by their place.
#[inline(always)]
pub(crate) fn of_sensors<T>(constants: &[T; 2], sensors: usize) -> &T {
    let [without, _] = constants;
    constants.get(sensors).unwrap_or(without)
}

/// One standard deviation of everything that is estimated, each at its own side.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = "G: crate::number::Wire"))]
pub struct Spread<G, const N: usize> {
    /// Rotor speed, rad/s.
    pub motor_velocity: G,
    /// Friction torque of the whole joint at the motor, Nm.
    pub total_friction: G,
    /// Wind-up of every stage, rad.
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    pub windup: [G; N],
    /// Output angle, rad.
    pub output_angle: G,
    /// Output speed, rad/s.
    pub output_velocity: G,
    /// Load torque, Nm.
    pub load: G,
}

impl<G: Copy, const N: usize> Spread<G, N> {
    /// The same value for everything.
    pub fn filled(value: G) -> Self {
        Self {
            motor_velocity: value,
            total_friction: value,
            windup: [value; N],
            output_angle: value,
            output_velocity: value,
            load: value,
        }
    }
}

/// How friction's level is learned: the share by which all friction exceeds the model's.
///
/// From the motor alone, friction and load are one torque, but friction turns round with the speed
/// and a load does not: what is left of friction's change beside its own running mean, times the
/// innovations that a torque on the rotor makes, tells one from the other. Where the speed keeps its
/// sign the level is unobservable, and stays as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level<const N: usize> {
    /// What friction takes of the rotor's speed in a step, reflected to the motor: rad/s where its
    /// bristle slips, and the share for its viscous part.
    pub rotor: [f64; 2],
    /// The same of every mass behind a stage.
    pub stages: [[f64; 2]; N],
    /// Share by which the running mean of the rotor's follows it, without and with an output encoder.
    pub smoothing: [f64; 2],
    /// Weights that make of the innovations of rotor and output angle one number of variance one
    /// in the direction of a torque on the rotor, without and with an output encoder.
    pub projection: [[f64; 2]; 2],
    /// Change of the level for such a number of one, where friction takes 1 rad/s more than in the
    /// mean, s/rad; without and with an output encoder.
    pub gain: [f64; 2],
    /// How many standard deviations of that number count: more is a load that jumps.
    pub most_projection: f64,
    /// Largest deviation believed, as a share of the model's.
    pub most: f64,
}

impl<const N: usize> Level<N> {
    /// Never learns.
    pub const NONE: Self = Self {
        rotor: [0.0; 2],
        stages: [[0.0; 2]; N],
        smoothing: [0.0; 2],
        projection: [[0.0; 2]; 2],
        gain: [0.0; 2],
        most_projection: 0.0,
        most: 0.0,
    };
}

/// A designed observer in SI: gains are corrections for one standard deviation of an innovation.
#[derive(Clone, Debug, PartialEq)]
pub struct Design<const N: usize> {
    /// By [`Regime::row`] and channel.
    pub sets: [[Column<f64, N>; CHANNELS]; SETS],
    /// Change of the resistance, as a share of the model's, for one standard deviation of the
    /// current's innovation at a current of one ampere, A⁻¹.
    pub ohm: f64,
    /// Change of the flux, as a share of the model's, for the same at a speed of one rad/s, s/rad.
    pub flux: f64,
    /// Friction's level, as [`Level`] says.
    pub level: Level<N>,
    /// Standard deviations that a current may be off before the drive is taken to have put out
    /// another voltage.
    pub outlier: f64,
    /// What a current of one ampere makes of the rotor's speed in a step, rad/s.
    pub push: f64,
    /// Samples of motion after which winding and magnets are taken to be known, so that an
    /// outlier is no error of theirs.
    pub confirmed: u16,
    /// Wind-up of the last stage from which the gains are those of a hardened spring, rad.
    pub hardened: f64,
    /// One standard deviation of the innovations: A, rad of the rotor, rad of the output.
    pub sigma: [f64; CHANNELS],
    /// How many of them a measurement may be off before it is taken for a glitch.
    pub gate: f64,
    /// Share of the load's slope that is left after a step, by regime.
    pub leak: [f64; Regime::COUNT],
    /// Weights that make of the innovations one number of variance one in the direction of the load,
    /// without and with an output encoder.
    pub projection: [[f64; CHANNELS]; 2],
    /// Share by which the running mean of that number follows it.
    pub smoothing: f64,
    /// From how large a mean on the load has changed.
    pub alarm: f64,
    /// How many steps it is then taken to be changing.
    pub hold: u16,
    /// Share by which the running mean of alarms follows them.
    pub alarm_rate: f64,
    /// From which share of alarms on the load is varying, and for how many steps.
    pub varying: (f64, u16),
    /// Steps after which a start is forgotten, and over which innovations are judged.
    pub settled: u16,
    /// Mean of the sum of squared innovations, in standard deviations, from which on they are too
    /// large for the design; one sample counts four times that at most.
    pub inconsistent: f64,
    /// Largest load believed, Nm.
    pub most_load_nm: f64,
    /// Largest drive believed to be missing, V or A.
    pub most_bias: f64,
    /// Largest deviation of the resistance believed, as a share of the model's.
    pub most_ohm: f64,
    /// The same of the flux.
    pub most_flux: f64,
    /// Where the current sensor ends, A; infinite where it does not.
    pub most_current_a: f64,
    /// Standard deviations by [`Regime::row`].
    pub spread: [Spread<f64, N>; SETS],
    /// How much of the friction of bristles that are turning round is one standard deviation more of
    /// friction, without and with an output encoder.
    pub turning: [f64; 2],
}

/// Numbers that scale one channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub(crate) struct Whiten<S: Scalar> {
    /// One over so many standard deviations of the innovation, per-unit or in turns.
    pub(crate) per_sigma: S::Gain,
    /// The largest innovation believed, in the same unit.
    pub(crate) gate: S,
}

/// What friction takes of a mass's speed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub(crate) struct Deceleration<S: Scalar> {
    /// In [`TURNS`] steps: for ζ of one,
    pub(crate) bristle: S::Gain,
    /// and for a speed of one.
    pub(crate) viscous: S::Gain,
}

/// A designed observer in the units of its joint.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct Gains<S: Scalar, const N: usize> {
    pub(crate) sets: [[Column<S::Gain, N>; CHANNELS]; SETS],
    pub(crate) ohm: S::Gain,
    pub(crate) flux: S::Gain,
    pub(crate) deceleration: Deceleration<S>,
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    pub(crate) decelerations: [Deceleration<S>; N],
    pub(crate) mean_deceleration: [S::Gain; 2],
    pub(crate) friction_projection: [[S::Gain; 2]; 2],
    pub(crate) level: [S::Gain; 2],
    pub(crate) most_friction_projection: S,
    pub(crate) most_level: S,
    pub(crate) outlier: S,
    pub(crate) confirmed: u16,
    pub(crate) most_confirmed: u16,
    /// Drive that is missing where one step, or two, left the current off by one,
    pub(crate) missing: [S::Gain; 2],
    /// and what that current has made of the rotor's speed.
    pub(crate) push: [S::Gain; 2],
    /// Share of the final current in the mean of a step, beside the starting one.
    pub(crate) winding: S::Gain,
    pub(crate) hardened: S,
    pub(crate) whiten: [Whiten<S>; CHANNELS],
    pub(crate) leak: [S::Gain; Regime::COUNT],
    pub(crate) projection: [[S::Gain; CHANNELS]; 2],
    pub(crate) smoothing: S::Gain,
    pub(crate) alarm: S,
    pub(crate) hold: u16,
    pub(crate) alarm_rate: S::Gain,
    pub(crate) varying: (S, u16),
    pub(crate) settled: u16,
    pub(crate) settle: S::Gain,
    pub(crate) inconsistent: S,
    pub(crate) most_mean_square: S,
    pub(crate) most_load: S,
    pub(crate) most_bias: S,
    pub(crate) most_ohm: S,
    pub(crate) most_flux: S,
    pub(crate) most_current: S,
    pub(crate) most_drive: S,
    pub(crate) most_speed: S,
    /// Per-unit current of an ampere.
    pub(crate) per_ampere: S::Gain,
    /// Per-unit speed of a turn in a step.
    pub(crate) per_turn: S::Gain,
    /// The output's turns in a turn of the rotor.
    pub(crate) shaft: S::Gain,
    pub(crate) geared: Geared,
    /// SI of one per-unit: output speed, load, and each wind-up.
    pub(crate) output_speed: S::Gain,
    pub(crate) load: S::Gain,
    /// Radians of a turn.
    pub(crate) turn: S::Gain,
    /// Volts (amperes where the current is imposed) of one per-unit of drive.
    pub(crate) drive: S::Gain,
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    pub(crate) windup: [S::Gain; N],
    pub(crate) spread: [Spread<S, N>; SETS],
    pub(crate) turning: [S; 2],
}

impl<S: Scalar, const N: usize> Gains<S, N> {
    /// In the units of a joint of these parameters that takes steps of `step_s` seconds.
    pub fn new(
        design: &Design<N>,
        motor: &Motor,
        stages: &[Stage; N],
        drive: Drive,
        step_s: f64,
    ) -> Self {
        let turn = core::f64::consts::TAU;
        let units = Bases::of(motor, stages, step_s);
        let shaft = units.shaft(N);
        let winding = winding(motor, step_s);
        let drive = match drive {
            Drive::Voltage => units.resistance * units.current,
            Drive::Current => units.current,
        };
        let mut stage = 0;
        let windup = [(); N].map(|()| {
            stage += 1;
            S::gain(units.shaft(stage) * units.angle)
        });
        let [current, rotor, output] = design.sigma;
        let own = [current / units.current, rotor / turn, output / turn];
        let sigma = own.map(|sigma| sigma.max(LEAST_SIGMA));
        let mut many = [SIGMAS; CHANNELS];
        for ((many, sigma), own) in many.iter_mut().zip(sigma).zip(own) {
            *many *= sigma / own;
        }
        let column = |c: &Column<f64, N>, many: f64| Column {
            current: many * c.current / units.current,
            angle: many * c.angle / turn,
            speed: many * c.speed / units.speed,
            stages: c.stages.map(|row| StageRow {
                deflection: many * row.deflection / units.angle,
                speed: many * row.speed / units.speed,
            }),
            load: many * c.load * shaft / units.torque,
            slope: many * c.slope * shaft / units.torque,
            bias: many * c.bias / drive,
        };
        let set = |[current, motor, output]: &[Column<f64, N>; CHANNELS]| {
            let [a, b, c] = many;
            summed::<S, N>(&[column(current, a), column(motor, b), column(output, c)])
        };
        let projection = |[current, motor, output]: [f64; CHANNELS]| {
            let [a, b, c] = many;
            S::gains([a * current, b * motor, c * output])
        };
        let [by_current, by_motor, by_output] = many;
        let deceleration = |[bristle, viscous]: [f64; 2]| {
            let [bristle, viscous] = S::gains([TURNS * bristle / units.speed, TURNS * viscous]);
            Deceleration { bristle, viscous }
        };
        let level = &design.level;
        let friction_projection = |[motor, output]: [f64; 2]| {
            S::gains([by_motor * motor / SIGMAS, by_output * output / SIGMAS])
        };
        let [outlier, ..] = sigma;
        let outlier = (design.outlier.min(design.gate) * outlier).min(MOST_INNOVATION);
        let whiten = sigma.map(|sigma| Whiten {
            per_sigma: S::gain(1.0 / (SIGMAS * sigma)),
            gate: S::from_f64((design.gate * sigma).min(MOST_INNOVATION)),
        });
        let reflected = |windup: [f64; N]| {
            let mut stage = 0;
            windup.map(|own| {
                stage += 1;
                S::from_f64(own / libm::fabs(units.shaft(stage) * units.angle))
            })
        };
        let spread = |s: &Spread<f64, N>| Spread {
            motor_velocity: S::from_f64(s.motor_velocity / units.speed),
            total_friction: S::from_f64(s.total_friction / units.torque),
            windup: reflected(s.windup),
            output_angle: S::from_f64((s.output_angle / turn).min(MOST_INNOVATION)),
            output_velocity: S::from_f64(s.output_velocity / (libm::fabs(shaft) * units.speed)),
            load: S::from_f64(s.load * libm::fabs(shaft) / units.torque),
        };
        Self {
            sets: design.sets.each_ref().map(set),
            ohm: S::gain(TURNS * by_current * design.ohm * units.current),
            flux: S::gain(TURNS * by_current * design.flux * units.speed),
            deceleration: deceleration(level.rotor),
            decelerations: level.stages.map(deceleration),
            mean_deceleration: level
                .smoothing
                .map(|share| S::gain(1.0 - (1.0 - share) * (1.0 - share))),
            friction_projection: level.projection.map(friction_projection),
            level: level.gain.map(|gain| S::gain(SIGMAS * gain * units.speed)),
            most_friction_projection: S::from_f64(level.most_projection / SIGMAS),
            most_level: S::from_f64(level.most),
            outlier: S::from_f64(outlier),
            confirmed: design.confirmed / TURNS as u16,
            most_confirmed: 2 * (design.confirmed / TURNS as u16),
            missing: [1.0, 2.0].map(|steps| S::gain(1.0 / reached(motor, step_s, steps))),
            push: [1.0, 2.0].map(|steps| {
                let mean =
                    steps * winding_over(motor, step_s, steps) / reached(motor, step_s, steps);
                S::gain(design.push * mean * units.current / units.speed)
            }),
            winding: S::gain(winding),
            hardened: S::from_f64((design.hardened / units.angle_at(N)).abs().min(LARGE)),
            whiten,
            leak: design.leak.map(S::gain),
            projection: design.projection.map(projection),
            smoothing: S::gain(design.smoothing),
            alarm: S::from_f64(design.alarm),
            hold: design.hold,
            alarm_rate: S::gain(design.alarm_rate),
            varying: (S::from_f64(design.varying.0), design.varying.1),
            settled: design.settled,
            settle: S::gain(1.0 / f64::from(design.settled.max(2))),
            inconsistent: S::from_f64(design.inconsistent / (SIGMAS * SIGMAS)),
            most_mean_square: S::from_f64(4.0 * design.inconsistent / (SIGMAS * SIGMAS)),
            most_load: S::from_f64(design.most_load_nm * libm::fabs(shaft) / units.torque),
            most_bias: S::from_f64(design.most_bias / drive),
            most_ohm: S::from_f64(design.most_ohm),
            most_flux: S::from_f64(design.most_flux),
            most_current: S::from_f64((design.most_current_a / units.current).min(LARGE)),
            most_drive: S::from_f64(LARGE),
            most_speed: S::from_f64(LARGE),
            per_ampere: S::gain(1.0 / units.current),
            per_turn: S::gain(turn / (units.speed * step_s)),
            shaft: S::gain(shaft),
            geared: Geared::new(shaft),
            output_speed: S::gain(shaft * units.speed),
            load: S::gain(units.torque / shaft),
            turn: S::gain(turn),
            drive: S::gain(drive),
            windup,
            spread: design.spread.each_ref().map(spread),
            turning: design.turning.map(S::from_f64),
        }
    }
}

/// Share of its final value in the mean current of a step that begins at another.
pub fn winding(motor: &Motor, step_s: f64) -> f64 {
    winding_over(motor, step_s, 1.0)
}

/// The same over so many steps.
fn winding_over(motor: &Motor, step_s: f64, steps: f64) -> f64 {
    let lag = motor.phase_inductance_h / motor.phase_resistance_ohm;
    // Without resistance the current has no final value.
    if lag.is_finite() { 1.0 - lag / (steps * step_s) * reached(motor, step_s, steps) } else { 0.0 }
}

/// Share of its final value in the current at the end of so many steps; one without resistance.
fn reached(motor: &Motor, step_s: f64, steps: f64) -> f64 {
    let lag = motor.phase_inductance_h / motor.phase_resistance_ohm;
    if lag.is_finite() { -libm::expm1(-steps * step_s / lag) } else { 1.0 }
}

/// What is slow is learned, and the friction that is learned acts, in two halves that take turns.
const TURNS: f64 = 2.0;

/// Innovations are counted in this many standard deviations: what is believed of them then stays
/// within one in fixed point.
pub(crate) const SIGMAS: f64 = 64.0;
/// A smaller standard deviation of an angle, in turns, has no gain in fixed point.
const LEAST_SIGMA: f64 = 1.0 / (SIGMAS * 32_767.0);

/// A larger innovation of an angle, in turns, is not told from one the other way round.
const MOST_INNOVATION: f64 = 0.45;
/// A larger per-unit current, drive or speed is no joint's.
const LARGE: f64 = 100.0;
