//! The number that a whole joint is computed in.

use crate::angle::Turns;
use crate::friction::{Damped, LuGre};
use crate::gear::Deflection;
use crate::lookup::Lookup;
use crate::number::{Elementary, Limits, Sums};
use crate::work::Wide;

/// A number in which every law of the joint can be computed: a [`Number`](crate::number::Number), and
/// what each law asks of it beside.
pub trait Scalar:
    Limits + Elementary + Sums + Turns + Deflection + LuGre + Damped + Lookup + Wide
{
}
impl<T: Limits + Elementary + Sums + Turns + Deflection + LuGre + Damped + Lookup + Wide> Scalar
    for T
{
}

/// One number that can be compared, and whose whole turns are a count: for what is not the step, and
/// may take its way by the data.
pub trait Real: Scalar<Mask = bool, Whole = i32> + PartialOrd {}
impl<T: Scalar<Mask = bool, Whole = i32> + PartialOrd> Real for T {}
