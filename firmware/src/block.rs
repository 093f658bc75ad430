//! The parameter block: what the host exports and the drive trusts.
//!
//! A drive that starts with parameters of another release, or with a page half written, moves a
//! real joint wrongly. The block therefore says what it is before it is decoded. All numbers are
//! little-endian:
//!
//! | bytes | what |
//! |---|---|
//! | 4 | magic `JNTP` |
//! | 2 | version of this table and of the payload's type, [`VERSION`] or an older one |
//! | 1 | number of gear stages |
//! | 1 | zero |
//! | 4 | length of the payload |
//! | n | payload: [`crate::parameters::Parameters`], encoded by postcard |
//! | 4 | CRC-32 (ISO-HDLC) of all bytes before it |
//!
//! A payload of a newer version begins with that of the version before, so that what an older block
//! lacks is what gets its documented default. Effects are the exception: see [`EFFECTS_SINCE`].

use core::fmt;

use joint_core::telemetry::frame::CRC32;
use serde::{Serialize, de::DeserializeOwned};

use crate::payload;

/// Version of the table above and of the payload; raised whenever either changes.
pub const VERSION: u16 = 5;
/// The oldest version that is still understood.
pub const OLDEST_VERSION: u16 = 1;
/// Versions before this one number the kinds of effects otherwise, so that of them only joints without
/// an effect are read.
pub const EFFECTS_SINCE: u16 = 5;
/// Room for a block: four flash pages of the STM32G431.
pub const PAGE_BYTES: usize = 8192;
/// Where they lie on the STM32G431; `memory.x` ends the program's flash there.
pub const PAGE_ADDRESS_G431: u32 = 0x0801_e000;
/// Where the block lies on the STM32F405.
pub const PAGE_ADDRESS_F405: u32 = 0x0804_0000;
/// Bytes before the payload.
pub const HEADER_BYTES: usize = 12;
/// Bytes after the payload.
pub const CRC_BYTES: usize = 4;

const MAGIC: [u8; 4] = *b"JNTP";

/// Why a block is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockError {
    /// The page is erased: no block was ever written.
    Empty,
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
    /// Its joint has effects, which older versions numbered otherwise.
    Effects(u16),
    /// This coefficient is no number, or one that the equations cannot take.
    Inadmissible(&'static str),
    /// The buffer is too small to write the block into.
    NoRoom,
}

impl BlockError {
    /// A number for it, for where there is no room for a text; zero is none of them.
    pub const fn code(&self) -> u8 {
        match self {
            BlockError::Empty => 1,
            BlockError::Magic => 2,
            BlockError::Version(_) => 3,
            BlockError::Length => 4,
            BlockError::Crc { .. } => 5,
            BlockError::Stages(_) => 6,
            BlockError::Payload => 7,
            BlockError::Inadmissible(_) => 8,
            BlockError::NoRoom => 9,
            BlockError::Effects(_) => 10,
        }
    }

    /// What a code stands for.
    pub fn of_code(code: u8) -> &'static str {
        match code {
            0 => "accepted",
            1 => "no parameter block in the page",
            2 => "not a parameter block",
            3 => "unknown version",
            4 => "wrong length",
            5 => "wrong checksum",
            6 => "too many stages for this program",
            7 => "unreadable payload",
            8 => "inadmissible value",
            9 => "no room",
            10 => "effects of an older version: export it anew",
            _ => "unknown reason",
        }
    }
}

impl fmt::Display for BlockError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BlockError::Empty => f.write_str("no parameter block: the page is erased"),
            BlockError::Inadmissible(key) => {
                write!(f, "parameter block with an inadmissible value of {key}")
            }
            BlockError::Magic => f.write_str("not a parameter block"),
            BlockError::Version(found) => {
                write!(
                    f,
                    "parameter block of version {found}, expected {OLDEST_VERSION} to {VERSION}"
                )
            }
            BlockError::Length => f.write_str("parameter block of the wrong length"),
            BlockError::Crc { stored, found } => {
                write!(f, "parameter block damaged: CRC {stored:08x} stored, {found:08x} found")
            }
            BlockError::Stages(found) => {
                write!(f, "parameter block for {found} stages does not fit this program")
            }
            BlockError::Effects(found) => {
                write!(
                    f,
                    "parameter block of version {found} with effects, which this version numbers \
                     otherwise: export it anew"
                )
            }
            BlockError::Payload => f.write_str("parameter block with an unreadable payload"),
            BlockError::NoRoom => f.write_str("no room for the parameter block"),
        }
    }
}

impl core::error::Error for BlockError {}

/// Writes a block with this payload into `out` and returns its length.
///
/// # Errors
/// [`BlockError::NoRoom`] where `out` is too small.
pub fn encode<T: Serialize>(
    parameters: &T,
    stages: u8,
    out: &mut [u8],
) -> Result<usize, BlockError> {
    encode_as(VERSION, parameters, stages, out)
}

