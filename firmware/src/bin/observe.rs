//! `observe PARAMETERS LOG ESTIMATES`: the f32 observer over a log, by the chip's instructions.
//!
//! It reads a parameter block that holds an observer and a log of records, writes one row of
//! estimates for each and prints KEY=value lines: among them the instructions of an update and of
//! reading the estimate, least and most over the log (exact on netduinoplus2 alone), and the bytes
//! of constants and state. The rows must equal the host's to the bit.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod on_board {
    use firmware::block::{Block, BlockError};
    use firmware::board::{self, Access, Failure, InstructionCounter, Sink};
    use firmware::observing::{Observing, RECORD_BYTES, from_bytes, row};
    use joint_core::observer::{Estimate, Sample, Status, Track};
    use semihosting::println;

    /// Most bytes of a parameter block.
    const BLOCK_BYTES: usize = 6144;
    /// Records read from the log at once.
    const RECORDS: usize = 128;
    /// Samples at the start that are not counted: an observer that finds its first angle and speed
    /// does other work.
    const START: usize = 20;

    #[cortex_m_rt::entry]
    fn main() -> ! {
        board::finish(load())
    }

    fn load() -> Result<(), Failure> {
        let mut bytes = [0; BLOCK_BYTES];
        let block = board::read_block(&mut bytes)?;
        match block.stages {
            0 => observe::<0>(&block),
            1 => observe::<1>(&block),
            2 => observe::<2>(&block),
            more => Err(BlockError::Stages(more).into()),
        }
    }

    fn observe<const N: usize>(block: &Block<'_>) -> Result<(), Failure> {
        let observer: Observing<N> = block.decode()?;
        let mut track = observer.start(0);
        let mut log = board::open(2, "log", Access::Read)?;
        let mut out = Sink::new(board::open(3, "estimates", Access::Write)?, "estimates");
        let counter = InstructionCounter::start();
        let mut chunk = [0; RECORDS * RECORD_BYTES];
        let mut count = 0;
        let (mut least, mut most, mut reading) = (u32::MAX, 0, 0);
        board::in_chunks(&mut log, "log", &mut chunk, |bytes| {
            for record in bytes.as_chunks::<RECORD_BYTES>().0 {
                let sample = from_bytes(record);
                let (_, spent) = counter.measure(|| update(&observer, &mut track, &sample));
                let (estimate, read) = counter.measure(|| read(&observer, &track));
                count += 1;
                if count > START {
                    (least, most) = (least.min(spent), most.max(spent));
                    reading = reading.max(read);
                }
                row(&estimate, |number: f32| out.put(number.to_le_bytes()))?;
            }
            Ok(())
        })?;
        out.flush()?;
        println!("samples={count}");
        println!("estimates_crc32={:08x}", out.checksum());
        println!("micro_steps={}", observer.joint.micro_steps());
        println!("update_instructions={most}");
        println!("update_instructions_least={least}");
        println!("estimate_instructions={reading}");
        println!("constant_bytes={}", size_of_val(&observer));
        println!("track_bytes={}", size_of_val(&track));
        Ok(())
    }

    #[inline(never)]
    fn update<const N: usize>(
        observer: &Observing<N>,
        track: &mut Track<f32, N>,
        sample: &Sample<f32>,
    ) -> Status {
        observer.update(track, sample)
    }

    #[inline(never)]
    fn read<const N: usize>(observer: &Observing<N>, track: &Track<f32, N>) -> Estimate<f32, N> {
        observer.estimate(track)
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("observe runs on a board: build it for thumbv7em-none-eabihf");
}
