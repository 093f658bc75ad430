//! `count`: instructions of what runs in the drive, as KEY=value lines.
//!
//! It runs on QEMU's netduinoplus2 with `-icount shift=0,sleep=off` alone. The first line is the
//! counter's own proof: a hundred `nop` are a hundred instructions. The others are one step of
//! 50 µs as one micro-step, call and return included, the least and the most over a run with
//! reversals and stick: the two must be equal where the step claims to cost the same whatever the
//! data.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod on_board {
    use core::hint::black_box;

    use firmware::board::{self, InstructionCounter};
    use joint_core::effect::{EffectParameters, EffectSet, Effects, Kind};
    use joint_core::joint::{Drive, Input, Joint, Settings, State};
    use joint_core::params::{Friction, Load, Location, Motor, Stage};
    use semihosting::println;

    const STEPS: u32 = 4000;
    const REVERSAL: u32 = 500;

    /// A 6 mm brushless micromotor.
    const MOTOR: Motor = Motor {
        phase_resistance_ohm: 4.55,
        phase_inductance_h: 13e-6,
        torque_constant_nm_per_a: 1.38e-3,
        phase_back_emf_constant_v_s_per_rad: None,
        pole_pairs: 1,
        rotor_inertia_kg_m2: 9.5e-10,
        friction: Friction {
            sigma0_nm_per_rad: 0.05,
            sigma1_nm_s_per_rad: 4e-7,
            sigma2_nm_s_per_rad: 1e-9,
            coulomb_nm: 9e-6,
            stribeck_nm: 4e-6,
            stribeck_velocity_rad_per_s: 20.0,
        },
    };
    /// Its planetary gear of 32:1 per stage, the second one with the link.
    const STAGES: [Stage; 2] = [stage(2e-9, 0.5, 9e-6), stage(8e-7, 15.0, 1e-3)];

    const fn stage(inertia_kg_m2: f64, stiffness_nm_per_rad: f64, coulomb_nm: f64) -> Stage {
        Stage {
            reduction: 32.0,
            inertia_kg_m2,
            stiffness_nm_per_rad,
            cubic_stiffness_nm_per_rad3: 0.0,
            damping_nm_s_per_rad: 0.0,
            worm_lead_angle_rad: 0.0,
            worm_friction_coefficient: 0.0,
            friction: Friction {
                sigma0_nm_per_rad: 100.0 * stiffness_nm_per_rad,
                sigma1_nm_s_per_rad: 1e-5,
                sigma2_nm_s_per_rad: 1e-7,
                coulomb_nm,
                stribeck_nm: 0.4 * coulomb_nm,
                stribeck_velocity_rad_per_s: 1.0,
            },
        }
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let counter = InstructionCounter::start();
        println!("hundred_nops={}", counter.measure(hundred_nops).1);

        let mut settings = Settings::new(Drive::Voltage, 50e-6);
        settings.micro_steps = Some(1);
        let load = Load::default();
        report("step_f32", &counter, &Joint::<f32, 2>::new(&MOTOR, &STAGES, &load, &settings));
        report("step_f32_no_stage", &counter, &Joint::<f32, 0>::new(&MOTOR, &[], &load, &settings));

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
