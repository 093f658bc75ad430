//! The joint's numbers as f32, for a drive with a floating-point unit, and f64, for the host.
//!
//! Exponential, sine and Stribeck curve are polynomials of the length that their float can show: a
//! drive's mathematics library would take several times as long.

use super::{Scalar, single};

/// Sine of |turns| ≤ ½. It is mirrored about a quarter turn, and so is `p = x (½ − |x|)`, of which it
/// is a smooth odd function: the polynomial gives sine over p, and there is no quadrant to look up.
macro_rules! sine {
    ($turns:expr, $t:ty, $($c:expr),+) => {{
        let x: $t = $turns;
        let p = x * (0.5 - x.abs());
        p * horner!(p.abs(), $t, $($c),+)
    }};
}

macro_rules! horner {
    ($x:expr, $t:ty, $first:expr $(, $c:expr)+) => {{
        let x: $t = $x;
        let mut sum: $t = $first;
        $( sum = sum * x + $c; )+
        sum
    }};
}

/// 6^−⅓.
const FLOAT_REACH: f64 = 0.550_321_208_149_104_5;
/// Cube root of the cubic's first coefficient in the Stribeck curve of f32.
const CUBE: f64 = 0.036826556131;

impl Scalar for f32 {
    type Gain = f32;
    single!();

    const ZERO: f32 = 0.0;
    const ONE: f32 = 1.0;
    const HALF: f32 = 0.5;
    const SIXTH: f32 = 1.0 / 6.0;
    const ELEVEN_TWELFTHS: f32 = 11.0 / 12.0;
    const REACH: f64 = FLOAT_REACH;
    const PER_REACH: f32 = (1.0 / FLOAT_REACH) as f32;
    const RELAXING: [f32; 2] =
        [(1.0 / FLOAT_REACH) as f32, (0.5 / (FLOAT_REACH * FLOAT_REACH)) as f32];
    const SQUARE: f64 = CUBE;

    fn gain(value: f64) -> f32 {
        value as f32
    }
    fn from_f64(value: f64) -> f32 {
        value as f32
    }
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    #[inline(always)]
    fn eighth(self) -> f32 {
        self * 0.125
    }
    #[inline(always)]
    fn swing(self) -> f32 {
        const SWING: f32 = (0.0625 / FLOAT_REACH) as f32;
        self * SWING
    }
    #[inline(always)]
    fn per_square(self) -> f32 {
        self * (1.0 / CUBE) as f32
    }
    #[inline(always)]
    fn times(self, gain: f32) -> f32 {
        self * gain
    }
    #[inline(always)]
    fn ratio(self, at_least_self: f32) -> f32 {
        self / at_least_self
    }
    #[inline(always)]
    fn over(self, at_least_one: f32) -> f32 {
        self / at_least_one
    }
    #[inline(always)]
    fn abs(self) -> f32 {
        f32::abs(self)
    }
    /// `exp(−t) = exp(−t/32)³²`, the root by a cubic whose 32nd power is within 7.2e-7 of it on
    /// `0 ≤ t ≤ 16`; what is left there, 1.2e-7, stands for all beyond.
    #[inline(always)]
    fn exp_minus(self) -> f32 {
        let t = if self < 16.0 { self } else { 16.0 };
        let mut root = horner!(t, f32, -4.807_761e-6, 4.877_664_6e-4, -0.031_249_774, 1.0);
        for _ in 0..5 {
            root = root * root;
        }
        root
    }
    /// The exponential is the eighth power of a cubic: it needs no end of its range, since its
    /// inverse goes to zero with it.
    #[inline(always)]
    fn stribeck(self, beta: f32) -> (f32, f32) {
        let root = horner!(self, f32, 1.0, 1.416_852, 1.697_819_6, 1.0);
        let square = root * root;
        let fourth = square * square;
        let grown = fourth * fourth;
        (beta / (grown + beta), 1.0 + beta / grown)
    }
    #[inline(always)]
    fn thrice(self) -> f32 {
        self * 3.0
    }
    #[inline(always)]
    fn is_at_limit(self) -> bool {
        !self.is_finite()
    }
    #[inline(always)]
    fn from_turn_counts(counts: i32) -> f32 {
        counts as f32 * (1.0 / 4_294_967_296.0)
    }
    #[inline(always)]
    fn from_small(value: u8) -> f32 {
        f32::from(value)
    }
    #[inline(always)]
    fn sin_turns(self) -> f32 {
        sine!(self, f32, 56.144_802, 71.193_33, 50.269_58, 12.566_344)
    }
    #[inline(always)]
    fn split_turns(self) -> (i32, f32) {
        let whole = (self + self) as i32;
        (whole, self - whole as f32)
    }
    #[inline(always)]
    fn wrapped_turns(whole: i32, whole_ratio: f32, part: f32, ratio: f32) -> f32 {
        let turns = whole as f32 * whole_ratio + part * ratio;
        let nearest = (turns + if turns < 0.0 { -0.5 } else { 0.5 }) as i32;
        turns - nearest as f32
    }
    #[inline(always)]
    fn wide_turns(whole: i32, part: f32, ratio: f32) -> f32 {
        (whole as f32 + part) * ratio
    }
}

