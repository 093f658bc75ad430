//! What goes wrong between a joint and the rows of its log.
//!
//! A reported current is filtered or late, stamps jitter or belong to another row, and a bus reading
//! is the switching ripple, caught at random. None of it is a law of the joint.

use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

/// What the current's report has gone through.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reported {
    /// Nothing.
    #[default]
    AtOnce,
    /// It is late by so many samples.
    Late(f64),
    /// It is filtered by a first-order lag of this time constant, s.
    Filtered(f64),
}

impl Reported {
    /// How long before its row a value flowed, s.
    pub fn late_s(self, sample_s: f64) -> f64 {
        match self {
            Self::Late(samples) => samples * sample_s,
            Self::AtOnce | Self::Filtered(_) => 0.0,
        }
    }

    /// What flowed at these times, or [`Self::late_s`] before them, as it is reported.
    pub fn of(self, values: &[f64], time_s: &[f64]) -> Vec<f64> {
        match self {
            Self::AtOnce | Self::Late(_) => values.to_vec(),
            Self::Filtered(constant_s) => {
                let mut state = values.first().copied().unwrap_or(0.0);
                let mut before = time_s.first().copied().unwrap_or(0.0);
                let filtered = values.iter().zip(time_s).map(|(value, time)| {
                    state += (value - state) * -(-(time - before) / constant_s).exp_m1();
                    before = *time;
                    state
                });
                filtered.collect()
            }
        }
    }
}

/// What the stamps say of the instants at which rows were sampled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stamps {
    /// The instants, however uneven.
    #[default]
    Exact,
    /// An even grid, whatever the instants were.
    Even,
    /// The instant of the row before, an interval later.
    RowBefore,
}

/// Ticks of the clock in a sample.
const TICKS: f64 = 16.0;

/// Instants of `count` samples: an even grid with jitter of this standard deviation in samples, on
/// the ticks of a clock and never so large that two change places.
pub(super) fn instants(
    count: usize,
    sample_s: f64,
    jitter: f64,
    random: &mut impl Rng,
) -> Vec<f64> {
    (0..count)
        .map(|k| {
            if jitter <= 0.0 {
                return k as f64 * sample_s;
            }
            // A sum of three even deviations, near enough to normal and bounded.
            let sum: f64 = (0..3).map(|_| random.random_range(-1.0..1.0)).sum();
            let ticks = (TICKS * jitter * sum).round().clamp(-7.0, 7.0);
            (k as f64 + if k == 0 { 0.0 } else { ticks / TICKS }) * sample_s
        })
        .collect()
}

impl Stamps {
    /// What is written for these instants.
    pub fn of(self, instants: &[f64], sample_s: f64) -> Vec<f64> {
        let row = |k: usize| match self {
            Self::Exact => instants[k],
            Self::Even => k as f64 * sample_s,
            Self::RowBefore => k.checked_sub(1).map_or(0.0, |before| instants[before] + sample_s),
        };
        (0..instants.len()).map(row).collect()
    }
}

/// What a bus reading shows of a supply of `bus_v` behind a resistance, when the voltage and the
/// current are these: the dip, and ripple of up to `ripple` of the bus, largest at half duty.
pub(super) fn bus_reading(
    [bus_v, resistance, ripple]: [f64; 3],
    voltage: f64,
    current: f64,
    random: &mut impl Rng,
) -> f64 {
    let duty = (voltage / bus_v).abs().min(1.0);
    let dip = resistance * voltage * current / bus_v;
    let caught = 4.0 * duty * (1.0 - duty) * random.random_range(-1.0..1.0);
    bus_v - dip + ripple * bus_v * caught
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn a_filtered_current_has_its_time_constant() {
        let time_s: Vec<f64> = (0..=100).map(|k| 1e-3 * f64::from(k)).collect();
        let mut values = vec![1.0; 101];
        values[0] = 0.0;
        let filtered = Reported::Filtered(0.02).of(&values, &time_s);
        // After one time constant of a step 1 − 1/e is left to none.
        assert!((filtered[20] - (1.0 - (-1.0_f64).exp())).abs() < 1e-12);
    }

    #[test]
    fn stamps_rise_whatever_the_jitter() {
        let mut random = ChaCha8Rng::seed_from_u64(2);
        let instants = instants(5000, 1e-3, 0.3, &mut random);
        for stamps in [Stamps::Exact, Stamps::Even, Stamps::RowBefore] {
            let told = stamps.of(&instants, 1e-3);
            assert!(told.windows(2).all(|pair| pair[1] > pair[0]), "{stamps:?}");
        }
    }
}
