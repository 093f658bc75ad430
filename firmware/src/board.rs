//! The emulated board: arguments, files, exit codes, and a counter of instructions.
//!
//! Everything goes through semihosting, which every board in QEMU has; no HAL, no clock set-up.
//! `unsafe` is for the registers of one timer, for what the linker placed, and for the fault
//! handler's signature.
#![allow(unsafe_code)]

use core::ffi::CStr;
use core::sync::atomic::{Ordering, compiler_fence};

use semihosting::fs::File;
use semihosting::io::{self, Read, Write};
use semihosting::{eprintln, println, process};

use crate::block::{Block, BlockError, PAGE_BYTES};
use crate::samples::Checksum;

/// Longest command line, and longest file name in it.
pub const ARGUMENT_BYTES: usize = 256;

/// Ends the program with 0, or says what went wrong and ends it with 1.
pub fn finish(result: Result<(), Failure>) -> ! {
    match result {
        Ok(()) => process::exit(0),
        Err(failure) => {
            eprintln!("error: {failure}");
            process::exit(1)
        }
    }
}

/// What a program on the board can fail with.
#[derive(Debug)]
pub enum Failure {
    /// The command line lacks this argument.
    Argument(&'static str),
    /// A file could not be opened, read or written.
    Io(&'static str, io::Error),
    /// The parameter block is refused.
    Block(BlockError),
}

impl core::fmt::Display for Failure {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Failure::Argument(name) => write!(f, "missing argument: {name}"),
            Failure::Io(name, error) => write!(f, "{name}: {error:?}"),
            Failure::Block(error) => write!(f, "{error}"),
        }
    }
}

impl From<BlockError> for Failure {
    fn from(error: BlockError) -> Self {
        Failure::Block(error)
    }
}

/// Opens the file that stands at this place of the command line (the program's name is 0).
///
/// # Errors
/// The argument is missing or too long, or the host refuses the file.
pub fn open(place: usize, name: &'static str, access: Access) -> Result<File, Failure> {
    let missing = Failure::Argument(name);
    let args = semihosting::experimental::env::args::<ARGUMENT_BYTES>()
        .map_err(|error| Failure::Io("command line", error))?;
    let Some(Ok(path)) = (&args).nth(place) else { return Err(missing) };
    let mut text = [0; ARGUMENT_BYTES + 1];
    let Some(target) = text.get_mut(..path.len()) else { return Err(missing) };
    target.copy_from_slice(path.as_bytes());
    let Ok(path) = CStr::from_bytes_until_nul(&text) else { return Err(missing) };
    let file = match access {
        Access::Read => File::open(path),
        Access::Write => File::create(path),
    };
    file.map_err(|error| Failure::Io(name, error))
}

/// What a file is opened for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// To read from its start.
    Read,
    /// To write anew.
    Write,
}

/// Fills the buffer as far as the file goes and returns what was read.
///
/// # Errors
/// The host could not read.
pub fn fill<'a>(
    file: &mut File,
    name: &'static str,
    buffer: &'a mut [u8],
) -> Result<&'a [u8], Failure> {
    let mut length = 0;
    while let Some(rest) = buffer.get_mut(length..).filter(|rest| !rest.is_empty()) {
        match file.read(rest).map_err(|error| Failure::Io(name, error))? {
            0 => break,
            read => length += read,
        }
    }
    Ok(buffer.get(..length).unwrap_or_default())
}

/// Hands a file's bytes to `work`, a buffer full at a time and the rest last.
///
/// # Errors
/// The host could not read, or what `work` fails with.
pub fn in_chunks(
    file: &mut File,
    name: &'static str,
    buffer: &mut [u8],
    mut work: impl FnMut(&[u8]) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let whole = buffer.len();
    loop {
        let bytes = fill(file, name, buffer)?;
        work(bytes)?;
        if bytes.len() < whole {
            return Ok(());
        }
    }
}

/// The parameter block in the file that is the first argument; says which it is.
///
/// # Errors
/// The file cannot be read, or the block is refused.
pub fn read_block(buffer: &mut [u8]) -> Result<Block<'_>, Failure> {
    let mut file = open(1, "parameters", Access::Read)?;
    let block = Block::check(fill(&mut file, "parameters", buffer)?)?;
    println!("parameters_crc32={:08x}", block.crc);
    println!("stages={}", block.stages);
    Ok(block)
}

/// A file written through a buffer, with the checksum of all that went into it.
#[derive(Debug)]
pub struct Sink {
    file: File,
    name: &'static str,
    buffer: [u8; 2048],
    length: usize,
    checksum: Checksum,
}

impl Sink {
    /// Writes into this file; `name` stands in error messages.
    pub fn new(file: File, name: &'static str) -> Self {
        Self { file, name, buffer: [0; 2048], length: 0, checksum: Checksum::default() }
    }

    /// Adds a word.
    ///
    /// # Errors
    /// The host could not write.
    pub fn put(&mut self, word: [u8; 4]) -> Result<(), Failure> {
        if self.length + word.len() > self.buffer.len() {
            self.flush()?;
        }
        if let Some(free) = self.buffer.get_mut(self.length..self.length + word.len()) {
            free.copy_from_slice(&word);
            self.length += word.len();
        }
        Ok(())
    }

    /// Adds a byte.
    ///
    /// # Errors
    /// The host could not write.
    pub fn put_byte(&mut self, byte: u8) -> Result<(), Failure> {
        if self.length == self.buffer.len() {
            self.flush()?;
        }
        if let Some(free) = self.buffer.get_mut(self.length) {
            *free = byte;
            self.length += 1;
        }
        Ok(())
    }

