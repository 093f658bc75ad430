//! What a record's encoders and their clock scatter by, asked of its readings.

use super::record::{CHANNELS, Channel, Record};
use super::scatter::Scatter;

impl Record {
    /// Finds what the encoders and their clock scatter by.
    pub(super) fn ask_encoders(&mut self) {
        for channel in [Channel::Motor, Channel::Output] {
            let c = channel as usize;
            let angles: Vec<f64> = self.measured.iter().map(|row| row[c]).collect();
            let found = Scatter::of(&self.time_s, &angles, &self.starts, self.digit(channel));
            self.scatter[c] = found;
            let Some(jitter_s) = found.map(|it| it.jitter_s).filter(|jitter| *jitter > 0.0) else {
                continue;
            };
            self.jitter.resize(angles.len(), [0.0; CHANNELS]);
            for (k, row) in self.jitter.iter_mut().enumerate() {
                row[c] = (jitter_s * speed(&self.time_s, &angles, k)).powi(2);
            }
        }
    }
}

/// Speed at a sample, from its neighbours; zero where they are not known.
fn speed(time_s: &[f64], angle_rad: &[f64], k: usize) -> f64 {
    let (before, after) = (k.saturating_sub(2), (k + 2).min(time_s.len() - 1));
    let speed = (angle_rad[after] - angle_rad[before]) / (time_s[after] - time_s[before]);
    if speed.is_finite() { speed } else { 0.0 }
}
