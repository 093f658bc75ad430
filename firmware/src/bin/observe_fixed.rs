//! `observe-fixed PARAMETERS LOG`: the fixed-point observer over a log, on a chip without a
//! floating-point unit.
//!
//! Built for `thumbv7em-none-eabi` it must not contain a single floating-point routine. It prints the
//! instructions of an update and of a reading, least and most over the log (exact on netduinoplus2),
//! and a checksum of the readings' bits, which must be the host's.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod on_board {
    use firmware::block::Block;
    use firmware::board::{self, Access, Failure, InstructionCounter};
    use firmware::observing::{RECORD_BYTES, fixed_from_bytes, fixed_row};
    use joint_core::fixed::Fixed;
    use joint_core::observer::{Estimate, Observer, Sample, Status, Track};
    use joint_core::telemetry::frame::CRC32;
    use semihosting::println;

    /// Most bytes of a parameter block.
    const BLOCK_BYTES: usize = 8192;
    /// Records read from the log at once.
    const RECORDS: usize = 128;
    /// Samples at the start that are not counted: there the first angle and speed are found.
    const START: usize = 20;

    #[cortex_m_rt::entry]
    fn main() -> ! {
        board::finish(run())
    }

    fn run() -> Result<(), Failure> {
        let mut bytes = [0; BLOCK_BYTES];
        let mut file = board::open(1, "parameters", Access::Read)?;
        let bytes = board::fill(&mut file, "parameters", &mut bytes)?;
        let observer: Observer<Fixed, 2> = Block::check(bytes)?.decode()?;
        let mut track = observer.start(0);
        let mut log = board::open(2, "log", Access::Read)?;
        let counter = InstructionCounter::start();
        let mut digest = CRC32.digest();
        let mut chunk = [0; RECORDS * RECORD_BYTES];
        let (mut count, mut least, mut most, mut reading) = (0, u32::MAX, 0, 0);
        loop {
            let bytes = board::fill(&mut log, "log", &mut chunk)?;
            for record in bytes.as_chunks::<RECORD_BYTES>().0 {
                let sample = fixed_from_bytes(record);
                let (_, spent) = counter.measure(|| update(&observer, &mut track, &sample));
                let (found, read) = counter.measure(|| read(&observer, &track));
                count += 1;
                if count > START {
                    (least, most) = (least.min(spent), most.max(spent));
                    reading = reading.max(read);
                }
                fixed_row(&found, |bits| digest.update(&bits.to_le_bytes()));
            }
            if bytes.len() < RECORDS * RECORD_BYTES {
                break;
            }
        }
        println!("samples={count}");
        println!("readings_crc32={:08x}", digest.finalize());
        println!("update_instructions={most}");
        println!("update_instructions_least={least}");
        println!("reading_instructions={reading}");
        println!("constant_bytes={}", size_of_val(&observer));
        println!("track_bytes={}", size_of_val(&track));
        Ok(())
    }

    #[inline(never)]
    fn update(
        observer: &Observer<Fixed, 2>,
        track: &mut Track<Fixed, 2>,
        sample: &Sample<Fixed>,
    ) -> Status {
        observer.update(track, sample)
    }

    #[inline(never)]
    fn read(observer: &Observer<Fixed, 2>, track: &Track<Fixed, 2>) -> Estimate<Fixed, 2> {
        observer.reading(track)
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("observe-fixed runs on a board: build it for thumbv7em-none-eabi");
}
