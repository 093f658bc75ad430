//! A scenario of the paper as data: a motion of the motor and a load at the output.

use std::f64::consts::TAU;

use serde::Deserialize;

/// What the motor is to do and what it works against.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Its name.
    pub name: String,
    /// Length, s.
    pub duration_s: f64,
    /// Speed of the motor.
    pub speed: Profile,
    /// Load at the output; none where left out.
    #[serde(default)]
    pub load: Load,
}

/// Straight lines between corners `[s, rad/s]`; the first and last value hold outside.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    corners: Vec<[f64; 2]>,
}

/// A load against positive motion: constant, or a sine where there is a frequency.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Load {
    /// Amplitude, Nm.
    pub amplitude_nm: f64,
    /// Frequency, Hz; zero for a constant load.
    pub frequency_hz: f64,
    /// Phase at its start, rad.
    pub phase_rad: f64,
    /// When it comes on, s.
    pub from_s: f64,
    /// When it is taken off, s; never where left out.
    pub to_s: Option<f64>,
}

impl Profile {
    /// Value and slope at a time.
    pub fn at(&self, t: f64) -> (f64, f64) {
        let after = self.corners.partition_point(|[corner, _]| *corner <= t);
        match (after.checked_sub(1).and_then(|k| self.corners.get(k)), self.corners.get(after)) {
            (Some([t0, v0]), Some([t1, v1])) => {
                let slope = (v1 - v0) / (t1 - t0);
                (v0 + slope * (t - t0), slope)
            }
            (Some([_, v]), None) | (None, Some([_, v])) => (*v, 0.0),
            (None, None) => (0.0, 0.0),
        }
    }

    /// Largest magnitude.
    pub fn amplitude(&self) -> f64 {
        self.corners.iter().fold(0.0, |most, [_, v]| v.abs().max(most))
    }
}

impl Load {
    /// Value at a time, Nm.
    pub fn at(&self, t: f64) -> f64 {
        if t < self.from_s || self.to_s.is_some_and(|end| t >= end) {
            return 0.0;
        }
        if self.frequency_hz > 0.0 {
            let angle = TAU * self.frequency_hz * (t - self.from_s) + self.phase_rad;
            self.amplitude_nm * angle.sin()
        } else {
            self.amplitude_nm
        }
    }
}

/// The scenarios that are built in, by the name of their file.
const BUILT_IN: [(&str, &str); 6] = [
    ("figure06", include_str!("data/figure06.toml")),
    ("figure08", include_str!("data/figure08.toml")),
    ("figure09", include_str!("data/figure09.toml")),
    ("figure11_start_stop", include_str!("data/figure11_start_stop.toml")),
    ("figure11_forward_reverse", include_str!("data/figure11_forward_reverse.toml")),
    ("nominal_load", include_str!("data/nominal_load.toml")),
];

/// Every built-in scenario with the name of its file.
///
/// # Errors
/// A data file that does not read: file and reason.
pub fn built_in() -> Result<Vec<(&'static str, Scene)>, String> {
    BUILT_IN.iter().map(|(file, text)| Ok((*file, read(file, text)?))).collect()
}

/// Reads a data file.
///
/// # Errors
/// File and reason.
pub fn read<T: serde::de::DeserializeOwned>(file: &str, text: &str) -> Result<T, String> {
    toml_edit::de::from_str(text).map_err(|error| format!("{file}.toml: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scenario_reads_and_its_corners_rise() {
        let all = built_in().unwrap();
        for (file, scene) in &all {
            let corners = &scene.speed.corners;
            assert!(corners.windows(2).all(|pair| pair[0][0] < pair[1][0]), "{file}");
            assert!(corners.last().unwrap()[0] <= scene.duration_s, "{file}");
        }
        let trapezoid = &all[0].1.speed;
        assert_eq!(trapezoid.at(0.0025), (250.0, 1e5));
        assert_eq!((trapezoid.at(0.04), trapezoid.amplitude()), ((-300.0, 0.0), 500.0));
    }

    #[test]
    fn loads_come_on_and_off_at_their_times() {
        let load = Load { amplitude_nm: 2.0, from_s: 1.0, to_s: Some(2.0), ..Load::default() };
        assert_eq!([0.9, 1.0, 1.9, 2.0].map(|t| load.at(t)), [0.0, 2.0, 2.0, 0.0]);
    }
}
