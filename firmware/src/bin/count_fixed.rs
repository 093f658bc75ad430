//! `count-fixed PARAMETERS`: the fixed-point step on a chip without a floating-point unit.
//!
//! Built for `thumbv7em-none-eabi` it must not contain a single floating-point routine, so the joint
//! comes ready-made in a parameter block and inputs are whole numbers. It prints the instructions
//! of one step, the least and the most over a run with reversals and stick, how often a state stood
//! at the end of its range, and the last state's bits, which must be the host's. It runs on QEMU's
//! netduinoplus2 with `-icount shift=0,sleep=off` alone.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod on_board {
    use core::hint::black_box;

    use firmware::block::Block;
    use firmware::board::{self, Access, Failure, InstructionCounter};
    use firmware::drill::{STEPS, input};
    use joint_core::fixed::Fixed;
    use joint_core::joint::{Input, Joint, State};
    use semihosting::println;

    #[cortex_m_rt::entry]
    fn main() -> ! {
        board::finish(run())
    }

    fn run() -> Result<(), Failure> {
        let mut bytes = [0; 4096];
        let mut file = board::open(1, "PARAMETERS", Access::Read)?;
        let bytes = board::fill(&mut file, "PARAMETERS", &mut bytes)?;
        let joint: Joint<Fixed, 2> = Block::check(bytes)?.decode()?;
        let counter = InstructionCounter::start();
        let mut state = joint.rest();
        let (mut least, mut most, mut saturated) = (u32::MAX, 0, 0);
        for k in 0..STEPS {
            let (volts, load) = input(k);
            let input = black_box(joint.input(volts, load));
            let ((), spent) = counter.measure(|| step(&joint, &mut state, input));
            (least, most) = (least.min(spent), most.max(spent));
            saturated += joint.saturated(&state);
        }
        println!("step_fixed_instructions={most}");
        println!("step_fixed_instructions_least={least}");
        println!("saturated={saturated}");
        println!("current={}", state.current.to_bits());
        println!("turns={}", state.angle.whole);
        println!("speed={}", state.rotor.speed.to_bits());
        for stage in &state.stages {
            println!("deflection={}", stage.deflection.to_bits());
            println!("bristle={}", stage.mass.bristle.zeta.to_bits());
        }
        Ok(())
    }

    #[inline(never)]
    fn step(joint: &Joint<Fixed, 2>, state: &mut State<Fixed, 2>, input: Input<Fixed>) {
        joint.step(state, input);
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("count-fixed runs on a board: build it for thumbv7em-none-eabi");
}
