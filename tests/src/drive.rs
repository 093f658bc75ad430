//! A drive in the loop with a simulated plant, on the host: what the emulated boards must give back
//! bit for bit.

use firmware::block::{PAGE_BYTES, encode};
use firmware::link::{self, Link};
use firmware::parameters::{DriveJoint, Parameters, Sensing};
use firmware::session::Session;
use joint_core::effect::{EffectParameters, EffectSet};
use joint_core::joint::{Drive, Joint, Settings};
use joint_core::observer::{Column, Design, Gains, Level, Observer, Regime, SETS, Spread};
use joint_core::params::{Friction, Load, Motor, Stage};
use joint_core::scalar::Real;
use joint_core::telemetry::frame::{self, Frame, Reader};
use joint_core::telemetry::{Command, Message, Sample, Status};

/// Control period, s.
pub const PERIOD_S: f64 = 50e-6;
/// Counts per turn of both encoders.
pub const COUNTS: u32 = 4096;

fn friction(coulomb_nm: f64) -> Friction {
    Friction {
        sigma0_nm_per_rad: 5_000.0 * coulomb_nm,
        sigma1_nm_s_per_rad: 0.04 * coulomb_nm,
        sigma2_nm_s_per_rad: 1e-4 * coulomb_nm,
        coulomb_nm,
        stribeck_nm: 0.4 * coulomb_nm,
        stribeck_velocity_rad_per_s: 20.0,
    }
}

/// A 6 mm brushless micromotor.
pub fn motor() -> Motor {
    Motor {
        phase_resistance_ohm: 4.55,
        phase_inductance_h: 13e-6,
        torque_constant_nm_per_a: 1.38e-3,
        rotor_inertia_kg_m2: 9.5e-10,
        friction: friction(9e-6),
        ..Motor::default()
    }
}

/// Its planetary gear of 32:1 per stage.
pub fn gear() -> [Stage; 2] {
    [(2e-9, 0.5, 2e-5), (8e-7, 15.0, 1e-3)].map(|(inertia_kg_m2, stiffness, coulomb)| Stage {
        reduction: 32.0,
        inertia_kg_m2,
        stiffness_nm_per_rad: stiffness,
        cubic_stiffness_nm_per_rad3: 3.0 * stiffness,
        damping_nm_s_per_rad: 1e-7,
        worm_lead_angle_rad: 0.0,
        worm_friction_coefficient: 0.0,
        friction: friction(coulomb),
    })
}

/// Gains that follow this joint. They are put in by hand, the same for every regime: what is tested
/// is where they are used, not how they are found.
fn design() -> Design<2> {
    let mut motor = Column::filled(0.0);
    motor.angle = 4e-4;
    motor.speed = 0.6;
    motor.load = 1e-5;
    motor.slope = 1e-8;
    let mut output = Column::filled(0.0);
    output.load = -2e-5;
    for row in &mut output.stages {
        row.deflection = -0.02;
    }
    let mut current = Column::filled(0.0);
    current.current = 1e-4;
    current.bias = 1e-4;
    let turn = std::f64::consts::TAU / f64::from(COUNTS);
    Design {
        sets: [[current, motor, output]; SETS],
        hardened: 0.1,
        sigma: [2e-3, turn, turn],
        gate: 200.0,
        leak: [0.95; Regime::COUNT],
        projection: [[0.1, 0.9, 0.0], [0.1, 0.6, 0.3]],
        smoothing: 0.02,
        alarm: 4.0,
        hold: 40,
        alarm_rate: 1e-3,
        varying: (0.3, 400),
        settled: 200,
        inconsistent: 40.0,
        most_load_nm: 0.05,
        most_bias: 1.0,
        most_ohm: 0.5,
        most_flux: 0.1,
        ohm: 0.0,
        flux: 0.0,
        level: Level::NONE,
        outlier: 1e3,
        push: 0.0,
        confirmed: u16::MAX / 2,
        most_current_a: 2.0,
        spread: [Spread::filled(0.1); SETS],
        turning: [0.0; 2],
    }
}

/// The drive's parameters for it.
///
/// # Panics
/// The equations cannot take them.
pub fn parameters() -> Parameters<2> {
    parameters_with(&[])
}

/// The same for a joint with effects.
///
/// # Panics
/// The equations cannot take them.
pub fn parameters_with(effects: &[EffectParameters]) -> Parameters<2> {
    let settings = Settings { effects, ..Settings::new(Drive::Voltage, PERIOD_S) };
    let joint = DriveJoint::new(&motor(), &gear(), &Load::default(), &settings).unwrap();
    let gains = Gains::new(&design(), &motor(), &gear(), Drive::Voltage, PERIOD_S);
    let sensing = Sensing {
        motor_counts_per_turn: COUNTS,
        output_counts_per_turn: COUNTS,
        largest_voltage_v: 12.0,
        largest_current_a: 2.0,
        largest_move_counts: 400,
        ..Sensing::default()
    };
    Parameters { observer: Observer { joint, gains }, sensing }
}

