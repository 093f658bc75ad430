//! The step under attack: random joints with random effects, inputs that jump as far as their drive goes,
//! and inputs that are no number, in all three formats.
//!
//! `cargo test --release -p joint-core --test attack -- --ignored --nocapture` tries ten million.

use joint_core::effect::{EffectParameters, EffectSet, Kind, MAX_TABLES};
use joint_core::fixed::Fixed;
use joint_core::joint::{Drive, Joint, Settings};
use joint_core::params::{Friction, Load, Location, Motor, Stage};
use joint_core::scalar::Scalar;

/// Steps of each joint: a jump of drive and load every sixth, and rest for the last half.
const STEPS: u32 = 40;
const STEP_S: f64 = 50e-6;

/// SplitMix64 (G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014).
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Between −1 and 1.
    fn signed(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// A value times or over up to ten to that power.
    fn around(&mut self, value: f64, decades: f64) -> f64 {
        value * 10_f64.powf(decades * self.signed())
    }

    fn below(&mut self, end: usize) -> usize {
        (self.bits() % end as u64) as usize
    }
}

/// A joint without its number of stages.
struct Drawn {
    motor: Motor,
    stages: Vec<Stage>,
    load: Load,
    drive: Drive,
    effects: Vec<EffectParameters>,
    /// Largest voltage (or current) and load.
    most: [f64; 2],
}

fn friction(random: &mut Random, coulomb_nm: f64, stiffness: f64) -> Friction {
    let coulomb_nm = random.around(coulomb_nm, 1.0);
    Friction {
        sigma0_nm_per_rad: random.around(stiffness, 1.0),
        sigma1_nm_s_per_rad: random.around(1e-5 * stiffness, 1.5),
        sigma2_nm_s_per_rad: random.around(1e-7 * stiffness, 1.5),
        coulomb_nm,
        stribeck_nm: coulomb_nm * (0.5 + random.signed()),
        stribeck_velocity_rad_per_s: random.around(400.0 * coulomb_nm / stiffness, 1.0),
    }
}

fn drawn(random: &mut Random) -> Drawn {
    let motor = Motor {
        phase_resistance_ohm: random.around(4.55, 1.0),
        phase_inductance_h: random.around(13e-6, 1.5),
        torque_constant_nm_per_a: random.around(1.38e-3, 0.5),
        rotor_inertia_kg_m2: random.around(9.5e-10, 1.0),
        friction: friction(random, 9e-6, 0.05),
        ..Motor::default()
    };
    let count = random.below(3);
    let stages: Vec<Stage> = [(2e-9, 0.35, 8e-5), (8e-7, 15.0, 1e-3)][..count]
        .iter()
        .map(|&(inertia, spring, level)| Stage {
            reduction: random.around(32.0, 0.5) * if random.below(8) == 0 { -1.0 } else { 1.0 },
            inertia_kg_m2: random.around(inertia, 1.0),
            stiffness_nm_per_rad: random.around(spring, 1.0),
            cubic_stiffness_nm_per_rad3: random.around(10.0 * spring, 1.0),
            damping_nm_s_per_rad: if random.below(2) == 0 {
                random.around(1e-5 * spring, 1.0)
            } else {
                0.0
            },
            friction: friction(random, level, 4.0 * spring),
            ..Stage::default()
        })
        .collect();
    let reduction: f64 = stages.iter().map(|stage| stage.reduction.abs()).product();
    let breakaway = motor.friction.breakaway_nm() * reduction
        + stages.iter().map(|stage| stage.friction.breakaway_nm()).sum::<f64>();
    let mut effects = Vec::new();
    for _ in 0..random.below(4) {
        let kind = Kind::ALL[random.below(Kind::ALL.len())];
        let example = EffectParameters::example(kind);
        let places = kind.spec().locations;
        let location = match places[random.below(places.len())] {
            Location::Stage(_) => Location::Stage(random.below(count.max(1)) as u8 + 1),
            other => other,
        };
        let tables = effects.iter().filter(|own: &&EffectParameters| own.kind.has_table()).count();
        let full = kind.has_table() && tables >= MAX_TABLES;
        if full || !EffectParameters::admits(kind, location, count) {
            continue;
        }
        let mut effect = EffectParameters { location, ..example };
        for (value, (own, spec)) in
            effect.values.iter_mut().zip(example.values.iter().zip(kind.spec().parameters))
        {
            // A course that takes more than all friction away is refused.
            let most = if kind.has_table() { *own } else { spec.high };
            *value = random.around(*own, 0.7).clamp(spec.low, most);
        }
        effects.push(effect);
    }
    let drive = if random.below(4) == 0 { Drive::Current } else { Drive::Voltage };
    // The drive that breaks the joint away, and up to thirty times as much.
    let amperes = breakaway / (reduction * motor.torque_constant_nm_per_a);
    let most_drive = match drive {
        Drive::Voltage => 2.0 * motor.phase_resistance_ohm * amperes,
        Drive::Current => amperes,
    };
    let most = [random.around(5.0 * most_drive, 0.8), random.around(breakaway, 0.8)];
    let load = Load { inertia_kg_m2: random.around(1e-7, 1.0), ..Load::default() };
    Drawn { motor, stages, load, drive, effects, most }
}