    /// Writes what is buffered; to be called once more at the end.
    ///
    /// # Errors
    /// The host could not write.
    pub fn flush(&mut self) -> Result<(), Failure> {
        let full = self.buffer.get(..self.length).unwrap_or_default();
        self.file.write_all(full).map_err(|error| Failure::Io(self.name, error))?;
        self.checksum.update(full);
        self.length = 0;
        Ok(())
    }

    /// CRC-32 of what was flushed.
    pub fn checksum(&self) -> u32 {
        self.checksum.value()
    }
}

/// Counts executed instructions by TIM2 of the netduinoplus2.
///
/// With `-icount shift=0,sleep=off` QEMU advances its clock by 1 ns per instruction and clocks this
/// timer at 1 GHz: one tick is one instruction, the same on every run. On silicon it would count
/// cycles of another clock and means nothing.
#[derive(Debug)]
pub struct InstructionCounter {
    empty: u32,
}

impl InstructionCounter {
    const CR1: *mut u32 = 0x4000_0000 as *mut u32;
    const CNT: *const u32 = 0x4000_0024 as *const u32;
    const ARR: *mut u32 = 0x4000_002c as *mut u32;

    /// Starts the timer and measures what the counting itself costs.
    pub fn start() -> Self {
        // SAFETY: the registers exist on this board, nobody else uses TIM2, and the writes touch
        // no memory: full period, then the enable bit.
        unsafe {
            Self::ARR.write_volatile(u32::MAX);
            Self::CR1.write_volatile(1);
        }
        let mut counter = Self { empty: 0 };
        counter.empty = counter.measure(|| ()).1;
        counter
    }

    /// Runs `work` and returns its result with the instructions executed in it, the call included
    /// where it was not inlined.
    #[inline(always)]
    pub fn measure<T>(&self, work: impl FnOnce() -> T) -> (T, u32) {
        let before = Self::now();
        let result = core::hint::black_box(work());
        let after = Self::now();
        (result, after.wrapping_sub(before).wrapping_sub(self.empty))
    }

    #[inline(always)]
    fn now() -> u32 {
        compiler_fence(Ordering::SeqCst);
        // SAFETY: a read of the counter register, which exists on this board and has no effect.
        let now = unsafe { Self::CNT.read_volatile() };
        compiler_fence(Ordering::SeqCst);
        now
    }
}

/// The flash page with the parameters.
pub fn parameter_page() -> &'static [u8] {
    unsafe extern "C" {
        /// From `memory.x`: the first address past the program's flash.
        static _parameter_page: [u8; PAGE_BYTES];
    }
    // SAFETY: the page is memory of the board that nothing writes while the program runs, and every
    // byte is a value.
    unsafe { &_parameter_page }
}

unsafe extern "C" {
    static mut _stack_start: u32;
    static mut _stack_end: u32;
}

/// What the runtime paints the stack with.
const PAINT: u32 = 0xcccc_cccc;

/// Bytes of stack that `work` uses, with the interrupts that come meanwhile.
#[inline(never)]
pub fn stack_of(work: impl FnOnce()) -> usize {
    let here = cortex_m::register::msp::read();
    // A little is left for this function's own calls.
    let top = (here - 64) as *mut u32;
    let mut at = &raw mut _stack_end;
    while at < top {
        // SAFETY: between the stack's end and what is in use of it there is nothing but what
        // returned functions have left.
        unsafe {
            at.write_volatile(PAINT);
            at = at.add(1);
        }
    }
    work();
    let all = stack_used();
    let above = (&raw const _stack_start as usize).saturating_sub(here as usize);
    all.saturating_sub(above)
}

/// Bytes of stack that were ever used since it was painted, by the runtime before the start or by
/// [`stack_of`].
pub fn stack_used() -> usize {
    let (top, bottom) = (&raw const _stack_start, &raw const _stack_end);
    let mut at = bottom;
    // SAFETY: both ends are the linker's; the words between them are RAM, read once each and only
    // up to the first that was used.
    unsafe {
        while at < top && at.read_volatile() == PAINT {
            at = at.add(1);
        }
    }
    (top as usize).saturating_sub(at as usize)
}

/// Bytes of stack that `work` uses below its caller, up to 4 KiB: what lies there is painted before and
/// looked at after.
#[inline(never)]
pub fn stack_used_by(work: impl FnOnce()) -> u32 {
    const WORDS: usize = 1024;
    const PAINT: u32 = 0xa5c3_5a3c;
    // Room for this function's own frame.
    const KEPT: usize = 32;
    let top = cortex_m::register::msp::read() as *mut u32;
    for k in KEPT..WORDS {
        // SAFETY: below the stack pointer nobody keeps anything, and the stack has more room.
        unsafe { top.wrapping_sub(k).write_volatile(PAINT) };
    }
    work();
    let painted = (KEPT..WORDS)
        .rev()
        // SAFETY: as above; reading what was painted.
        .take_while(|k| unsafe { top.wrapping_sub(*k).read_volatile() } == PAINT)
        .count();
    ((WORDS - painted) * size_of::<u32>()) as u32
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    eprintln!("{info}");
    process::exit(101)
}

/// Ends the run instead of hanging it.
///
/// SAFETY: `unsafe` is the signature that the runtime asks for; the handler only reads the frame.
#[cortex_m_rt::exception]
unsafe fn HardFault(frame: &cortex_m_rt::ExceptionFrame) -> ! {
    eprintln!("hard fault at {:#010x}", frame.pc());
    process::exit(134)
}
