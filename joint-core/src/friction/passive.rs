//! Up to which speed LuGre friction gives back no more than it has stored.

use crate::params::Friction;

impl Friction {
    /// Speed, rad/s, up to which friction is passive: never gives back more than its bristles have stored,
    /// however the speed moves. Infinite where that holds at every speed.
    ///
    /// With `s = σ0 |z|/g(v)` the law takes `σ1 v² (1 − s) + g s² |v| + σ2 v²` beside what it stores, and s is
    /// at most `g_max/g_min`: never negative where `σ1 (g_max/g_min − 1) ≤ σ2`, and up to `|v| = 4 g_min/σ1`.
    /// Beyond, bristles that were bent at a high level and are let go within their reach give back more.
    /// Source: N. Barabanov and R. Ortega, "Necessary and sufficient conditions for passivity of the LuGre
    /// friction model", IEEE Trans. Autom. Control 45(4), 2000.
    pub fn passive_to_rad_per_s(&self) -> f64 {
        let [least, most] = match self.breakaway_nm() < self.coulomb_nm {
            true => [self.breakaway_nm(), self.coulomb_nm],
            false => [self.coulomb_nm, self.breakaway_nm()],
        };
        let sigma1 = self.sigma1_nm_s_per_rad;
        if sigma1 * (most - least) <= self.sigma2_nm_s_per_rad * least {
            return f64::INFINITY;
        }
        4.0 * least / sigma1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn friction(stribeck_nm: f64, sigma2_nm_s_per_rad: f64) -> Friction {
        Friction {
            sigma0_nm_per_rad: 100.0,
            sigma1_nm_s_per_rad: 2.0,
            sigma2_nm_s_per_rad,
            coulomb_nm: 1.0,
            stribeck_nm,
            stribeck_velocity_rad_per_s: 0.1,
        }
    }

    #[test]
    fn friction_is_passive_at_every_speed_up_to_the_bound_of_its_viscous_part() {
        // σ1 (g_max/g_min − 1): 2 (1.5 − 1) above the Coulomb level, 2 (1/0.5 − 1) below it.
        for (stribeck, bound, level) in [(0.5, 1.0, 1.0), (-0.5, 2.0, 0.5)] {
            assert_eq!(friction(stribeck, bound).passive_to_rad_per_s(), f64::INFINITY);
            assert_eq!(friction(stribeck, 0.99 * bound).passive_to_rad_per_s(), 2.0 * level);
        }
        assert_eq!(friction(0.0, 0.0).passive_to_rad_per_s(), f64::INFINITY);
    }
}
