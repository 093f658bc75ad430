//! The exponential of the Stribeck curve as a table: half the instructions of a polynomial of the
//! same use, and near enough for a format that is held to 2 %.

use super::{Fixed, PLACES, UNIT, upper};

/// exp(−s/2) at every eighth from 0 to 16.
static EXPONENTIAL: [i32; 129] = [
    67_108_864, 63_042_943, 59_223_365, 55_635_202, 52_264_436, 49_097_894, 46_123_203, 43_328_739,
    40_703_584, 38_237_478, 35_920_786, 33_744_456, 31_699_983, 29_779_378, 27_975_137, 26_280_209,
    24_687_971, 23_192_203, 21_787_058, 20_467_047, 19_227_011, 18_062_106, 16_967_778, 15_939_752,
    14_974_012, 14_066_782, 13_214_519, 12_413_892, 11_661_772, 10_955_221, 10_291_478, 9_667_949,
    9_082_197, 8_531_935, 8_015_011, 7_529_406, 7_073_222, 6_644_677, 6_242_097, 5_863_907,
    5_508_631, 5_174_880, 4_861_350, 4_566_816, 4_290_126, 4_030_201, 3_786_023, 3_556_639,
    3_341_154, 3_138_723, 2_948_558, 2_769_914, 2_602_093, 2_444_440, 2_296_339, 2_157_211,
    2_026_512, 1_903_732, 1_788_391, 1_680_038, 1_578_249, 1_482_628, 1_392_800, 1_308_415,
    1_229_142, 1_154_672, 1_084_714, 1_018_994, 957_257, 899_259, 844_776, 793_594, 745_512,
    700_344, 657_912, 618_051, 580_605, 545_428, 512_382, 481_339, 452_176, 424_780, 399_044,
    374_867, 352_155, 330_819, 310_776, 291_947, 274_259, 257_642, 242_032, 227_368, 213_593,
    200_652, 188_495, 177_075, 166_346, 156_268, 146_800, 137_906, 129_551, 121_702, 114_328,
    107_401, 100_894, 94_781, 89_039, 83_644, 78_576, 73_816, 69_343, 65_142, 61_195, 57_488,
    54_005, 50_733, 47_659, 44_771, 42_059, 39_511, 37_117, 34_868, 32_756, 30_771, 28_907, 27_155,
    25_510, 23_964, 0,
];

/// exp(−s/2) of bits that are not below zero.
#[inline(always)]
pub(super) fn interpolated(square: i32) -> Fixed {
    const WIDTH: u32 = PLACES - 3;
    let square = if square < 16 * UNIT { square } else { 16 * UNIT - 1 };
    let at = (square >> WIDTH) as usize & 127;
    let value = |at: usize| EXPONENTIAL.get(at).copied().unwrap_or(0);
    let (from, to) = (value(at), value(at + 1));
    let part = (square & ((1 << WIDTH) - 1)) << (31 - WIDTH);
    Fixed::from_bits(from + (upper(to - from, part) << 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Scalar;

    #[test]
    fn straight_lines_keep_their_stated_error() {
        for k in 0..=32_000 {
            let square = Fixed::from_f64(f64::from(k) * 1e-3);
            let exact = (-0.5 * square.to_f64()).exp();
            let found = interpolated(square.to_bits()).to_f64();
            assert!((found - exact).abs() < 5e-4, "at {square:?}: {found}");
        }
    }
}
