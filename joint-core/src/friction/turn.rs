//! What a speed that moves in the kick between two half drifts does to the bristle.
//!
//! A bristle whose rate bends with the speed, by τ'' = ∂²ż/∂v², misses a²τ'' h³/72 of an acceleration
//! a between the two drifts: the last term of the splitting's double commutator, here by differences
//! of speed and slope, so that it ends where the Stribeck curve does. At standstill the bend is a
//! corner, and its part is what halves at constant speed miss of ∫|v|; the speed makes good the
//! kick's tangent of the damping behind it.

use super::bristle::Relaxation;
use crate::state::Mass;

/// What a mass's speed did between the two half drifts, for the second one's flow.
#[derive(Clone, Copy)]
pub(crate) struct Turn<S> {
    /// Share of ζ that a passed standstill adds.
    pub(super) share: S,
    /// The first half's.
    half: Half<S>,
}

/// What the second half of a drift asks of the first.
#[derive(Clone, Copy, Default)]
pub(crate) struct Half<S> {
    /// |κ v|.
    pub(super) reach: S,
    /// Slope ρ + v ρ' of the bristle's slip over ζ.
    pub(super) slope: S,
}

impl<S: Relaxation> Turn<S> {
    /// What the middle kick made of a speed from `before`, where the first half was `half`; `corner` is
    /// the share of ζ per speed that passes standstill, `reversal` that of the speed behind standstill
    /// that the damping takes per slipping: by reference, since what is loaded early is spilled.
    #[inline(always)]
    pub(super) fn of(
        mass: &mut Mass<S>,
        before: S,
        half: Half<S>,
        corner: &S::Gain,
        reversal: &S,
    ) -> Self {
        let after = mass.speed;
        // Twice the speeds' mean and their distance, which is the larger only across standstill.
        let (mean, apart) = ((after + before).abs(), (after - before).abs());
        let share = (apart * S::ELEVEN_TWELFTHS - mean).times(*corner);
        let passed = mean.below(apart);
        let share = S::choose(passed, share, S::ZERO);
        let behind = S::choose(passed, after, S::ZERO);
        mass.speed = after - behind * (*reversal * mass.bristle.slipping);
        Self { share, half }
    }

    /// The same where the corner at standstill is rounded, so that so much of it is left.
    #[inline(always)]
    pub(super) fn rounded(self, left: S) -> Self {
        Self { share: self.share * left, ..self }
    }

    /// ζ with what a speed that moved between the halves makes of it.
    #[inline(always)]
    pub(super) fn applied(turn: Option<&Self>, zeta: S, now: Half<S>) -> S {
        match turn {
            Some(turn) => {
                let swung = (now.reach - turn.half.reach) * (now.slope - turn.half.slope);
                zeta + zeta.nearest(turn.share + swung.swing())
            }
            None => zeta,
        }
    }
}
