//! Real-time transfer: rings in RAM that a debug probe reads and writes while the program runs.
//!
//! The layout is SEGGER's and found by its name. It is written here because what the usual crates
//! do where a program errs is to panic, and this firmware is linked only if it cannot. Rings are
//! made of atomics, so the one `unsafe` is to say that the pointers to them may be shared.
#![allow(unsafe_code)]

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

/// A ring of bytes.
pub type Ring<const N: usize> = [AtomicU8; N];

/// One direction of one channel, as the probe finds it.
#[repr(C)]
#[derive(Debug)]
pub struct Channel {
    name: *const u8,
    buffer: *const AtomicU8,
    size: u32,
    written: AtomicU32,
    read: AtomicU32,
    flags: AtomicU32,
}

// SAFETY: the pointers are to statics, a text and a ring of atomics; all else is atomic.
unsafe impl Sync for Channel {}

/// The control block: two channels up, two down. Telemetry and commands have the same number, as a
/// debug server that passes on one channel both ways wants it.
#[repr(C)]
#[derive(Debug)]
pub struct ControlBlock {
    id: [AtomicU32; 4],
    ups: AtomicU32,
    downs: AtomicU32,
    up: [Channel; 2],
    down: [Channel; 2],
}

impl Channel {
    /// A channel over a ring; the name ends in a zero.
    pub const fn new<const N: usize>(name: &'static [u8], ring: &'static Ring<N>) -> Self {
        const { assert!(N >= 2, "one byte of a ring stays free") };
        Self {
            name: name.as_ptr(),
            buffer: ring.as_ptr(),
            size: N as u32,
            written: AtomicU32::new(0),
            read: AtomicU32::new(0),
            flags: AtomicU32::new(0),
        }
    }

    fn byte(&self, at: u32) -> Option<&AtomicU8> {
        if at < self.size {
            // SAFETY: the place is inside the ring, which is a static.
            Some(unsafe { &*self.buffer.add(at as usize) })
        } else {
            None
        }
    }

    /// Writes all of it, or, where there is no room, nothing.
    pub fn write(&self, bytes: &[u8]) -> bool {
        let mut at = self.written.load(Ordering::Relaxed);
        let read = self.read.load(Ordering::Acquire);
        if at >= self.size || read >= self.size {
            return false;
        }
        let free = if read > at { read - at - 1 } else { self.size - 1 - (at - read) };
        if bytes.len() > free as usize {
            return false;
        }
        for byte in bytes {
            if let Some(slot) = self.byte(at) {
                slot.store(*byte, Ordering::Relaxed);
            }
            at += 1;
            if at == self.size {
                at = 0;
            }
        }
        self.written.store(at, Ordering::Release);
        true
    }

    /// Takes out the oldest byte.
    pub fn read(&self) -> Option<u8> {
        let at = self.read.load(Ordering::Relaxed);
        if at == self.written.load(Ordering::Acquire) {
            return None;
        }
        let byte = self.byte(at)?.load(Ordering::Relaxed);
        let next = at + 1;
        self.read.store(if next >= self.size { 0 } else { next }, Ordering::Release);
        Some(byte)
    }
}

impl ControlBlock {
    /// A block without its name, so that its image in flash is not taken for it.
    pub const fn new(up: [Channel; 2], down: [Channel; 2]) -> Self {
        Self {
            id: [const { AtomicU32::new(0) }; 4],
            ups: AtomicU32::new(2),
            downs: AtomicU32::new(2),
            up,
            down,
        }
    }

    /// Writes the name, and may be found from now on.
    pub fn publish(&self) {
        let [a, b, c, d] = &self.id;
        d.store(0, Ordering::Relaxed);
        c.store(u32::from_le_bytes([b'T', b'T', 0, 0]), Ordering::Relaxed);
        b.store(u32::from_le_bytes(*b"ER R"), Ordering::Relaxed);
        a.store(u32::from_le_bytes(*b"SEGG"), Ordering::Release);
    }

    /// Up channel 0: events, by defmt.
    pub fn events(&self) -> &Channel {
        let [events, _] = &self.up;
        events
    }

    /// Up channel 1: telemetry frames.
    pub fn telemetry(&self) -> &Channel {
        let [_, telemetry] = &self.up;
        telemetry
    }

    /// Down channel 1: command frames.
    pub fn commands(&self) -> &Channel {
        let [_, commands] = &self.down;
        commands
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    static RING: Ring<8> = [const { AtomicU8::new(0) }; 8];

    #[test]
    fn a_frame_goes_in_whole_or_not_at_all_and_comes_out_in_order() {
        let channel = Channel::new(b"test\0", &RING);
        for round in 0..20_u8 {
            let frame = [round, round + 1, round + 2, round + 3, round + 4];
            assert!(channel.write(&frame));
            assert!(!channel.write(&[1, 2, 3]), "two are free");
            assert!(channel.write(&[77, 78]));
            for byte in frame.into_iter().chain([77, 78]) {
                assert_eq!(channel.read(), Some(byte));
            }
            assert_eq!(channel.read(), None);
        }
    }

    #[test]
    fn a_probe_that_writes_nonsense_is_survived() {
        let channel = Channel::new(b"test\0", &RING);
        channel.read.store(1_000, Ordering::Relaxed);
        assert!(!channel.write(&[1]));
        assert_eq!(channel.read(), None);
    }
}
