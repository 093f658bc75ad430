//! The amplifier's power stage and its current loop.
//!
//! One phase is chopped between bus and ground, one is held at ground, one is open; the other
//! direction chops the other phase. A switch closes only a dead time after its partner has opened,
//! in which the phase's current picks the rail by itself: the voltage that this costs, or gives,
//! follows from [`super::three_phase`] and is not put in. The current loop is a PI controller on the
//! period's mean current, its zero on the winding's pole.

use super::commutation::Conduction;
use super::three_phase::Leg;
use crate::params::{Check, Motor, ParameterError, Reason, Table};
use crate::scalar::Real;

/// A servo amplifier.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Amplifier {
    /// Voltage of the bus, V.
    pub bus_v: f64,
    /// Period of the pulse-width modulation, s; the joint is stepped once in it.
    pub pwm_period_s: f64,
    /// Time between the opening of one switch and the closing of its partner, s.
    pub dead_time_s: f64,
    /// Bandwidth of the current loop, rad/s.
    pub current_bandwidth_rad_per_s: f64,
    /// Largest current that is commanded, A.
    pub current_limit_a: f64,
}

impl Amplifier {
    /// Checks the values, and that the motor has a winding to feed.
    ///
    /// # Errors
    /// The first value that the equations cannot take.
    pub fn validate(&self, motor: &Motor) -> Result<(), ParameterError> {
        let check = Check(Table::Motor);
        check.positive("phase_resistance_ohm", motor.phase_resistance_ohm)?;
        check.positive("phase_inductance_h", motor.phase_inductance_h)?;
        let check = Check(Table::Amplifier);
        check.positive("bus_v", self.bus_v)?;
        check.positive("pwm_period_s", self.pwm_period_s)?;
        check.not_negative("dead_time_s", self.dead_time_s)?;
        let most = self.pwm_period_s / 2.0;
        if self.dead_time_s > most {
            let reason = Reason::OutOfRange { low: 0.0, high: most };
            return Err(check.fail("dead_time_s", self.dead_time_s, reason));
        }
        let key = "current_bandwidth_rad_per_s";
        check.positive(key, self.current_bandwidth_rad_per_s)?;
        // Once a period the loop may take at most the whole error away.
        let most = 0.5 / self.pwm_period_s;
        if self.current_bandwidth_rad_per_s > most {
            let reason = Reason::OutOfRange { low: 0.0, high: most };
            return Err(check.fail(key, self.current_bandwidth_rad_per_s, reason));
        }
        check.positive("current_limit_a", self.current_limit_a)
    }
}

/// One part of a period: what the legs do, and for which share of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval<S> {
    /// The legs of the phases a, b and c.
    pub legs: [Leg; 3],
    /// Its share of the period.
    pub share: S,
}

/// The four parts of a period at a duty from −1 to 1; `dead` is the dead time's share.
#[inline]
pub fn period<S: Real>(conduction: Conduction, duty: S, dead: S) -> [Interval<S>; 4] {
    let conduction = if duty < S::ZERO { conduction.reversed() } else { conduction };
    let on = duty.abs();
    let legs = |chopped: Leg| {
        let mut legs = [Leg::Open; 3];
        for (phase, leg) in legs.iter_mut().enumerate() {
            if phase == conduction.high {
                *leg = chopped;
            } else if phase == conduction.low {
                *leg = Leg::Low;
            }
        }
        legs
    };
    let off = S::ONE - on;
    // Without a change of state there is no dead time.
    let least = |a: S, b: S| if a < b { a } else { b };
    let switches = on > S::ZERO && off > S::ZERO;
    let [before, after] =
        if switches { [least(dead, on), least(dead, off)] } else { [S::ZERO, S::ZERO] };
    [
        Interval { legs: legs(Leg::Open), share: before },
        Interval { legs: legs(Leg::High), share: on - before },
        Interval { legs: legs(Leg::Open), share: after },
        Interval { legs: legs(Leg::Low), share: off - after },
    ]
}

/// The current loop, per-unit: currents in bus/R, voltages as duty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurrentLoop<S: Real> {
    proportional: S::Gain,
    integral: S::Gain,
}

impl<S: Real> CurrentLoop<S> {
    /// For a plant `2R i + 2L di/dt`: gains 2Lω and 2Rω at bandwidth ω.
    pub fn new(amplifier: &Amplifier, lag_s: f64) -> Self {
        let bandwidth = amplifier.current_bandwidth_rad_per_s;
        Self {
            proportional: S::gain(2.0 * bandwidth * lag_s),
            integral: S::gain(2.0 * bandwidth * amplifier.pwm_period_s),
        }
    }

    /// The duty for the next period; the integral stops where the duty is at its end.
    #[inline]
    pub fn duty(&self, integral: &mut S, error: S) -> S {
        let summed = clamped(*integral + error.times(self.integral));
        let duty = summed + error.times(self.proportional);
        if duty.abs() <= S::ONE {
            *integral = summed;
        }
        clamped(duty)
    }
}

/// Limited to ±1.
pub(crate) fn clamped<S: Real>(value: S) -> S {
    if value > S::ONE {
        S::ONE
    } else if value < -S::ONE {
        -S::ONE
    } else {
        value
    }
}

#[cfg(test)]
mod tests {
    use super::super::commutation::SECTORS;
    use super::*;

    #[test]
    fn the_parts_fill_the_period_and_never_close_both_switches() {
        for k in -20..=20 {
            let duty = f64::from(k) / 20.0;
            let parts = period(SECTORS[2], duty, 0.04);
            let whole: f64 = parts.iter().map(|part| part.share).sum();
            assert!((whole - 1.0).abs() < 1e-12 && parts.iter().all(|part| part.share >= 0.0));
            let on: f64 =
                parts.iter().filter(|p| p.legs.contains(&Leg::High)).map(|p| p.share).sum();
            assert!(on <= duty.abs() && on >= duty.abs() - 0.04 - 1e-12, "{duty}: {on}");
        }
    }
}
