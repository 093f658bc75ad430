//! The replay's files: inputs in, states out, both plain little-endian f32.
//!
//! A semihosting call costs far more than a sample, so the inputs travel in blocks of
//! [`BLOCK_SAMPLES`]. An input is two numbers (motor input, load torque) in the units of the
//! replayed joint; a row of states is as many numbers as the joint has states. There is no header:
//! the lengths follow from the files' sizes, and the parameter block says which joint it is.

/// Samples read from the log at once.
pub const BLOCK_SAMPLES: usize = 512;
/// Bytes of one sample.
pub const SAMPLE_BYTES: usize = 8;

/// What acts on the joint during one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Motor input: voltage, or current where the drive imposes it.
    pub input: f32,
    /// Load torque at the output.
    pub load: f32,
}

impl Sample {
    /// As it stands in the log.
    pub fn to_bytes(self) -> [u8; SAMPLE_BYTES] {
        let ([a, b, c, d], [e, f, g, h]) = (self.input.to_le_bytes(), self.load.to_le_bytes());
        [a, b, c, d, e, f, g, h]
    }

    /// From the log.
    pub fn from_bytes([a, b, c, d, e, f, g, h]: [u8; SAMPLE_BYTES]) -> Self {
        Self { input: f32::from_le_bytes([a, b, c, d]), load: f32::from_le_bytes([e, f, g, h]) }
    }
}

/// The samples of a block; an incomplete one at the end is left out.
pub fn samples(bytes: &[u8]) -> impl Iterator<Item = Sample> + '_ {
    bytes.as_chunks::<SAMPLE_BYTES>().0.iter().copied().map(Sample::from_bytes)
}

/// Running CRC-32 of what the replay wrote, to be printed beside it.
#[derive(Clone)]
pub struct Checksum(crc::Digest<'static, u32, crc::Table<1>>);

impl core::fmt::Debug for Checksum {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "Checksum({:08x})", self.value())
    }
}

impl Default for Checksum {
    fn default() -> Self {
        Self(joint_core::telemetry::frame::CRC32.digest())
    }
}

impl Checksum {
    /// Takes in more bytes.
    pub fn update(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// The checksum of all bytes taken in.
    pub fn value(&self) -> u32 {
        self.0.clone().finalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_survive_the_file_and_a_torn_tail_is_dropped() {
        let two =
            [Sample { input: 1.5, load: -2.0 }, Sample { input: f32::MIN_POSITIVE, load: 0.0 }];
        let mut bytes: Vec<u8> = two.iter().flat_map(|sample| sample.to_bytes()).collect();
        bytes.extend([1, 2, 3]);
        assert_eq!(samples(&bytes).collect::<Vec<_>>(), two);
    }

    #[test]
    fn the_checksum_does_not_depend_on_how_the_bytes_are_cut() {
        let mut whole = Checksum::default();
        whole.update(b"123456789");
        let mut parts = Checksum::default();
        parts.update(b"1234");
        parts.update(b"56789");
        assert_eq!(whole.value(), 0xcbf4_3926);
        assert_eq!(parts.value(), whole.value());
    }
}
