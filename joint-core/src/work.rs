//! Work that a number may have done in its own way.
//!
//! A drive is compiled for its one processor. A host is not: a program for every processor of its kind
//! leaves half the width of most of them idle. So a number of many lanes gets the functions of a step
//! whole, to compile them for wider registers as well.

/// Work whose functions are inlined into whoever runs it.
pub trait Work {
    /// What comes of it.
    type Output;
    /// Does it.
    fn run(self) -> Self::Output;
}

/// How a format has work done.
pub trait Wide: Sized {
    /// Does work in such numbers: those of many lanes choose the widest registers at hand.
    #[inline(always)]
    fn widely<W: Work>(work: W) -> W::Output {
        work.run()
    }

    /// The same constants, for a second use that is far from the first. A compiler reads them once and
    /// keeps them; a format that has no registers to spare has them read again, since it would keep them
    /// on the stack.
    #[inline(always)]
    fn again<T>(constants: &T) -> &T {
        constants
    }
}

impl Wide for f32 {}
impl Wide for f64 {}

/// Does a block as [`Work`] in numbers of the type that is named first; for what is a function of its own.
macro_rules! widely {
    (
        <$number:ident $(, $n:ident, $effects:ident)?>
        ($($name:ident: $type:ty = $value:expr),+ $(,)?) -> $answer:ty $body:block
    ) => {{
        struct Whole<
            'a,
            $number: $crate::scalar::Scalar,
            $(const $n: usize, $effects: $crate::effect::Effects<$number>,)?
        > {
            $($name: $type,)+
            lifetime: core::marker::PhantomData<&'a $number>,
        }
        impl<
            'a,
            $number: $crate::scalar::Scalar,
            $(const $n: usize, $effects: $crate::effect::Effects<$number>,)?
        > $crate::work::Work for Whole<'a, $number, $($n, $effects)?> {
            type Output = $answer;
            #[inline(always)]
            fn run(self) -> $answer {
                let Self { $($name,)+ .. } = self;
                $body
            }
        }
        $number::widely(Whole { $($name: $value,)+ lifetime: core::marker::PhantomData })
    }};
}

pub(crate) use widely;
