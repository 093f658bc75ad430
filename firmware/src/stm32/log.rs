//! Events by defmt, over the first RTT channel.
//!
//! A frame is put together apart and goes into the ring whole or not at all: a ring that overflows
//! then loses events, not the decoder's place.
#![allow(unsafe_code)]

use core::cell::UnsafeCell;
use core::sync::atomic::AtomicU8;

use crate::rtt::{Channel, ControlBlock, Ring};

static EVENTS: Ring<512> = [const { AtomicU8::new(0) }; 512];
static TELEMETRY: Ring<1024> = [const { AtomicU8::new(0) }; 1024];
static NOTHING: Ring<2> = [const { AtomicU8::new(0) }; 2];
static COMMANDS: Ring<128> = [const { AtomicU8::new(0) }; 128];

/// The rings, as a debug probe finds them.
#[unsafe(export_name = "_SEGGER_RTT")]
pub static RTT: ControlBlock = ControlBlock::new(
    [Channel::new(b"defmt\0", &EVENTS), Channel::new(b"telemetry\0", &TELEMETRY)],
    [Channel::new(b"none\0", &NOTHING), Channel::new(b"commands\0", &COMMANDS)],
);

/// Longest event.
const FRAME: usize = 96;

struct Staging {
    encoder: defmt::Encoder,
    frame: [u8; FRAME],
    length: usize,
    /// How deep; only the outermost writes.
    depth: u32,
    restore: critical_section::RestoreState,
}

struct Shared(UnsafeCell<Staging>);

// SAFETY: it is touched between `acquire` and `release` only, with interrupts off, on one core.
unsafe impl Sync for Shared {}

static STAGING: Shared = Shared(UnsafeCell::new(Staging {
    encoder: defmt::Encoder::new(),
    frame: [0; FRAME],
    length: 0,
    depth: 0,
    restore: critical_section::RestoreState::invalid(),
}));

#[defmt::global_logger]
struct Logger;

fn stage(frame: &mut [u8; FRAME], length: &mut usize, bytes: &[u8]) {
    match frame.get_mut(*length..).and_then(|rest| rest.get_mut(..bytes.len())) {
        Some(room) => {
            room.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from);
            *length += bytes.len();
        }
        // Too long an event is dropped whole.
        None => *length = FRAME + 1,
    }
}

// SAFETY: a section with interrupts off is entered in `acquire` and left in `release`, which defmt
// calls in pairs; what it logs while it logs is left out.
unsafe impl defmt::Logger for Logger {
    fn acquire() {
        // SAFETY: left again in `release`.
        let restore = unsafe { critical_section::acquire() };
        // SAFETY: interrupts are off, and no other reference is alive.
        let own = unsafe { &mut *STAGING.0.get() };
        own.depth += 1;
        if own.depth == 1 {
            own.restore = restore;
            own.length = 0;
            let Staging { encoder, frame, length, .. } = own;
            encoder.start_frame(|bytes| stage(frame, length, bytes));
        }
    }

    unsafe fn flush() {}

    unsafe fn release() {
        // SAFETY: as in `acquire`.
        let own = unsafe { &mut *STAGING.0.get() };
        own.depth = own.depth.saturating_sub(1);
        if own.depth > 0 {
            return;
        }
        let Staging { encoder, frame, length, .. } = own;
        encoder.end_frame(|bytes| stage(frame, length, bytes));
        if let Some(whole) = own.frame.get(..own.length) {
            RTT.events().write(whole);
        }
        let restore = own.restore;
        // SAFETY: entered in `acquire`.
        unsafe { critical_section::release(restore) };
    }

    unsafe fn write(bytes: &[u8]) {
        // SAFETY: as in `acquire`.
        let own = unsafe { &mut *STAGING.0.get() };
        if own.depth == 1 {
            let Staging { encoder, frame, length, .. } = own;
            encoder.write(bytes, |bytes| stage(frame, length, bytes));
        }
    }
}
