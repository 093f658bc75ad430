//! The parameter block: what the host exports and the drive trusts.
//!
//! A drive that starts with parameters of another release, or with a page half written, moves a
//! real joint wrongly. The block therefore says what it is before it is decoded. All numbers are
//! little-endian:
//!
//! | bytes | what |
//! |---|---|
//! | 4 | magic `JNTP` |
//! | 2 | version of this table and of the payload's type, [`VERSION`] |
//! | 1 | number of gear stages |
//! | 1 | zero |
//! | 4 | length of the payload |
//! | n | payload: the per-unit coefficients, encoded by postcard |
//! | 4 | CRC-32 (ISO-HDLC) of all bytes before it |

use core::fmt;

use crc::{CRC_32_ISO_HDLC, Crc};
use serde::{Serialize, de::DeserializeOwned};

/// Version of the table above and of the payload; raised whenever either changes.
pub const VERSION: u16 = 2;
/// Bytes before the payload.
pub const HEADER_BYTES: usize = 12;
/// Bytes after the payload.
pub const CRC_BYTES: usize = 4;

const MAGIC: [u8; 4] = *b"JNTP";
pub(crate) const CRC32: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Why a block is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockError {
    /// It does not begin with the magic: not a parameter block.
    Magic,
    /// Written for another version.
    Version(u16),
    /// Shorter or longer than its header says.
    Length,
    /// The checksum stored and the checksum found.
    Crc {
        /// As it stands in the block.
        stored: u32,
        /// Over the bytes before it.
        found: u32,
    },
    /// The joint has another number of stages than the program was built for.
    Stages(u8),
    /// The payload is not what this version's type looks like.
    Payload,
    /// The buffer is too small to write the block into.
    NoRoom,
}

impl fmt::Display for BlockError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BlockError::Magic => f.write_str("not a parameter block"),
            BlockError::Version(found) => {
                write!(f, "parameter block of version {found}, expected {VERSION}")
            }
            BlockError::Length => f.write_str("parameter block of the wrong length"),
            BlockError::Crc { stored, found } => {
                write!(f, "parameter block damaged: CRC {stored:08x} stored, {found:08x} found")
            }
            BlockError::Stages(found) => {
                write!(f, "parameter block for {found} stages does not fit this program")
            }
            BlockError::Payload => f.write_str("parameter block with an unreadable payload"),
            BlockError::NoRoom => f.write_str("no room for the parameter block"),
        }
    }
}

impl core::error::Error for BlockError {}

/// Writes a block with these coefficients into `out` and returns its length.
///
/// # Errors
/// [`BlockError::NoRoom`] where `out` is too small.
pub fn encode<T: Serialize>(
    parameters: &T,
    stages: u8,
    out: &mut [u8],
) -> Result<usize, BlockError> {
    let (header, rest) = out.split_at_mut_checked(HEADER_BYTES).ok_or(BlockError::NoRoom)?;
    let length = postcard::to_slice(parameters, rest).map_err(|_| BlockError::NoRoom)?.len();
    let [v0, v1] = VERSION.to_le_bytes();
    header[..4].copy_from_slice(&MAGIC);
    header[4..8].copy_from_slice(&[v0, v1, stages, 0]);
    let stated = u32::try_from(length).map_err(|_| BlockError::NoRoom)?;
    header[8..].copy_from_slice(&stated.to_le_bytes());
    let end = HEADER_BYTES + length;
    let crc = CRC32.checksum(&out[..end]).to_le_bytes();
    out.get_mut(end..end + CRC_BYTES).ok_or(BlockError::NoRoom)?.copy_from_slice(&crc);
    Ok(end + CRC_BYTES)
}

/// A block whose header and checksum are right; the payload is still to be decoded.
#[derive(Clone, Copy, Debug)]
pub struct Block<'a> {
    /// Number of gear stages.
    pub stages: u8,
    /// The checksum, which tells one set of parameters from another.
    pub crc: u32,
    payload: &'a [u8],
}

impl<'a> Block<'a> {
    /// Checks the frame of a block: magic, version, length, checksum.
    ///
    /// # Errors
    /// The first of them that is wrong.
    pub fn check(bytes: &'a [u8]) -> Result<Self, BlockError> {
        let (body, stored) = bytes.split_last_chunk::<CRC_BYTES>().ok_or(BlockError::Magic)?;
        let (header, payload) =
            body.split_first_chunk::<HEADER_BYTES>().ok_or(BlockError::Magic)?;
        let [m0, m1, m2, m3, v0, v1, stages, _, l0, l1, l2, l3] = *header;
        if [m0, m1, m2, m3] != MAGIC {
            return Err(BlockError::Magic);
        }
        let version = u16::from_le_bytes([v0, v1]);
        if version != VERSION {
            return Err(BlockError::Version(version));
        }
        if usize::try_from(u32::from_le_bytes([l0, l1, l2, l3])) != Ok(payload.len()) {
            return Err(BlockError::Length);
        }
        let (stored, found) = (u32::from_le_bytes(*stored), CRC32.checksum(body));
        if stored != found {
            return Err(BlockError::Crc { stored, found });
        }
        Ok(Self { stages, crc: stored, payload })
    }

    /// The coefficients.
    ///
    /// # Errors
    /// [`BlockError::Payload`] where they are not what `T` looks like.
    pub fn decode<T: DeserializeOwned>(&self) -> Result<T, BlockError> {
        match postcard::take_from_bytes(self.payload) {
            Ok((parameters, [])) => Ok(parameters),
            _ => Err(BlockError::Payload),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block() -> Vec<u8> {
        let mut bytes = [0; 64];
        let length = encode(&[1.5_f32, -2.0, 3.25], 2, &mut bytes).unwrap();
        bytes[..length].to_vec()
    }

    #[test]
    fn a_block_gives_back_what_went_in() {
        let bytes = block();
        let block = Block::check(&bytes).unwrap();
        assert_eq!(block.stages, 2);
        assert_eq!(block.decode::<[f32; 3]>(), Ok([1.5, -2.0, 3.25]));
        assert_eq!(block.decode::<[f32; 2]>(), Err(BlockError::Payload));
    }

    #[test]
    fn any_flipped_bit_is_noticed() {
        let bytes = block();
        for bit in 0..bytes.len() * 8 {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert!(Block::check(&damaged).is_err(), "bit {bit}");
        }
    }

    #[test]
    fn a_block_cut_short_is_refused_at_every_length() {
        let bytes = block();
        for length in 0..bytes.len() {
            assert!(Block::check(&bytes[..length]).is_err(), "length {length}");
        }
    }

    #[test]
    fn a_buffer_too_small_is_an_error_at_every_length() {
        let whole = block().len();
        for length in 0..whole {
            let mut out = vec![0; length];
            assert_eq!(encode(&[1.5_f32, -2.0, 3.25], 2, &mut out), Err(BlockError::NoRoom));
        }
    }
}