/// What became of one joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    Stepped,
    /// Not built; the error names the parameter.
    Refused,
}

fn attacked<S: Scalar, const N: usize>(drawn: &Drawn, random: &mut Random) -> Result<Fate, String> {
    let settings = Settings { effects: &drawn.effects, ..Settings::new(drawn.drive, STEP_S) };
    let stages: [Stage; N] = core::array::from_fn(|k| drawn.stages[k]);
    let joint = Joint::<S, N, EffectSet<S>>::new(&drawn.motor, &stages, &drawn.load, &settings);
    let Ok(joint) = joint else { return Ok(Fate::Refused) };
    let mut state = joint.rest();
    let [most_drive, most_load] = drawn.most;
    let mut input = joint.input(S::ZERO, S::ZERO);
    let mut fastest: f64 = 0.0;
    for k in 0..STEPS {
        if k == STEPS / 2 {
            input = joint.input(S::ZERO, S::ZERO);
        } else if k < STEPS / 2 && k % 6 == 0 {
            let side = |random: &mut Random| [-1.0, 0.0, 1.0][random.below(3)];
            let drive = S::from_f64(most_drive * side(random));
            input = joint.input(drive, S::from_f64(most_load * side(random)));
        }
        joint.step(&mut state, input);
        let speed =
            (0..=N).map(|mass| joint.speed_rad_per_s(&state, mass).abs()).fold(0.0, f64::max);
        if S::LARGEST.is_infinite() && joint.saturated(&state) > 0 {
            return Err(format!("{} numbers are none after step {k}", joint.saturated(&state)));
        }
        if k < STEPS / 2 {
            fastest = fastest.max(speed);
        } else if speed > 30.0 * fastest && speed > 1.0 {
            return Err(format!("{speed} rad/s after {fastest} without a drive, step {k}"));
        }
        // An explosion doubles its speed in every step.
        if speed > LARGEST_SPEED {
            return Err(format!("{speed} rad/s in step {k}"));
        }
    }
    Ok(Fate::Stepped)
}

/// The light second stage swings by some 10⁵ rad/s at the motor under the largest jumps drawn.
const LARGEST_SPEED: f64 = 1e9;

fn attack<S: Scalar>(seeds: core::ops::Range<u64>) -> [u64; 2] {
    let mut counts = [0; 2];
    for seed in seeds {
        let mut random = Random(seed);
        let drawn = drawn(&mut random);
        let fate = match drawn.stages.len() {
            0 => attacked::<S, 0>(&drawn, &mut random),
            1 => attacked::<S, 1>(&drawn, &mut random),
            _ => attacked::<S, 2>(&drawn, &mut random),
        };
        match fate {
            Ok(fate) => counts[fate as usize] += 1,
            Err(error) => panic!(
                "{} seed {seed}: {error}\n{:?} {:?} {:?} {:?} {:?}",
                core::any::type_name::<S>(),
                drawn.motor,
                drawn.stages,
                drawn.load,
                drawn.drive,
                drawn.effects
            ),
        }
    }
    counts
}

#[test]
fn random_joints_stay_finite_and_slow_down_without_a_drive() {
    let floats = [attack::<f32>(0..1000), attack::<f64>(1000..2000)];
    let [stepped, refused] = attack::<Fixed>(2000..3000);
    println!("{floats:?} {stepped} {refused}");
    assert_eq!(floats, [[1000, 0]; 2]);
    // A third has a constant beyond the range of fixed point.
    assert!(stepped > refused && stepped + refused == 1000);
}

#[test]
#[ignore = "an hour or more"]
fn ten_million_random_joints_stay_finite_and_slow_down_without_a_drive() {
    const EACH: u64 = 3_333_334;
    let run = |name: &str, [stepped, refused]: [u64; 2]| {
        println!("{name}: {stepped} joints in {STEPS} steps each, {refused} refused by name");
    };
    std::thread::scope(|scope| {
        scope.spawn(|| run("f32", attack::<f32>(0..EACH)));
        scope.spawn(|| run("f64", attack::<f64>(EACH..2 * EACH)));
        scope.spawn(|| run("fixed", attack::<Fixed>(2 * EACH..3 * EACH)));
    });
}

fn joint<S: Scalar>() -> Joint<S, 1> {
    let motor = Motor {
        phase_resistance_ohm: 4.55,
        phase_inductance_h: 13e-6,
        torque_constant_nm_per_a: 1.38e-3,
        rotor_inertia_kg_m2: 9.5e-10,
        friction: Friction {
            sigma0_nm_per_rad: 0.05,
            sigma1_nm_s_per_rad: 4e-7,
            sigma2_nm_s_per_rad: 1e-9,
            coulomb_nm: 9e-6,
            stribeck_nm: 4e-6,
            stribeck_velocity_rad_per_s: 20.0,
        },
        ..Motor::default()
    };
    let stage = Stage {
        reduction: 32.0,
        inertia_kg_m2: 2e-9,
        stiffness_nm_per_rad: 0.35,
        friction: Friction {
            sigma0_nm_per_rad: 1.4,
            sigma1_nm_s_per_rad: 1e-5,
            sigma2_nm_s_per_rad: 1e-7,
            coulomb_nm: 8e-5,
            stribeck_nm: 3e-5,
            stribeck_velocity_rad_per_s: 0.5,
        },
        ..Stage::default()
    };
    Joint::<S, 1>::new(&motor, &[stage], &Load::default(), &Settings::new(Drive::Voltage, STEP_S))
        .unwrap()
}

