//! Constants of a joint in numbers of another kind: how a host lays many joints side by side.
//!
//! How a joint's constants follow from its parameters is written once, in one number. Joints that
//! differ by their numbers alone become one whose numbers have lanes, by visiting the numbers of each
//! in the same order.

/// What becomes of each number of some constants.
pub trait Numbers<U> {
    /// Of a number that the joint is computed with.
    fn number(&mut self, own: f64) -> U;
    /// Of one that is in double precision whatever the joint is computed in.
    fn exact(&mut self, own: f64) -> f64;
}

/// Constants whose numbers can be taken over into numbers `U`.
pub trait Batch<U> {
    /// The same constants in such numbers.
    type Batched;
    /// Takes every number over, in an order that is always the same; what is no number stays.
    fn batch(&self, numbers: &mut impl Numbers<U>) -> Self::Batched;
}

impl<U> Batch<U> for f64 {
    type Batched = U;
    fn batch(&self, numbers: &mut impl Numbers<U>) -> U {
        numbers.number(*self)
    }
}

impl<U, A: Batch<U>, const N: usize> Batch<U> for [A; N] {
    type Batched = [A::Batched; N];
    fn batch(&self, numbers: &mut impl Numbers<U>) -> Self::Batched {
        self.each_ref().map(|own| own.batch(numbers))
    }
}

/// Lists the fields of constants: those that are numbers or made of numbers, and after a semicolon
/// those that are none.
macro_rules! batch {
    ($name:ident<$bound:ident>: $($number:ident),* $(; $($plain:ident),*)?) => {
        impl<U: $bound + $crate::number::Number<Gain = U>> $crate::batch::Batch<U> for $name<f64> {
            type Batched = $name<U>;
            fn batch(&self, numbers: &mut impl $crate::batch::Numbers<U>) -> $name<U> {
                $name {
                    $($number: $crate::batch::Batch::batch(&self.$number, numbers),)*
                    $($($plain: self.$plain,)*)?
                }
            }
        }
    };
}

pub(crate) use batch;
