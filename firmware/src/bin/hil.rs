//! `hil SAMPLES COMMANDS FRAMES`: the drive in the loop with a simulated plant.
//!
//! The path is the real one: an interrupt takes a sample, runs the session and puts messages into a
//! queue; the main program frames them. Only the ends are simulated: samples come from a file where
//! a timer and a converter would give them, and frames go to a file. The parameters are read from
//! the flash page, where the emulator has put them or nothing. Bytes of the command file are frames
//! whose sequence number is the sample before which the command is to act.
//!
//! `tick_instructions` is the most that a control period took in this run, from the sample to the
//! message in its queue, by QEMU's count on netduinoplus2; other boards do not count.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod on_board {
    use core::cell::RefCell;
    use core::sync::atomic::{AtomicU32, Ordering};

    use cortex_m::peripheral::SCB;
    use cortex_m::peripheral::syst::SystClkSource;
    use critical_section::Mutex;
    use firmware::board::{self, Access, Failure, InstructionCounter, Sink};
    use firmware::link::{self, Commands, Link, Messages};
    use firmware::session::{DEFAULT_RATE, Session};
    use heapless::mpmc::Queue;
    use joint_core::telemetry::frame::{MAX_FRAME, Reader};
    use joint_core::telemetry::{Command, Message, Sample, Status};
    use semihosting::println;

    /// Samples that the plant is ahead of the interrupt.
    const AHEAD: usize = 32;
    const SAMPLE_BYTES: usize = 16;
    /// Instructions between two interrupts, by the emulator's clock of one a nanosecond: 50 µs at
    /// its 168 MHz, and more than a control period takes.
    const PERIOD: u32 = 8_400;

    struct Owned {
        session: &'static mut Session,
        counter: Option<InstructionCounter>,
        /// Most instructions of a control period.
        most: u32,
    }

    /// What the interrupt owns.
    static SESSION: Mutex<RefCell<Option<Owned>>> = Mutex::new(RefCell::new(None));
    #[expect(deprecated)] // As in `link`: what fails is tried again.
    static PLANT: Queue<Sample, AHEAD> = Queue::new();
    static COMMANDS: Commands = link::commands();
    static MESSAGES: Messages = link::messages();
    static PERIODS: AtomicU32 = AtomicU32::new(0);

    #[cortex_m_rt::exception]
    fn SysTick() {
        critical_section::with(|cs| {
            let mut owned = SESSION.borrow_ref_mut(cs);
            let Some(Owned { session, counter, most }) = owned.as_mut() else { return };
            // The converter is done when the plant has a sample.
            let Some(sample) = PLANT.dequeue() else { return };
            while let Some(command) = COMMANDS.dequeue() {
                session.command(command);
            }
            let mut tick = || period(session, sample);
            match counter {
                Some(counter) => *most = (*most).max(counter.measure(tick).1),
                None => tick(),
            }
            PERIODS.fetch_add(1, Ordering::Relaxed);
        });
    }

    /// A control period, with a stack frame of its own wherever it is called from.
    #[inline(never)]
    fn period(session: &mut Session, sample: Sample) {
        session.tick(sample, 0, Status::default(), &MESSAGES);
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        board::finish(start().and_then(run))
    }

    /// Apart from what follows, so that neither has to share the stack with the other.
    #[inline(never)]
    fn start() -> Result<&'static mut Session, Failure> {
        let Some(session) = cortex_m::singleton!(: Session = Session::new()) else {
            return Err(Failure::Argument("session"));
        };
        let refusal = session.start(board::parameter_page())?;
        match refusal {
            None => println!("parameters=accepted"),
            Some(why) => println!("parameters={why}"),
        }
        println!("parameters_crc32={:08x}", session.hello().parameters_crc);
        println!("block_version={}", session.hello().block_version);
        println!("start_stack_bytes={}", board::stack_used());
        // Past the first report, so that every path is met: greeting, steps, a message.
        let bytes = board::stack_of(|| {
            for k in 0..=i32::from(DEFAULT_RATE) {
                let sample = Sample { motor_counts: k, ..Sample::default() };
                period(session, core::hint::black_box(sample));
            }
        });
        println!("tick_stack_bytes={bytes}");
        while MESSAGES.dequeue().is_some() {}
        if !cfg!(feature = "mps2") {
            session.command(Command::Rate(1));
            period(session, Sample::default());
            println!("frame_instructions={}", frame_instructions());
        }
        // Again from rest, as if it had not been.
        session.start(board::parameter_page())?;
        Ok(session)
    }

    /// Of making the frame of the report that waits, which the main program does outside of the
    /// interrupt.
    #[inline(never)]
    fn frame_instructions() -> u32 {
        let mut link = Link::default();
        let counter = InstructionCounter::start();
        counter.measure(|| link.send(&MESSAGES, |frame| !core::hint::black_box(frame).is_empty())).1
    }

    #[inline(never)]
    fn run(session: &'static mut Session) -> Result<(), Failure> {
        // The counter is a timer of the STM32; elsewhere its address is another's.
        let counter = (!cfg!(feature = "mps2")).then(InstructionCounter::start);
        let owned = Owned { session, counter, most: 0 };
        critical_section::with(|cs| SESSION.borrow_ref_mut(cs).replace(owned));

        let Some(mut core) = cortex_m::Peripherals::take() else {
            return Err(Failure::Argument("peripherals"));
        };
        core.SYST.set_clock_source(SystClkSource::Core);
        core.SYST.set_reload(PERIOD - 1);
        core.SYST.clear_current();
        core.SYST.enable_counter();
        core.SYST.enable_interrupt();

        let mut log = board::open(1, "samples", Access::Read)?;
        let mut orders = board::open(2, "commands", Access::Read)?;
        let mut frames = Sink::new(board::open(3, "frames", Access::Write)?, "frames");
        let mut order_bytes = [0; 512];
        let orders = board::fill(&mut orders, "commands", &mut order_bytes)?;
        let mut reader = Reader::default();
        let mut orders = orders.iter().filter_map(|byte| reader.push(*byte));
        let mut next = orders.next();
        let mut link = Link::default();
        let mut chunk = [0; 64 * SAMPLE_BYTES];
        let mut fed = 0;
        board::in_chunks(&mut log, "samples", &mut chunk, |bytes| {
            for sample in bytes.as_chunks().0 {
                while let Some(order) = next.as_ref().filter(|order| order.sequence <= fed) {
                    // The command is to find every earlier sample taken.
                    drain(fed, &mut link, &mut frames)?;
                    if let Message::Command(command) = order.message {
                        let _ = COMMANDS.enqueue(command);
                    }
                    next = orders.next();
                }
                while PLANT.enqueue(Sample::from_bytes(sample)).is_err() {
                    send(&mut link, &mut frames)?;
                }
                fed += 1;
            }
            Ok(())
        })?;
        drain(fed, &mut link, &mut frames)?;
        SCB::clear_pendst();
        core.SYST.disable_interrupt();
        while send(&mut link, &mut frames)? {}
        frames.flush()?;
        println!("samples={fed}");
        let most =
            critical_section::with(|cs| SESSION.borrow_ref(cs).as_ref().map_or(0, |own| own.most));
        println!("tick_instructions={most}");
        println!("frames_crc32={:08x}", frames.checksum());
        Ok(())
    }

    /// Sends what waits, until that many samples were taken.
    fn drain(fed: u32, link: &mut Link, frames: &mut Sink) -> Result<(), Failure> {
        while PERIODS.load(Ordering::Relaxed) < fed {
            send(link, frames)?;
        }
        Ok(())
    }

    fn send(link: &mut Link, frames: &mut Sink) -> Result<bool, Failure> {
        let mut bytes = [0; MAX_FRAME];
        let mut length = 0;
        let sent = link.send(&MESSAGES, |frame| {
            length = frame.len();
            bytes.iter_mut().zip(frame).for_each(|(to, from)| *to = *from);
            true
        });
        for byte in bytes.get(..length).unwrap_or_default() {
            frames.put_byte(*byte)?;
        }
        Ok(sent)
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("hil runs on a board: build it for thumbv7em-none-eabihf");
}
