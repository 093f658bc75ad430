//! Elementary functions: exponential, hyperbolic tangent, sine and cosine.
//!
//! They are polynomials of the length that their float can show: a drive's mathematics library would
//! take several times as long. An angle is given in turns, which wrap for free in fixed point.

use super::Number;

/// The elementary functions that the laws of a joint ask for.
pub trait Elementary: Number {
    /// `exp(−x)` of any `x ≥ 0`; absolute error below 5e-6 (f32) and 1e-10 (f64).
    fn exp_minus(self) -> Self;

    /// Sine of an angle in turns, for |turns| ≤ ½; absolute error below 1e-6.
    fn sin_turns(self) -> Self;

    /// Cosine of an angle in turns, for |turns| ≤ ½.
    #[inline(always)]
    fn cos_turns(self) -> Self {
        let quarter = Self::HALF * Self::HALF;
        (quarter - self.abs()).sin_turns()
    }

    /// Hyperbolic tangent; absolute error that of [`Elementary::exp_minus`].
    #[inline(always)]
    fn tanh(self) -> Self {
        let magnitude = self.abs();
        let decayed = (magnitude + magnitude).exp_minus();
        let bent = (Self::ONE - decayed).over(Self::ONE + decayed);
        bent.along(self)
    }
}

/// A polynomial by Horner's rule, from the highest power down.
macro_rules! horner {
    ($x:expr, $t:ty, $first:expr $(, $c:expr)+) => {{
        let x: $t = $x;
        let mut sum: $t = $first;
        $( sum = sum * x + $c; )+
        sum
    }};
}

pub(crate) use horner;

/// Sine of |turns| ≤ ½. It is mirrored about a quarter turn, and so is `p = x (½ − |x|)`, of which it
/// is a smooth odd function: the polynomial gives sine over p, and there is no quadrant to look up.
macro_rules! sine {
    ($turns:expr, $t:ty, $($c:expr),+) => {{
        let x: $t = $turns;
        let p = x * (0.5 - x.abs());
        p * horner!(p.abs(), $t, $($c),+)
    }};
}

impl Elementary for f32 {
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
    #[inline(always)]
    fn sin_turns(self) -> f32 {
        sine!(self, f32, 56.144_802, 71.193_33, 50.269_58, 12.566_344)
    }
}

impl Elementary for f64 {
    #[inline(always)]
    fn exp_minus(self) -> f64 {
        let power = core::f64::consts::LOG2_E * if self < 64.0 { self } else { 64.0 };
        let whole = f64::from(power as i32);
        halved_in_part(power - whole) * halved(whole)
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
    fn sine_and_cosine_of_turns_keep_their_stated_error() {
        for turns in sweep(-0.5, 0.5) {
            let angle = turns * core::f64::consts::TAU;
            assert!((turns.sin_turns() - angle.sin()).abs() < 1e-9);
            assert!((turns.cos_turns() - angle.cos()).abs() < 1e-9);
            assert!((f64::from((turns as f32).sin_turns()) - angle.sin()).abs() < 1e-6);
            assert!((f64::from((turns as f32).cos_turns()) - angle.cos()).abs() < 1e-6);
        }
    }
}
