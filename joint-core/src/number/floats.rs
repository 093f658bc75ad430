//! The joint's numbers as f32, for a drive with a floating-point unit, and f64, for the host.

use super::{Number, compared};

/// A float's own arithmetic; it is its own gain.
macro_rules! float {
    ($float:ident) => {
        impl Number for $float {
            type Gain = $float;
            compared!();

            const ZERO: $float = 0.0;
            const ONE: $float = 1.0;
            const HALF: $float = 0.5;

            #[inline]
            fn gain(value: f64) -> $float {
                value as $float
            }
            #[inline]
            fn from_f64(value: f64) -> $float {
                value as $float
            }
            #[inline]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn times(self, gain: $float) -> $float {
                self * gain
            }
            #[inline(always)]
            fn over(self, at_least_one: $float) -> $float {
                self / at_least_one
            }
            #[inline(always)]
            fn ratio(self, at_least_self: $float) -> $float {
                self / at_least_self
            }
            #[inline(always)]
            fn abs(self) -> $float {
                $float::abs(self)
            }
        }
    };
}

float!(f32);
float!(f64);