/// `2^−part` of a part of one, to 3e-11: what is left of an exponential when its whole powers are gone.
#[inline(always)]
pub fn halved_in_part(part: f64) -> f64 {
    horner!(
        part,
        f64,
        -1.083_036_970_248_301_6e-5,
        0.000_147_293_815_700_777_48,
        -0.001_327_837_364_900_122,
        0.009_615_595_597_091_18,
        -0.055_503_473_283_022_1,
        0.240_226_428_467_964_8,
        -0.693_147_176_860_134_2,
        0.999_999_999_971_375_5
    )
}

/// `2^−whole` of a whole number between zero and a thousand: the exponent of a float, put to its place
/// by a sum whose last bits it becomes.
#[inline(always)]
pub fn halved(whole: f64) -> f64 {
    const LAST_BITS: f64 = 4_503_599_627_370_496.0;
    f64::from_bits((1023.0 - whole + LAST_BITS).to_bits() << 52)
}

impl Scalar for f64 {
    type Gain = f64;
    single!();

    const ZERO: f64 = 0.0;
    const ONE: f64 = 1.0;
    const HALF: f64 = 0.5;
    const SIXTH: f64 = 1.0 / 6.0;
    const ELEVEN_TWELFTHS: f64 = 11.0 / 12.0;
    const REACH: f64 = FLOAT_REACH;
    const PER_REACH: f64 = 1.0 / FLOAT_REACH;
    const RELAXING: [f64; 2] = [1.0 / FLOAT_REACH, 0.5 / (FLOAT_REACH * FLOAT_REACH)];
    const SQUARE: f64 = 1.0;

