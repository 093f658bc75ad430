//! Messages as bytes that may get lost.
//!
//! | bytes | what |
//! |---|---|
//! | 2 | `a5 5a` |
//! | 1 | kind of the message |
//! | 1 | length n of the payload |
//! | 4 | sequence number, one more with every frame, dropped ones included |
//! | n | payload |
//! | 4 | CRC-32 (ISO-HDLC) of everything from the kind on |
//!
//! Numbers are little-endian. A reader that comes in the middle, or meets damage, looks for the next
//! `a5 5a` with a right checksum behind it.

use crc::{CRC_32_ISO_HDLC, Crc, Table};
use heapless::Vec;

use super::Message;

/// The checksum of frames and of parameter blocks.
pub static CRC32: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// Most bytes of a payload.
pub const MAX_PAYLOAD: usize = 200;
/// Most bytes of a frame.
pub const MAX_FRAME: usize = HEAD + MAX_PAYLOAD + TAIL;

const HEAD: usize = 8;
const TAIL: usize = 4;
const SYNC: [u8; 2] = [0xa5, 0x5a];

/// A message as a frame; what does not fit into [`MAX_PAYLOAD`] is no message of this protocol and
/// gives an empty frame.
pub fn encode(message: &Message, sequence: u32) -> Vec<u8, MAX_FRAME> {
    let mut payload = [0; MAX_PAYLOAD];
    let mut put = Put::new(&mut payload);
    message.put(&mut put);
    let (whole, length) = (put.whole, put.at);
    let mut frame = Vec::new();
    let mut push = |bytes: &[u8]| frame.extend_from_slice(bytes).is_ok();
    let fits = whole
        && push(&SYNC)
        && push(&[message.kind(), length as u8])
        && push(&sequence.to_le_bytes())
        && push(payload.get(..length).unwrap_or_default());
    if !fits {
        return Vec::new();
    }
    let crc = CRC32.checksum(frame.get(SYNC.len()..).unwrap_or_default());
    if frame.extend_from_slice(&crc.to_le_bytes()).is_err() {
        frame.clear();
    }
    frame
}

/// A frame that arrived whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Its number.
    pub sequence: u32,
    /// What it holds.
    pub message: Message,
}

/// Finds frames in a stream of bytes.
#[derive(Clone, Debug, Default)]
pub struct Reader {
    buffer: Vec<u8, MAX_FRAME>,
    /// Bytes that belonged to no whole frame.
    pub skipped: u32,
}

impl Reader {
    /// Takes in one byte and gives the frame that it completes. After damage a second frame may lie
    /// ready: it comes with the next byte, or from [`Reader::rest`].
    pub fn push(&mut self, byte: u8) -> Option<Frame> {
        if self.buffer.push(byte).is_err() {
            // Cannot be: a full buffer is a whole frame, which `rest` has taken out.
            self.drop_first(1);
        }
        self.rest()
    }

    /// The next frame that is whole in what was taken in.
    pub fn rest(&mut self) -> Option<Frame> {
        loop {
            let start = self.buffer.iter().position(|byte| *byte == SYNC[0]);
            match start {
                None => {
                    let all = self.buffer.len();
                    self.skip(all);
                    return None;
                }
                Some(at) => self.skip(at),
            }
            match whole(&self.buffer) {
                Whole::NotYet => return None,
                Whole::Never => self.skip(1),
                Whole::Frame(frame, length) => {
                    self.drop_first(length);
                    return Some(frame);
                }
            }
        }
    }

    fn skip(&mut self, count: usize) {
        self.skipped = self.skipped.wrapping_add(count as u32);
        self.drop_first(count);
    }

    fn drop_first(&mut self, count: usize) {
        let left = self.buffer.len().saturating_sub(count);
        if count == 0 {
            return;
        }
        for at in 0..left {
            if let Some(byte) = self.buffer.get(at + count).copied()
                && let Some(slot) = self.buffer.get_mut(at)
            {
                *slot = byte;
            }
        }
        self.buffer.truncate(left);
    }
}