/// Floats carry what is no number into the state, where [`Joint::saturated`] tells of it; fixed point has
/// none, and stops at its limits.
#[test]
fn an_input_that_is_no_number_is_told_and_the_next_start_is_sound() {
    fn attacked<S: Scalar>() {
        let joint = joint::<S>();
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -f64::MAX] {
            for load in [false, true] {
                let mut state = joint.rest();
                let value = S::from_f64(bad);
                let input =
                    if load { joint.input(S::ZERO, value) } else { joint.input(value, S::ZERO) };
                for _ in 0..200 {
                    joint.step(&mut state, input);
                }
                let told = joint.saturated(&state) > 0;
                assert!(told || S::LARGEST.is_finite(), "{bad} {load}");
                state = joint.rest();
                for _ in 0..200 {
                    joint.step(&mut state, joint.input(S::ONE, S::ZERO));
                }
                assert_eq!(joint.saturated(&state), 0);
                assert!(joint.speed_rad_per_s(&state, 0) > 1.0);
            }
        }
    }
    attacked::<f32>();
    attacked::<f64>();
    attacked::<Fixed>();
}

/// A current that the saturation of the iron halves and dead time reduces before.
#[test]
fn saturation_beside_dead_time_is_that_of_the_current_which_flows() {
    let motor = Motor {
        phase_resistance_ohm: 4.0,
        phase_inductance_h: 1e-5,
        torque_constant_nm_per_a: 1e-2,
        rotor_inertia_kg_m2: 1e-5,
        ..Motor::default()
    };
    let effects = [
        EffectParameters::new(Kind::TorqueSaturation, Location::Motor).with("current_a", 0.5),
        EffectParameters::new(Kind::DeadTime, Location::Inverter)
            .with("voltage_v", 4.0)
            .with("softening_a", 1e-2),
    ];
    let speed = |step_s: f64, effects: &[EffectParameters]| {
        let mut settings = Settings { effects, ..Settings::new(Drive::Voltage, step_s) };
        settings.micro_steps = Some(1);
        let joint =
            Joint::<f64, 0, EffectSet<f64>>::new(&motor, &[], &Load::default(), &settings).unwrap();
        let mut state = joint.rest();
        for _ in 0..(2e-3 / step_s).round() as u32 {
            joint.step(&mut state, joint.input(12.0, 0.0));
        }
        joint.speed(&state, 0)
    };
    // 1 A is left of 1.5: of the torque constant a fifth instead of a tenth.
    let exact = speed(1e-7, &effects);
    for step_s in [25e-6, 50e-6, 100e-6] {
        let found = speed(step_s, &effects);
        // The current rises within 1.25 µs, so that the speed grows evenly: what is left is the dead time's
        // Newton step, a hundredth.
        assert!((found / exact - 1.0).abs() < 0.01, "{step_s}: {found} {exact}");
    }
}

/// Damping of a bristle that a reversal leaves bent against the speed.
#[test]
fn a_joint_whose_bristles_damp_strongly_comes_to_rest() {
    let motor = Motor {
        phase_resistance_ohm: 4.0,
        phase_inductance_h: 1e-5,
        torque_constant_nm_per_a: 1e-2,
        rotor_inertia_kg_m2: 1e-5,
        friction: Friction {
            sigma0_nm_per_rad: 5.0,
            // Loses 0.9 of its speed in a middle kick of 50 µs while a bristle bends.
            sigma1_nm_s_per_rad: 0.13,
            sigma2_nm_s_per_rad: 1e-6,
            coulomb_nm: 1e-3,
            stribeck_nm: 6e-3,
            stribeck_velocity_rad_per_s: 0.5,
        },
        ..Motor::default()
    };
    let settings = Settings::new(Drive::Voltage, STEP_S);
    let joint = Joint::<f64, 0>::new(&motor, &[], &Load::default(), &settings).unwrap();
    let mut state = joint.rest();
    let mut fastest: f64 = 0.0;
    for k in 0..4000_u32 {
        let volts = if k < 2000 { [20.0, -20.0][(k / 7) as usize % 2] } else { 0.0 };
        joint.step(&mut state, joint.input(volts, 0.0));
        if k < 2000 {
            fastest = fastest.max(joint.speed(&state, 0).abs());
        }
    }
    assert!(joint.speed(&state, 0).abs() < 1e-3 * fastest, "{} {fastest}", joint.speed(&state, 0));
}