    fn gain(value: f64) -> f64 {
        value
    }
    fn from_f64(value: f64) -> f64 {
        value
    }
    fn to_f64(self) -> f64 {
        self
    }
    #[inline(always)]
    fn eighth(self) -> f64 {
        self * 0.125
    }
    #[inline(always)]
    fn swing(self) -> f64 {
        const SWING: f64 = 0.0625 / FLOAT_REACH;
        self * SWING
    }
    #[inline(always)]
    fn per_square(self) -> f64 {
        self
    }
    #[inline(always)]
    fn times(self, gain: f64) -> f64 {
        self * gain
    }
    #[inline(always)]
    fn ratio(self, at_least_self: f64) -> f64 {
        self / at_least_self
    }
    #[inline(always)]
    fn over(self, at_least_one: f64) -> f64 {
        self / at_least_one
    }
    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }
    #[inline(always)]
    fn exp_minus(self) -> f64 {
        let power = core::f64::consts::LOG2_E * if self < 64.0 { self } else { 64.0 };
        let whole = f64::from(power as i32);
        halved_in_part(power - whole) * halved(whole)
    }
    #[inline(always)]
    fn stribeck(self, beta: f64) -> (f64, f64) {
        let excess = beta * (0.5 * self).exp_minus();
        (excess / (1.0 + excess), 1.0 + excess)
    }
    #[inline(always)]
    fn is_at_limit(self) -> bool {
        !self.is_finite()
    }
    #[inline(always)]
    fn from_turn_counts(counts: i32) -> f64 {
        f64::from(counts) * (1.0 / 4_294_967_296.0)
    }
    #[inline(always)]
    fn from_small(value: u8) -> f64 {
        f64::from(value)
    }
    #[inline(always)]
    fn sin_turns(self) -> f64 {
        sine!(
            self,
            f64,
            7.532_170_094_907_101,
            23.569_620_688_749_745,
            52.436_418_256_069_42,
            71.390_215_699_215_19,
            50.265_482_709_283_225,
            12.566_370_613_548_331
        )
    }
    #[inline(always)]
    fn split_turns(self) -> (i32, f64) {
        let whole = (self + self) as i32;
        (whole, self - f64::from(whole))
    }
    #[inline(always)]
    fn wrapped_turns(whole: i32, whole_ratio: f64, part: f64, ratio: f64) -> f64 {
        let turns = f64::from(whole) * whole_ratio + part * ratio;
        let nearest = (turns + if turns < 0.0 { -0.5 } else { 0.5 }) as i32;
        turns - f64::from(nearest)
    }
    #[inline(always)]
    fn wide_turns(whole: i32, part: f64, ratio: f64) -> f64 {
        (f64::from(whole) + part) * ratio
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sweep(low: f64, high: f64) -> impl Iterator<Item = f64> {
        (0..=4000).map(move |k| low + (high - low) * f64::from(k) / 4000.0)
    }

    #[test]
    fn exp_minus_keeps_its_stated_absolute_error() {
        for x in sweep(0.0, 80.0).chain(sweep(0.0, 1.0)) {
            assert!((x.exp_minus() - (-x).exp()).abs() < 1e-10, "f64 at {x}");
            let narrow = x as f32;
            let exact = (-f64::from(narrow)).exp();
            assert!((f64::from(narrow.exp_minus()) - exact).abs() < 5e-6, "f32 at {x}");
        }
    }

    #[test]
    fn the_excess_of_a_stribeck_curve_keeps_its_stated_error_and_ends_at_zero() {
        for beta in [-0.9, -0.3, 0.4, 2.0] {
            for s in sweep(0.0, 160.0).chain(sweep(0.0, 4.0)) {
                let exact = beta / ((0.5 * s).exp() + beta);
                // The error 4e-5 of exp(−s/2) grows by β/(1 + β exp(−s/2))².
                let bound = 4e-5 * beta.abs() / (1.0 + beta.min(0.0)).powi(2) + 1e-6;
                let narrow = f64::from(((s * f32::SQUARE) as f32).stribeck(beta as f32).0);
                assert!((narrow - exact).abs() < bound, "f32 at {s}, {beta}: {narrow} {exact}");
                assert!((s.stribeck(beta).0 - exact).abs() < 1e-8, "f64 at {s}, {beta}");
            }
            assert_eq!(1e9_f32.stribeck(beta as f32).0, 0.0);
            assert_eq!(f32::MAX.stribeck(beta as f32).0, 0.0);
            assert!(1e9_f64.stribeck(beta).0.abs() < 1e-20);
        }
    }

    #[test]
    fn sine_and_cosine_of_turns_keep_their_stated_error() {
        for turns in sweep(-0.5, 0.5) {
            let angle = turns * core::f64::consts::TAU;
            assert!((turns.sin_turns() - angle.sin()).abs() < 1e-9);
            assert!((turns.cos_turns() - angle.cos()).abs() < 1e-9);
            assert!((f64::from((turns as f32).sin_turns()) - angle.sin()).abs() < 1e-6);
            assert!((f64::from((turns as f32).cos_turns()) - angle.cos()).abs() < 1e-6);
        }
    }

    #[test]
    fn turns_wrap_to_the_nearest_whole_turn_in_both_directions() {
        assert!((f64::wrapped_turns(10, 0.1, 0.25, 0.1) - 0.025).abs() < 1e-12);
        assert!((f64::wrapped_turns(-10, 0.1, -0.25, 0.1) + 0.025).abs() < 1e-12);
        let ratio = 1.0 / 1024.0;
        assert!((f32::wrapped_turns(1000, ratio, 0.0, ratio) + 24.0 / 1024.0).abs() < 1e-6);
    }
}