#[expect(clippy::large_enum_variant, reason = "there is no heap to put it into")]
enum Whole {
    NotYet,
    Never,
    Frame(Frame, usize),
}

/// What the bytes from a sync byte on are.
fn whole(bytes: &[u8]) -> Whole {
    if bytes.get(1).is_some_and(|byte| *byte != SYNC[1]) {
        return Whole::Never;
    }
    let Some((head, rest)) = bytes.split_first_chunk::<HEAD>() else { return Whole::NotYet };
    let [_, _, kind, length, s0, s1, s2, s3] = *head;
    let length = usize::from(length);
    if length > MAX_PAYLOAD {
        return Whole::Never;
    }
    let Some((payload, tail)) = rest.split_at_checked(length) else { return Whole::NotYet };
    let Some(stored) = tail.first_chunk::<TAIL>() else { return Whole::NotYet };
    let checked = bytes.get(SYNC.len()..HEAD + length).unwrap_or_default();
    if CRC32.checksum(checked) != u32::from_le_bytes(*stored) {
        return Whole::Never;
    }
    let mut get = Get::new(payload);
    match Message::get(kind, &mut get) {
        Some(message) if get.is_empty() => {
            let sequence = u32::from_le_bytes([s0, s1, s2, s3]);
            Whole::Frame(Frame { sequence, message }, HEAD + length + TAIL)
        }
        _ => Whole::Never,
    }
}

/// Writes little-endian numbers as far as there is room.
pub(crate) struct Put<'a> {
    bytes: &'a mut [u8],
    at: usize,
    whole: bool,
}

impl<'a> Put<'a> {
    pub(crate) fn new(bytes: &'a mut [u8]) -> Self {
        Self { bytes, at: 0, whole: true }
    }

    fn raw<const N: usize>(&mut self, value: [u8; N]) {
        let room = self.bytes.get_mut(self.at..).and_then(|rest| rest.first_chunk_mut::<N>());
        match room {
            Some(room) => {
                *room = value;
                self.at += N;
            }
            None => self.whole = false,
        }
    }

    pub(crate) fn u8(&mut self, value: u8) {
        self.raw([value]);
    }
    pub(crate) fn u16(&mut self, value: u16) {
        self.raw(value.to_le_bytes());
    }
    pub(crate) fn u32(&mut self, value: u32) {
        self.raw(value.to_le_bytes());
    }
    pub(crate) fn i32(&mut self, value: i32) {
        self.raw(value.to_le_bytes());
    }
    pub(crate) fn f32(&mut self, value: f32) {
        self.raw(value.to_le_bytes());
    }
}

/// Reads them back; `None` where there is nothing left.
pub(crate) struct Get<'a> {
    bytes: &'a [u8],
}