/// Writes a block that says it is of this version.
///
/// # Errors
/// [`BlockError::NoRoom`] where `out` is too small.
pub fn encode_as<T: Serialize>(
    version: u16,
    parameters: &T,
    stages: u8,
    out: &mut [u8],
) -> Result<usize, BlockError> {
    let (header, rest) = out.split_at_mut_checked(HEADER_BYTES).ok_or(BlockError::NoRoom)?;
    let length = postcard::to_slice(parameters, rest).map_err(|_| BlockError::NoRoom)?.len();
    let [v0, v1] = version.to_le_bytes();
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
    /// The version that it was written in.
    pub version: u16,
    /// Number of gear stages.
    pub stages: u8,
    /// The checksum, which tells one set of parameters from another.
    pub crc: u32,
    payload: &'a [u8],
}

impl<'a> Block<'a> {
    /// Checks the block at the start of a flash page; what comes after it is not looked at.
    ///
    /// # Errors
    /// As [`Block::check`]; [`BlockError::Empty`] where the page is erased.
    pub fn in_page(page: &'a [u8]) -> Result<Self, BlockError> {
        let header = page.first_chunk::<HEADER_BYTES>().ok_or(BlockError::Magic)?;
        if *header == [0xff; HEADER_BYTES] {
            return Err(BlockError::Empty);
        }
        if header.first_chunk::<4>() != Some(&MAGIC) {
            return Err(BlockError::Magic);
        }
        let [.., l0, l1, l2, l3] = *header;
        let payload = u32::from_le_bytes([l0, l1, l2, l3]) as usize;
        let length = payload.checked_add(HEADER_BYTES + CRC_BYTES).ok_or(BlockError::Length)?;
        Self::check(page.get(..length).ok_or(BlockError::Length)?)
    }

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
        if !(OLDEST_VERSION..=VERSION).contains(&version) {
            return Err(BlockError::Version(version));
        }
        if usize::try_from(u32::from_le_bytes([l0, l1, l2, l3])) != Ok(payload.len()) {
            return Err(BlockError::Length);
        }
        let (stored, found) = (u32::from_le_bytes(*stored), CRC32.checksum(body));
        if stored != found {
            return Err(BlockError::Crc { stored, found });
        }
        Ok(Self { version, stages, crc: stored, payload })
    }

    /// The payload as one value.
    ///
    /// # Errors
    /// [`BlockError::Payload`] where it is not what `T` looks like.
    pub fn decode<T: DeserializeOwned>(&self) -> Result<T, BlockError> {
        last(self.payload)
    }

    /// Puts the first value of the payload into a place and gives what comes after it.
    ///
    /// # Errors
    /// [`BlockError::Payload`] where it is not what `T` looks like; the place is then to be emptied.
    pub fn take_into<T: DeserializeOwned>(
        &self,
        place: &mut Option<T>,
    ) -> Result<&'a [u8], BlockError> {
        payload::take_into(self.payload, place).map_err(|_| BlockError::Payload)
    }
}

/// The value that these bytes are, and nothing after it.
///
/// # Errors
/// [`BlockError::Payload`] where they are not what `T` looks like.
pub fn last<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, BlockError> {
    let mut place = None;
    match (payload::take_into(bytes, &mut place), place) {
        (Ok([]), Some(value)) => Ok(value),
        _ => Err(BlockError::Payload),
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
    fn a_page_holds_a_block_an_erased_one_none_and_a_wrong_length_is_no_panic() {
        let mut page = block();
        page.resize(PAGE_BYTES, 0xff);
        assert_eq!(Block::in_page(&page).unwrap().decode::<[f32; 3]>(), Ok([1.5, -2.0, 3.25]));
        assert_eq!(Block::in_page(&[0xff; PAGE_BYTES]).unwrap_err(), BlockError::Empty);
        assert_eq!(Block::in_page(&[0; PAGE_BYTES]).unwrap_err(), BlockError::Magic);
        assert_eq!(Block::in_page(&page[..7]).unwrap_err(), BlockError::Magic);
        for length in [u32::MAX, 8192, 13, 0] {
            page[8..12].copy_from_slice(&length.to_le_bytes());
            assert!(Block::in_page(&page).is_err(), "length {length}");
        }
    }

    #[test]
    fn only_known_versions_are_read() {
        let mut bytes = [0; 64];
        for version in [0, VERSION + 1, u16::MAX] {
            let length = encode_as(version, &1.5_f32, 0, &mut bytes).unwrap();
            assert_eq!(Block::check(&bytes[..length]).unwrap_err(), BlockError::Version(version));
        }
        let length = encode_as(OLDEST_VERSION, &1.5_f32, 0, &mut bytes).unwrap();
        assert_eq!(Block::check(&bytes[..length]).unwrap().version, OLDEST_VERSION);
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
