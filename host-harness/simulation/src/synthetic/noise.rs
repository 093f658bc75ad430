//! Noise with a memory.
//!
//! What disturbs a real joint is not drawn anew at every sample: friction wanders, cables pull,
//! other axes push. The plainest such process is the one of Ornstein and Uhlenbeck (Phys. Rev. 36,
//! 1930), whose correlation falls exponentially with time.

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// Size and colour of a disturbance.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Colour {
    /// Standard deviation, in the unit of what it disturbs.
    pub deviation: f64,
    /// Time over which the correlation falls to 1/e, s.
    pub correlation_s: f64,
}

impl Colour {
    /// The process at these times, from its stationary distribution on.
    pub fn at(&self, time_s: &[f64], random: &mut impl Rng) -> Vec<f64> {
        let mut normal = || -> f64 { StandardNormal.sample(random) };
        let mut value = self.deviation * normal();
        let mut series = Vec::with_capacity(time_s.len());
        for k in 0..time_s.len() {
            if k > 0 {
                let kept = (-(time_s[k] - time_s[k - 1]) / self.correlation_s).exp();
                value = kept * value + self.deviation * (1.0 - kept * kept).sqrt() * normal();
            }
            series.push(value);
        }
        series
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn the_process_has_its_size_and_its_correlation() {
        let colour = Colour { deviation: 3.0, correlation_s: 0.02 };
        let time_s: Vec<f64> = (0..400_000).map(|k| 1e-3 * f64::from(k)).collect();
        let series = colour.at(&time_s, &mut ChaCha8Rng::seed_from_u64(1));
        let count = series.len() as f64;
        let variance = series.iter().map(|x| x * x).sum::<f64>() / count;
        let lag = series.iter().zip(&series[20..]).map(|(a, b)| a * b).sum::<f64>() / count;
        // 400 s hold 10,000 independent values: their variance is off by 1.4 %, three of it are 4 %.
        assert!((variance / 9.0 - 1.0).abs() < 0.05, "{variance}");
        assert!((lag / variance - (-1.0_f64).exp()).abs() < 0.05, "{}", lag / variance);
    }
}
