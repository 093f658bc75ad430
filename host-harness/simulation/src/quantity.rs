//! The states by name, and how far two runs lie apart in one of them.

use std::fmt;

use crate::plant::Snapshot;

/// One state of a joint; stages count from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Current in the winding.
    Current,
    /// Rotor angle.
    MotorAngle,
    /// Rotor speed.
    MotorSpeed,
    /// Rotor bristle.
    MotorBristle,
    /// Angle behind a stage.
    StageAngle(usize),
    /// Speed behind a stage.
    StageSpeed(usize),
    /// Bristle behind a stage.
    StageBristle(usize),
}

impl Quantity {
    /// Every state of a joint with this many stages.
    pub fn of(stages: usize) -> Vec<Self> {
        let mut all = vec![Self::Current, Self::MotorAngle, Self::MotorSpeed, Self::MotorBristle];
        for k in 1..=stages {
            all.extend([Self::StageAngle(k), Self::StageSpeed(k), Self::StageBristle(k)]);
        }
        all
    }

    /// Whether it is an angle, for which tighter bounds hold.
    pub fn is_angle(self) -> bool {
        matches!(self, Self::MotorAngle | Self::StageAngle(_))
    }

    /// Its value; NaN for a stage that is not there.
    pub fn value(self, snapshot: &Snapshot) -> f64 {
        let stage = |k: usize| k.checked_sub(1).and_then(|k| snapshot.stages.get(k));
        match self {
            Self::Current => snapshot.current_a,
            Self::MotorAngle => snapshot.motor_angle_rad,
            Self::MotorSpeed => snapshot.motor_speed_rad_per_s,
            Self::MotorBristle => snapshot.motor_bristle,
            Self::StageAngle(k) => stage(k).map_or(f64::NAN, |stage| stage.angle_rad),
            Self::StageSpeed(k) => stage(k).map_or(f64::NAN, |stage| stage.speed_rad_per_s),
            Self::StageBristle(k) => stage(k).map_or(f64::NAN, |stage| stage.bristle),
        }
    }

    /// RMS of the difference over the RMS of the reference; zero where both are zero throughout.
    pub fn relative_rms(self, reference: &[Snapshot], other: &[Snapshot]) -> f64 {
        let (mut size, mut error) = (0.0, 0.0);
        for (reference, other) in reference.iter().zip(other) {
            let (wanted, found) = (self.value(reference), self.value(other));
            size += wanted * wanted;
            error += (found - wanted) * (found - wanted);
        }
        if error == 0.0 { 0.0 } else { (error / size).sqrt() }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Current => f.write_str("current"),
            Self::MotorAngle => f.write_str("motor_angle"),
            Self::MotorSpeed => f.write_str("motor_speed"),
            Self::MotorBristle => f.write_str("motor_bristle"),
            Self::StageAngle(k) => write!(f, "stage{k}_angle"),
            Self::StageSpeed(k) => write!(f, "stage{k}_speed"),
            Self::StageBristle(k) => write!(f, "stage{k}_bristle"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tenth_too_much_everywhere_is_a_tenth() {
        let at = |current_a: f64| Snapshot { current_a, ..Snapshot::default() };
        let wanted: Vec<_> = [1.0, -2.0, 3.0].map(at).into();
        let found: Vec<_> = [1.1, -2.2, 3.3].map(at).into();
        assert!((Quantity::Current.relative_rms(&wanted, &found) - 0.1).abs() < 1e-12);
        assert_eq!(Quantity::MotorSpeed.relative_rms(&wanted, &found), 0.0);
        assert!(Quantity::StageSpeed(1).relative_rms(&wanted, &found).is_nan());
    }
}