/// The gear with springs that fixed point steps: straight and without damping.
pub fn plain_gear() -> [Stage; 2] {
    gear().map(|stage| Stage {
        cubic_stiffness_nm_per_rad3: 0.0,
        damping_nm_s_per_rad: 0.0,
        ..stage
    })
}

/// The observer of the joint with [`plain_gear`], in one micro-step.
///
/// # Panics
/// The equations cannot take the parameters.
pub fn observer<S: Real>() -> Observer<S, 2> {
    let (motor, stages) = (motor(), plain_gear());
    let settings = Settings { micro_steps: Some(1), ..Settings::new(Drive::Voltage, PERIOD_S) };
    let joint = Joint::<S, 2>::new(&motor, &stages, &Load::default(), &settings).unwrap();
    let gains = Gains::new(&design(), &motor, &stages, Drive::Voltage, PERIOD_S);
    Observer { joint, gains }
}

/// Parameters as a block.
///
/// # Panics
/// They do not fit a page.
pub fn block<const N: usize>(parameters: &Parameters<N>) -> Vec<u8> {
    let mut bytes = vec![0; PAGE_BYTES];
    let length = encode(parameters, N as u8, &mut bytes).unwrap();
    bytes.truncate(length);
    bytes
}

/// What the sensors of the plant show: the joint in double precision under held voltages of both
/// signs with stretches of zero in between, and a load that comes and goes.
///
/// # Panics
/// The equations cannot take the parameters.
pub fn plant(samples: usize) -> Vec<Sample> {
    let settings = Settings::new(Drive::Voltage, PERIOD_S);
    let joint =
        Joint::<f64, 2, EffectSet<f64>>::new(&motor(), &gear(), &Load::default(), &settings)
            .unwrap();
    let mut state = joint.rest();
    let counts = |turns: f64| (turns * f64::from(COUNTS)).floor() as i32;
    (0..samples)
        .map(|k| {
            let voltage: f64 = [3.0, -4.5, 0.0, 0.37, -0.02, 6.0][k / 411 % 6];
            let load = if k / 1_009 % 2 == 1 { 0.004 } else { 0.0 };
            let wound = joint.deflection(&state, 0) + joint.deflection(&state, 1);
            let output = state.angle.to_turns() - wound / std::f64::consts::TAU;
            let sample = Sample {
                voltage_v: voltage as f32,
                // A converter of 1 mA a step.
                current_a: ((joint.current(&state) * 1e3).round() * 1e-3) as f32,
                motor_counts: counts(state.angle.to_turns()),
                output_counts: counts(output / 1024.0),
            };
            joint.step(&mut state, joint.input(voltage, load));
            sample
        })
        .collect()
}

/// Runs the session on the host; each command acts before the sample of its number.
///
/// # Panics
/// The built-in defaults are refused.
pub fn run(page: &[u8], samples: &[Sample], commands: &[(u32, Command)]) -> Vec<u8> {
    let mut session = Session::new();
    session.start(page).unwrap();
    let messages = link::messages();
    let mut link = Link::default();
    let mut bytes = Vec::new();
    for (k, sample) in samples.iter().enumerate() {
        for (_, command) in commands.iter().filter(|(at, _)| *at as usize == k) {
            session.command(*command);
        }
        session.tick(*sample, 0, Status::default(), &messages);
        while link.send(&messages, |frame| {
            bytes.extend_from_slice(frame);
            true
        }) {}
    }
    bytes
}

/// The commands as the emulated drive reads them: frames, numbered by the sample they precede.
pub fn command_bytes(commands: &[(u32, Command)]) -> Vec<u8> {
    commands
        .iter()
        .flat_map(|(at, command)| frame::encode(&Message::Command(*command), *at))
        .collect()
}

/// The frames in there.
///
/// # Panics
/// A byte belongs to no frame, or a frame is missing.
pub fn frames(bytes: &[u8]) -> Vec<Frame> {
    let mut reader = Reader::default();
    let frames: Vec<Frame> = bytes.iter().filter_map(|byte| reader.push(*byte)).collect();
    assert_eq!(reader.skipped, 0);
    assert!(frames.iter().zip(0..).all(|(frame, number)| frame.sequence == number));
    frames
}
