//! Where bytes come in beside the host's files: parameter blocks, telemetry, calls of the C library and of the
//! FMU; `entry.rs` is the files' side. Nothing here needs the host's crate, which takes minutes to compile.

#![allow(dead_code, reason = "a fuzz target calls one of them")]

#[path = "calls.rs"]
mod calls;

use firmware::any_control::AnyControl;
use firmware::block::Block;
use joint_core::telemetry::frame::{CRC32, Reader, encode};
use joint_core::telemetry::{Sample, Status};

#[allow(unused_imports, reason = "a fuzz target calls one of them")]
pub(crate) use calls::{capi, fmu};

/// A block is refused by name, or the drive steps on it and reports finite numbers, also with its checksum
/// put right.
pub(crate) fn block(bytes: &[u8]) {
    stepped(bytes);
    stepped(&with_checksum(bytes));
}

/// The same block with the length and the checksum that its bytes have.
fn with_checksum(bytes: &[u8]) -> Vec<u8> {
    let mut whole = bytes.to_vec();
    if let Some(body) = whole.len().checked_sub(4) {
        if let Some(payload) = body.checked_sub(12)
            && let Some(length) = whole.get_mut(8..12)
        {
            length.copy_from_slice(&(payload as u32).to_le_bytes());
        }
        let checksum = CRC32.checksum(&whole[..body]).to_le_bytes();
        whole[body..].copy_from_slice(&checksum);
    }
    whole
}

fn stepped(bytes: &[u8]) {
    let Ok(block) = Block::in_page(bytes) else { return };
    let mut control = Box::new(AnyControl::NotStarted);
    if let Err(error) = control.read(&block, Status(0)) {
        assert!(!error.to_string().is_empty());
        return;
    }
    for k in 0..100_i32 {
        let sample = Sample {
            motor_counts: 13 * k,
            output_counts: k,
            current_a: 0.01 * (k % 7) as f32,
            voltage_v: 0.1 * (k % 11) as f32,
        };
        control.tick(sample, u32::from(k % 50 == 49));
    }
}

/// Of any bytes frames are found or not; what is found is the same after it was sent again. Also with the
/// checksums put right.
pub(crate) fn frames(bytes: &[u8]) {
    found(bytes);
    found(&with_checksums(bytes));
}

/// The same stream with the checksums that its frames have.
fn with_checksums(bytes: &[u8]) -> Vec<u8> {
    let mut stream = bytes.to_vec();
    let mut at = 0;
    while let Some([0xa5, 0x5a, _, length]) = stream.get(at..).and_then(|it| it.first_chunk()) {
        let end = at + 8 + usize::from(*length);
        let Some(place) = stream.get(end..end + 4).map(|_| end..end + 4) else { break };
        let checksum = CRC32.checksum(&stream[at + 2..end]).to_le_bytes();
        stream[place].copy_from_slice(&checksum);
        at = end + 4;
    }
    stream
}

fn found(bytes: &[u8]) {
    let mut reader = Reader::default();
    let mut found: Vec<_> = bytes.iter().filter_map(|byte| reader.push(*byte)).collect();
    while let Some(frame) = reader.rest() {
        found.push(frame);
    }
    for frame in found {
        let sent = encode(&frame.message, frame.sequence);
        assert!(!sent.is_empty(), "{frame:?}");
        let mut reader = Reader::default();
        let again = sent.iter().find_map(|byte| reader.push(*byte));
        let again = again.map(|it| encode(&it.message, it.sequence));
        assert_eq!(again.as_deref(), Some(&sent[..]), "{frame:?}");
    }
}
