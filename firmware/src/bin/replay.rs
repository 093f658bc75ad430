//! `replay PARAMETERS LOG STATES`: steps the f32 joint through a log, by the chip's instructions.
//!
//! It reads the parameter block and the log by semihosting, writes one row of states for each
//! sample and prints KEY=value lines, among them the instructions of a step, least and most over the log
//! (exact on netduinoplus2 alone). The rows must equal the host's f32 run to the bit.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod on_board {
    use firmware::block::{Block, BlockError};
    use firmware::board::{self, Access, Failure, InstructionCounter, Sink};
    use firmware::replay::{ReplayedJoint, steps_by};
    use firmware::samples::{BLOCK_SAMPLES, SAMPLE_BYTES, samples};
    use joint_core::joint::{Input, State};
    use semihosting::println;

    /// Most bytes of a parameter block.
    const BLOCK_BYTES: usize = 2048;

    #[cortex_m_rt::entry]
    fn main() -> ! {
        board::finish(load())
    }

    fn load() -> Result<(), Failure> {
        let mut bytes = [0; BLOCK_BYTES];
        let block = board::read_block(&mut bytes)?;
        match block.stages {
            0 => replay::<0>(&block),
            1 => replay::<1>(&block),
            2 => replay::<2>(&block),
            3 => replay::<3>(&block),
            more => Err(BlockError::Stages(more).into()),
        }
    }

    fn replay<const N: usize>(block: &Block<'_>) -> Result<(), Failure> {
        let joint: ReplayedJoint<N> = block.decode()?;
        let mut state = joint.rest();
        let mut log = board::open(2, "log", Access::Read)?;
        let mut states = Sink::new(board::open(3, "states", Access::Write)?, "states");
        let mut chunk = [0; BLOCK_SAMPLES * SAMPLE_BYTES];
        let counter = InstructionCounter::start();
        let (mut count, mut least, mut most) = (0, u32::MAX, 0);
        let mut counted = |joint: &ReplayedJoint<N>, state: &mut State<f32, N>, input| {
            let ((), spent) = counter.measure(|| step(joint, state, input));
            (least, most) = (least.min(spent), most.max(spent));
        };
        board::in_chunks(&mut log, "log", &mut chunk, |bytes| {
            let put = |number: f32| states.put(number.to_le_bytes());
            steps_by(&joint, &mut state, samples(bytes), &mut counted, put)?;
            count += bytes.len() / SAMPLE_BYTES;
            Ok(())
        })?;
        states.flush()?;
        println!("samples={count}");
        println!("states_crc32={:08x}", states.checksum());
        println!("micro_steps={}", joint.micro_steps());
        println!("step_instructions={most}");
        println!("step_instructions_least={least}");
        Ok(())
    }

    #[inline(never)]
    fn step<const N: usize>(
        joint: &ReplayedJoint<N>,
        state: &mut State<f32, N>,
        input: Input<f32>,
    ) {
        joint.step(state, input);
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("replay runs on a board: build it for thumbv7em-none-eabihf");
}
