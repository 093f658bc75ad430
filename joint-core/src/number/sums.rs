//! Sums of products with constants: a kick of rotor and winding, a correction by every sensor.

use super::Number;

/// How a format sums products: fixed point gives the constants of one sum one exponent and
/// rounds the sum, where single products would each be shifted and rounded.
pub trait Sums: Number {
    /// The constants of one sum; the other functions here take no others.
    fn gains<const K: usize>(values: [f64; K]) -> [Self::Gain; K] {
        values.map(Self::gain)
    }

    /// Product with one of them.
    #[inline(always)]
    fn weighed(self, gain: Self::Gain) -> Self {
        self.times(gain)
    }

    /// Sum of products.
    #[inline(always)]
    fn weighed_sum<const K: usize>(terms: [(Self, &Self::Gain); K]) -> Self {
        let products = terms.iter().map(|(value, gain)| value.times(**gain));
        products.reduce(|sum, product| sum + product).unwrap_or(Self::ZERO)
    }

    /// The number with a sum of products more; floats add one after the other, since rounding takes no
    /// more than a share of each sum.
    #[inline(always)]
    fn corrected<const K: usize>(self, terms: [(Self, &Self::Gain); K]) -> Self {
        terms.iter().fold(self, |sum, (value, gain)| sum + value.times(**gain))
    }

    /// What a kick makes of a speed: three products less one.
    #[inline(always)]
    fn gained(plus: [(Self, &Self::Gain); 3], minus: (Self, &Self::Gain)) -> Self {
        let [first, second, third] = plus;
        first.0.times_nearest(*first.1) + second.0.times(*second.1) + third.0.times(*third.1)
            - minus.0.times(*minus.1)
    }

    /// What it makes of a current that would end at this number: two products more less one.
    #[inline(always)]
    fn ended(self, plus: [(Self, &Self::Gain); 2], minus: (Self, &Self::Gain)) -> Self {
        let [first, second] = plus;
        self + first.0.times(*first.1) + second.0.times(*second.1) - minus.0.times(*minus.1)
    }
}

impl Sums for f32 {}
impl Sums for f64 {}
