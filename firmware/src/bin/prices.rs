//! `prices`: what the parts of a step cost, as KEY=value lines: the Stribeck curve by five methods with
//! their errors, a plain joint of nought to four stages, the step in f64 and
//! by the implicit method, each effect on a joint of two, and one
//! evaluation of the equations as an explicit method needs it.
//!
//! It runs on QEMU's netduinoplus2 with `-icount shift=0,sleep=off` alone. Instructions are the most
//! over the inputs; those of an effect count what it adds to the first effect's joint, whose hooks are
//! called but do nothing.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod on_board {
    use core::hint::black_box;

    use firmware::assumed::{MOTOR, STAGES, friction, stage};
    use firmware::board::{self, InstructionCounter};
    use joint_core::effect::{EffectParameters, EffectSet, Effects, Kind};
    use joint_core::friction::Stribeck;
    use joint_core::joint::{Drive, Joint, Method, Settings};
    use joint_core::params::{Load, Stage};
    use joint_core::scalar::Real;
    use micromath::F32Ext;
    use semihosting::println;

    const BETA: f32 = 0.5;
    /// Squares of a speed over the Stribeck velocity, in 2000 steps.
    const LARGEST: f32 = 12.0;

    /// Ways to the excess over Coulomb friction and the level, both over the Coulomb level.
    type Curve = fn(f32) -> (f32, f32);

    fn of_exponential(e: f32) -> (f32, f32) {
        let excess = BETA * e;
        (excess / (1.0 + excess), 1.0 + excess)
    }

    #[inline(never)]
    fn cubic(square: f32) -> (f32, f32) {
        // The step's own: its unit of the square is part of a constant there.
        (square * (2.0 * f32::SQUARE as f32)).stribeck(BETA)
    }

    #[inline(never)]
    fn rational(square: f32) -> (f32, f32) {
        let root = 1.0 + square * (0.244_350_91 + 0.041_091_23 * square);
        let (half, beta) = (root * root, BETA);
        let grown = half * half;
        (beta / (grown + beta), 1.0 + beta / grown)
    }

    #[inline(never)]
    fn table(square: f32) -> (f32, f32) {
        let place = if square < 7.99 { square * 16.0 } else { 127.0 };
        let whole = place as usize & 127;
        let value = |at: usize| TABLE.get(at).copied().unwrap_or(0.0);
        let (from, to) = (value(whole), value(whole + 1));
        of_exponential(from + (to - from) * (place - whole as f32))
    }

    #[inline(never)]
    fn libm_expf(square: f32) -> (f32, f32) {
        of_exponential(libm::expf(-square))
    }

    #[inline(never)]
    fn micromath_exp(square: f32) -> (f32, f32) {
        of_exponential(F32Ext::exp(-square))
    }

    #[inline(never)]
    fn nothing(square: f32) -> (f32, f32) {
        (square, square)
    }

    /// exp(−k/16).
    static TABLE: [f32; 129] = table_of_exponentials();

    const fn table_of_exponentials() -> [f32; 129] {
        // exp(−1/16)
        const RATIO: f64 = 0.939_413_062_813_475_8;
        let (mut table, mut value, mut k) = ([0.0; 129], 1.0, 0);
        while k < 129 {
            table[k] = value as f32;
            value *= RATIO;
            k += 1;
        }
        table
    }

    /// A stage of its planetary gear, with a light link.
    const STAGE: Stage =
        stage(8.0, 1e-8, [1.0, 0.0], friction([1.5, 6e-6, 2e-8], [8e-5, 4e-5, 0.6]));

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let counter = InstructionCounter::start();
        curves(&counter);
        println!("stages_0={}", stages::<0>(&counter));
        println!("stages_1={}", stages::<1>(&counter));
        println!("stages_2={}", stages::<2>(&counter));
        println!("stages_3={}", stages::<3>(&counter));
        println!("stages_4={}", stages::<4>(&counter));
        println!("step_f64={}", whole::<f64>(&counter, Method::Splitting, 1));
        println!("implicit_1={}", whole::<f32>(&counter, Method::Implicit, 1));
        println!("implicit_2={}", whole::<f32>(&counter, Method::Implicit, 2));
        println!("effects_none={}", effect(&counter, None));
        for kind in Kind::ALL {
            let example = EffectParameters::example(*kind);
            println!("effect_{}={}", kind.spec().kind, effect(&counter, Some(example)));
        }
        println!("explicit_rates={}", explicit(&counter));
        board::finish(Ok(()))
    }

    fn curves(counter: &InstructionCounter) {
        let ways: [(&str, Curve); 6] = [
            ("call", nothing),
            ("cubic", cubic),
            ("rational", rational),
            ("table", table),
            ("libm", libm_expf),
            ("micromath", micromath_exp),
        ];
        for (name, way) in ways {
            let (mut most, mut error) = (0, 0.0_f64);
            for k in 0..=2000_u16 {
                let square = black_box(LARGEST * f32::from(k) / 2000.0);
                let mut found = (0.0, 0.0);
                let ((), spent) = counter.measure(|| found = black_box(way)(square));
                most = most.max(spent);
                let exact = f64::from(BETA) * libm::exp(-f64::from(square));
                error = error.max((f64::from(found.1) - 1.0 - exact).abs() / f64::from(BETA));
            }
            println!("stribeck_{name}_instructions={most}");
            println!("stribeck_{name}_error_ppb={}", (error * 1e9) as u64);
        }
    }

    fn settings() -> Settings<'static> {
        let mut settings = Settings::new(Drive::Voltage, 50e-6);
        settings.micro_steps = Some(1);
        settings
    }

    fn stages<const N: usize>(counter: &InstructionCounter) -> u32 {
        let joint = Joint::<f32, N>::new(&MOTOR, &[STAGE; N], &Load::default(), &settings());
        joint.map_or(0, |joint| most(counter, &joint))
    }

    /// A step of the assumed joint.
    fn whole<S: Real>(counter: &InstructionCounter, method: Method, micro_steps: u32) -> u32 {
        let asked = Settings {
            method: Some(method),
            micro_steps: Some(micro_steps),
            ..Settings::new(Drive::Voltage, 50e-6)
        };
        Joint::<S, 2>::new(&MOTOR, &STAGES, &Load::default(), &asked)
            .map_or(0, |joint| most(counter, &joint))
    }

    fn effect(counter: &InstructionCounter, effects: Option<EffectParameters>) -> u32 {
        let settings = Settings { effects: effects.as_slice(), ..settings() };
        let stages = [STAGE; 2];
        let joint =
            Joint::<f32, 2, EffectSet<f32>>::new(&MOTOR, &stages, &Load::default(), &settings);
        joint.map_or(0, |joint| most(counter, &joint))
    }

    #[inline(never)]
    fn most<S: Real, const N: usize, E: Effects<S>>(
        counter: &InstructionCounter,
        joint: &Joint<S, N, E>,
    ) -> u32 {
        let (mut state, mut most) = (joint.rest(), 0);
        for k in 0..400_u32 {
            let volts = [6.0, 0.0, -6.0, 0.5][(k / 50) as usize % 4];
            let input = black_box(joint.input(S::from_f64(volts), S::from_f64(0.001)));
            let ((), spent) = counter.measure(|| joint.step(&mut state, input));
            most = most.max(spent);
        }
        black_box(&state);
        most
    }

    /// The rates of change of a joint of two stages in f32, with a library's exponential.
    #[inline(never)]
    fn rates(
        constants: &[[f32; 7]; 3],
        springs: &[f32; 2],
        input: f32,
        x: &[f32; 10],
    ) -> [f32; 10] {
        let [current, _, d1, d2, v0, v1, v2, z0, z1, z2] = *x;
        let [t1, t2] = [springs[0] * d1, springs[1] * d2];
        let driving = [current - t1, t1 - t2, t2];
        let mut rate = [input - current - v0, v0, v0 - v1, v1 - v2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let masses = constants.iter().zip(driving).zip([v0, v1, v2].into_iter().zip([z0, z1, z2]));
        let (head, tail) = rate.split_at_mut(7);
        let Some(speeds) = head.get_mut(4..) else { return rate };
        for (((constants, driving), (v, z)), (speed, bristle)) in
            masses.zip(speeds.iter_mut().zip(tail))
        {
            let [mobility, s0, s1, s2, a0, a1, per_v0] = *constants;
            let relative = v * per_v0;
            let level = a0 + a1 * libm::expf(-relative * relative);
            let bend = v - s0 * v.abs() * z / level;
            *bristle = bend;
            *speed = mobility * (driving - s0 * z - s1 * bend - s2 * v);
        }
        rate
    }

    fn explicit(counter: &InstructionCounter) -> u32 {
        let constants = black_box([[1.0, 2.0, 0.1, 0.01, 1.0, 0.5, 0.3]; 3]);
        let springs = black_box([3.0, 2.0]);
        let mut state = black_box([0.1; 10]);
        let mut most = 0;
        for _ in 0..100 {
            let mut rate = [0.0; 10];
            let ((), spent) =
                counter.measure(|| rate = rates(&constants, &springs, 1.0, black_box(&state)));
            for (value, rate) in state.iter_mut().zip(rate) {
                *value += 1e-3 * rate;
            }
            most = most.max(spent);
        }
        black_box(&state);
        most
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("prices runs on a board: build it for thumbv7em-none-eabihf");
}
