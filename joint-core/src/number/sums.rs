//! Sums of products with constants, as a kick makes them.

use super::Number;

/// How a format sums products with constants that are made together: fixed point gives them one exponent
/// and rounds the sum, where single products would each be rounded and shifted.
pub trait Sums: Number {
    /// The constants of one sum; the other functions here take no others.
    fn gains<const K: usize>(values: [f64; K]) -> [Self::Gain; K] {
        values.map(Self::gain)
    }
    /// Sum of products less one.
    #[inline(always)]
    fn weighed<const K: usize>(
        plus: [(Self, Self::Gain); K],
        (minus, gain): (Self, Self::Gain),
    ) -> Self {
        let products = plus.into_iter().map(|(value, gain)| value.times(gain));
        products.reduce(|sum, product| sum + product).unwrap_or(Self::ZERO) - minus.times(gain)
    }
    /// Its sum with such a sum.
    #[inline(always)]
    fn plus_weighed<const K: usize>(
        self,
        plus: [(Self, Self::Gain); K],
        (minus, gain): (Self, Self::Gain),
    ) -> Self {
        let products = plus.into_iter().map(|(value, gain)| value.times(gain));
        products.fold(self, |sum, product| sum + product) - minus.times(gain)
    }
    /// The product with one of them.
    #[inline(always)]
    fn weighed_alone(self, gain: Self::Gain) -> Self {
        self.times(gain)
    }
}

impl Sums for f32 {}
impl Sums for f64 {}