impl<'a> Get<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    fn raw<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.bytes.split_first_chunk::<N>()?;
        self.bytes = rest;
        Some(*first)
    }

    pub(crate) fn u8(&mut self) -> Option<u8> {
        self.raw().map(|[byte]| byte)
    }
    pub(crate) fn u16(&mut self) -> Option<u16> {
        self.raw().map(u16::from_le_bytes)
    }
    pub(crate) fn u32(&mut self) -> Option<u32> {
        self.raw().map(u32::from_le_bytes)
    }
    pub(crate) fn i32(&mut self) -> Option<i32> {
        self.raw().map(i32::from_le_bytes)
    }
    pub(crate) fn f32(&mut self) -> Option<f32> {
        self.raw().map(f32::from_le_bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{
        CaptureHead, Command, Hello, MAX_SAMPLES, Mode, Quantities, Report, Sample, Status, Trigger,
    };
    use super::*;

    fn messages() -> std::vec::Vec<Message> {
        let sample =
            Sample { voltage_v: 1.5, current_a: -0.25, motor_counts: -7, output_counts: 9 };
        let estimates = Quantities { load_torque_nm: 0.125, ..Quantities::default() };
        let mut samples = Vec::new();
        for k in 0..MAX_SAMPLES {
            samples.push(Sample { motor_counts: k as i32, ..sample }).unwrap();
        }
        let mut all = vec![
            Message::Hello(Hello { mode: Mode::Parameters, stages: 2, ..Hello::default() }),
            Message::CaptureHead(CaptureHead { samples: 5, trigger_at: 2, first_tick: 77 }),
            Message::Samples(40, samples),
            Message::Dropped(3),
        ];
        for stages in 0..=3 {
            let status = Status::LATE.with(Status::DEFAULTS);
            let report = Report { tick: 1, status, stages, sample, estimates, ..Report::default() };
            all.push(Message::Report(report));
        }
        for trigger in [
            Trigger::Now,
            Trigger::CurrentAbove(1.5),
            Trigger::Status(Status::LATE),
            Trigger::Reversal,
        ] {
            all.push(Message::Command(Command::Arm { trigger, after: 100 }));
        }
        let commands = [
            Command::Hello,
            Command::Rate(20),
            Command::Fetch,
            Command::Disarm,
            Command::Duty(0.5),
        ];
        all.extend(commands.map(Message::Command));
        all
    }

    fn read(bytes: &[u8]) -> (std::vec::Vec<Frame>, u32) {
        let mut reader = Reader::default();
        let mut frames: std::vec::Vec<Frame> =
            bytes.iter().filter_map(|byte| reader.push(*byte)).collect();
        frames.extend(std::iter::from_fn(|| reader.rest()));
        (frames, reader.skipped)
    }

    fn stream() -> (std::vec::Vec<Frame>, std::vec::Vec<u8>) {
        let frames: std::vec::Vec<Frame> = messages()
            .into_iter()
            .zip(1000..)
            .map(|(message, sequence)| Frame { sequence, message })
            .collect();
        let bytes = frames.iter().flat_map(|frame| encode(&frame.message, frame.sequence));
        let bytes = bytes.collect();
        (frames, bytes)
    }

    #[test]
    fn every_message_survives_the_wire() {
        let (frames, bytes) = stream();
        assert!(frames.iter().all(|frame| !encode(&frame.message, 0).is_empty()));
        assert_eq!(read(&bytes), (frames, 0));
    }

    #[test]
    fn a_reader_that_comes_late_misses_one_frame_at_most() {
        let (frames, bytes) = stream();
        let mut at = 0;
        for (k, frame) in frames.iter().enumerate() {
            let length = encode(&frame.message, frame.sequence).len();
            for cut in at + 1..at + length {
                assert_eq!(read(&bytes[cut..]).0, frames[k + 1..], "cut at {cut}");
            }
            at += length;
        }
    }

    #[test]
    fn any_damaged_byte_costs_its_own_frame_and_no_other_and_never_a_wrong_number() {
        let (frames, bytes) = stream();
        let mut at = 0;
        for (k, frame) in frames.iter().enumerate() {
            let length = encode(&frame.message, frame.sequence).len();
            for bad in at..at + length {
                let mut damaged = bytes.clone();
                damaged[bad] ^= 0x10;
                let (found, _) = read(&damaged);
                let mut left = frames.clone();
                left.remove(k);
                // A length that grew may swallow the end of the stream.
                assert!(left.starts_with(&found) && found.len() + 2 >= left.len(), "byte {bad}");
            }
            at += length;
        }
    }

    #[test]
    fn any_bytes_are_taken_in_without_a_panic() {
        let mut seed = 1_u32;
        let noise = std::iter::from_fn(|| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            Some(if seed >> 30 == 0 { 0xa5 } else { (seed >> 24) as u8 })
        });
        let (frames, skipped) = read(&noise.take(50_000).collect::<std::vec::Vec<u8>>());
        assert!(frames.is_empty() && skipped > 49_000);
    }
}
