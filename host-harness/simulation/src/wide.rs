//! The widest registers of the processor at hand.
//!
//! A program is compiled for every processor of its kind, and most have registers twice as wide as
//! the least of them. What runs millions of times is compiled for those as well, and takes them where
//! they are; sums and products stay the same bit for bit.

use joint_core::work::Work;
use pulp::{Arch, Simd, WithSimd};

struct Wide<W>(W);

impl<W: Work> WithSimd for Wide<W> {
    type Output = W::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> W::Output {
        self.0.run()
    }
}

/// Does work whose functions are inlined in the widest registers that there are.
#[inline(always)]
pub fn run<W: Work>(work: W) -> W::Output {
    Arch::new().dispatch(Wide(work))
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Sums<'a>(&'a [[f32; 16]]);

    impl Work for Sums<'_> {
        type Output = [f32; 16];

        #[inline(always)]
        fn run(self) -> [f32; 16] {
            let mut sums = [0.0_f32; 16];
            for row in self.0 {
                for (sum, value) in sums.iter_mut().zip(row) {
                    *sum = *sum * 0.7 + value * 1.3;
                }
            }
            sums
        }
    }

    #[test]
    fn work_in_the_widest_registers_gives_the_same_bits() {
        let value = |k: usize, lane: usize| ((k * 31 + lane * 7) as f32).sin();
        let rows: Vec<[f32; 16]> =
            (0..100).map(|k| std::array::from_fn(|lane| value(k, lane))).collect();
        assert_eq!(run(Sums(&rows)).map(f32::to_bits), Sums(&rows).run().map(f32::to_bits));
    }
}
