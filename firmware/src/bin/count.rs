//! `count`: instructions of what runs in the drive, as KEY=value lines.
//!
//! It runs on QEMU's netduinoplus2 with `-icount shift=0,sleep=off` alone. The first line is the
//! counter's own proof: a hundred `nop` are a hundred instructions. The others are one step of
//! 50 µs as one micro-step, of the implicit method too, call and return included, the least and the most over a run with
//! reversals and stick: the two must be equal where the step claims to cost the same whatever the
//! data.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod on_board {
    use core::hint::black_box;

    use firmware::assumed::{MOTOR, STAGES};
    use firmware::board::{self, InstructionCounter};
    use joint_core::effect::{EffectParameters, EffectSet, Effects, Kind};
    use joint_core::joint::{Drive, Input, Joint, Method, Settings, State};
    use joint_core::params::{Load, Location};
    use semihosting::println;

    const STEPS: u32 = 4000;
    const REVERSAL: u32 = 500;

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let counter = InstructionCounter::start();
        println!("hundred_nops={}", counter.measure(hundred_nops).1);

        let mut settings = Settings::new(Drive::Voltage, 50e-6);
        settings.micro_steps = Some(1);
        let load = Load::default();
        report("step_f32", &counter, &Joint::<f32, 2>::new(&MOTOR, &STAGES, &load, &settings));
        report("step_f32_no_stage", &counter, &Joint::<f32, 0>::new(&MOTOR, &[], &load, &settings));

        settings.method = Some(Method::Implicit);
        let joint = Joint::<f32, 2>::new(&MOTOR, &STAGES, &load, &settings);
        report("step_f32_implicit", &counter, &joint);
        settings.method = None;

        let cogging = [EffectParameters::new(Kind::Cogging, Location::Motor)
            .with("order", 6.0)
            .with("amplitude_nm", 1e-5)];
        settings.effects = &cogging;
        let joint = Joint::<f32, 2, EffectSet<f32>>::new(&MOTOR, &STAGES, &load, &settings);
        report("step_f32_cogging", &counter, &joint);
        sizes();
        board::finish(Ok(()))
    }

    /// Memory of one two-stage joint without effects, and the stack of its step.
    fn sizes() {
        let bytes = size_of::<Joint<f32, 2>>() + size_of::<State<f32, 2>>();
        println!("ram_bytes={bytes}");
        let mut settings = Settings::new(Drive::Voltage, 50e-6);
        settings.micro_steps = Some(1);
        let Ok(joint) = Joint::<f32, 2>::new(&MOTOR, &STAGES, &Load::default(), &settings) else {
            return;
        };
        let mut state = joint.rest();
        let input = black_box(joint.input(1.0, 0.0));
        let used = board::stack_used_by(|| step(&joint, &mut state, input));
        black_box(&state);
        println!("stack_bytes={used}");
    }

    fn report<const N: usize, E: Effects<f32>, R: core::fmt::Debug>(
        name: &str,
        counter: &InstructionCounter,
        joint: &Result<Joint<f32, N, E>, R>,
    ) {
        let joint = match joint {
            Ok(joint) => joint,
            Err(error) => panic!("{name}: {error:?}"),
        };
        let mut state = joint.rest();
        let (mut least, mut most) = (u32::MAX, 0);
        for k in 0..STEPS {
            let volts = [6.0, 0.0, -6.0, 0.5][(k / REVERSAL) as usize % 4];
            let input = black_box(joint.input(volts, 0.005));
            let ((), spent) = counter.measure(|| step(joint, &mut state, input));
            (least, most) = (least.min(spent), most.max(spent));
        }
        black_box(&state);
        println!("{name}_instructions={most}");
        println!("{name}_instructions_least={least}");
    }

    #[inline(never)]
    fn step<const N: usize, E: Effects<f32>>(
        joint: &Joint<f32, N, E>,
        state: &mut State<f32, N>,
        input: Input<f32>,
    ) {
        joint.step(state, input);
    }

    #[inline(always)]
    fn hundred_nops() {
        macro_rules! ten {
            ($($call:tt)*) => {
                $($call)* $($call)* $($call)* $($call)* $($call)*
                $($call)* $($call)* $($call)* $($call)* $($call)*
            };
        }
        ten!(ten!(cortex_m::asm::nop();););
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("count runs on a board: build it for thumbv7em-none-eabihf");
}
