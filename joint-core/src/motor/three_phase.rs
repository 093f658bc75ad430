//! Three phases in star, equations (4) to (9), with any of them open.
//!
//! With R = 1 every driven phase obeys `di/dy = (u − u_n − e) − i` in units of the winding's own lag
//! L/R, where the star's voltage `u_n` is the mean of `u − e` over the phases that conduct: (9), and
//! with two of them (10). Between switchings that is one exponential, so each interval is carried in
//! closed form whatever its length. An open phase still carries its current through the diode of the
//! rail that lets it fall, until it is zero; that instant is found and the interval divided there. A
//! phase without current conducts again only where its terminal leaves the rails.
//!
//! Units: voltage of the bus, current bus/R, speed bus/k_e, torque `k_t/2` times a current.

use super::back_emf;
use crate::scalar::Real;

/// Most parts that one interval is divided into.
const MOST_PARTS: usize = 6;

/// What the inverter does with one phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leg {
    /// Switched to the bus.
    High,
    /// Switched to ground.
    Low,
    /// Both switches open; the diodes stay.
    Open,
}

/// Currents into the phases a, b and c, and what flowed since they were last cleared.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Phases<S> {
    /// Current into each phase; their sum is zero, equation (7).
    pub current: [S; 3],
    /// Integral of each current over time in lags.
    pub charge: [S; 3],
    /// Integral of `Σ i f(θe)`: of twice the torque over k_t, equation (6).
    pub impulse: S,
    /// Integral of `Σ u i` at the terminals.
    pub supplied: S,
    /// Integral of `Σ i²`, the heat.
    pub heat: S,
}

impl<S: Real> Phases<S> {
    /// Forgets what flowed; the currents stay.
    pub fn clear(&mut self) {
        *self = Self { current: self.current, ..Self::default() };
    }

    /// Energy in the inductances, in units of bus²/R times a lag.
    pub fn stored(&self) -> S {
        self.current.iter().fold(S::ZERO, |sum, i| sum + *i * *i) * S::HALF
    }
}

/// Voltage of a phase's terminal over one part of an interval; `None` where nothing flows.
fn terminal<S: Real>(leg: Leg, current: S) -> Option<S> {
    match leg {
        Leg::High => Some(S::ONE),
        Leg::Low => Some(S::ZERO),
        // The diode to ground lets current in, the one to the bus lets it out.
        Leg::Open if current > S::ZERO => Some(S::ZERO),
        Leg::Open if current < S::ZERO => Some(S::ONE),
        Leg::Open => None,
    }
}

/// Mean of `u − e` over the conducting phases, the star's voltage.
fn star<S: Real>(voltages: &[Option<S>; 3], emf: &[S; 3]) -> Option<S> {
    let third = S::from_f64(1.0 / 3.0);
    let (mut sum, mut conducting) = (S::ZERO, 0);
    for (voltage, e) in voltages.iter().zip(emf) {
        if let Some(u) = voltage {
            sum = sum + (*u - *e);
            conducting += 1;
        }
    }
    match conducting {
        0 => None,
        1 => Some(sum),
        2 => Some(sum * S::HALF),
        _ => Some(sum * third),
    }
}

/// Closes the diode of an idle phase whose terminal has left the rails.
fn let_conduct<S: Real>(voltages: &mut [Option<S>; 3], emf: &[S; 3]) {
    let Some(star) = star(voltages, emf) else {
        return between_two(voltages, emf);
    };
    for (voltage, e) in voltages.iter_mut().zip(emf) {
        if voltage.is_none() {
            if star + *e > S::ONE {
                *voltage = Some(S::ONE);
            } else if star + *e < S::ZERO {
                *voltage = Some(S::ZERO);
            }
        }
    }
}

/// With every phase open and idle, only a line-to-line EMF above the bus makes current flow.
fn between_two<S: Real>(voltages: &mut [Option<S>; 3], emf: &[S; 3]) {
    let most = emf.iter().fold(emf[0], |most, e| if *e > most { *e } else { most });
    let least = emf.iter().fold(emf[0], |least, e| if *e < least { *e } else { least });
    if most - least > S::ONE {
        for (voltage, e) in voltages.iter_mut().zip(emf) {
            if *e >= most {
                *voltage = Some(S::ONE);
            } else if *e <= least {
                *voltage = Some(S::ZERO);
            }
        }
    }
}

/// Carries the phases over one interval of `duration` lags in which nothing switches, at an
/// electrical angle (turns, −½ to ½) and speed held at their values in its middle.
pub fn advance<S: Real>(phases: &mut Phases<S>, legs: [Leg; 3], turns: S, speed: S, duration: S) {
    let shape = back_emf::of_phases(turns);
    let emf = shape.map(|f| speed * f);
    let mut left = duration;
    for part in 1..=MOST_PARTS {
        let [a, b, c] = legs;
        let [ia, ib, ic] = phases.current;
        let mut voltages = [terminal(a, ia), terminal(b, ib), terminal(c, ic)];
        let_conduct(&mut voltages, &emf);
        let star = star(&voltages, &emf).unwrap_or(S::ZERO);
        let mut settled = [S::ZERO; 3];
        for ((settled, voltage), e) in settled.iter_mut().zip(&voltages).zip(&emf) {
            *settled = voltage.map_or(S::ZERO, |u| u - star - *e);
        }
        let (length, ended) = match first_zero(legs, &phases.current, &settled, left) {
            Some((length, phase)) if part < MOST_PARTS => (length, Some(phase)),
            _ => (left, None),
        };
        carry(phases, &voltages, &settled, &shape, length);
        if let Some(phase) = ended {
            stop(&mut phases.current, phase);
        }
        left = left - length;
        if ended.is_none() {
            return;
        }
    }
}

/// When the first open phase runs out of current, in lags, and which it is.
fn first_zero<S: Real>(
    legs: [Leg; 3],
    current: &[S; 3],
    settled: &[S; 3],
    left: S,
) -> Option<(S, usize)> {
    let decay = left.exp_minus();
    let mut first = None;
    for (phase, ((leg, i), to)) in legs.into_iter().zip(current).zip(settled).enumerate() {
        let end = *to + (*i - *to) * decay;
        let falls = (*i > S::ZERO && end <= S::ZERO) || (*i < S::ZERO && end >= S::ZERO);
        if leg != Leg::Open || !falls {
            continue;
        }
        let length = zero_after(i.abs(), to.abs(), end.abs(), left);
        if first.is_none_or(|(earliest, _)| length < earliest) {
            first = Some((length, phase));
        }
    }
    first
}

/// When a current of this magnitude is zero that tends to `beyond` on the other side and would be
/// at `end` after `left`: `e^−y = r` with `r = beyond/(current + beyond)`, from the chord by
/// `ln(e/r) = 2 artanh((e − r)/(e + r))`.
fn zero_after<S: Real>(current: S, beyond: S, end: S, left: S) -> S {
    let span = current + end;
    if span <= S::ZERO {
        return S::ZERO;
    }
    let ratio = beyond.ratio(current + beyond);
    let mut length = left * current.ratio(span);
    for _ in 0..2 {
        let decay = length.exp_minus();
        let (over, sum) = (decay - ratio, decay + ratio);
        if sum <= S::ZERO {
            break;
        }
        let w = over.abs().ratio(sum);
        let w = if over < S::ZERO { -w } else { w };
        let third = S::from_f64(1.0 / 3.0);
        length = length + (w + w) * (S::ONE + w * w * third);
    }
    if length < S::ZERO {
        S::ZERO
    } else if length > left {
        left
    } else {
        length
    }
}

/// Every current over `length` lags towards what it settles at, and what flows meanwhile.
fn carry<S: Real>(
    phases: &mut Phases<S>,
    voltages: &[Option<S>; 3],
    settled: &[S; 3],
    shape: &[S; 3],
    length: S,
) {
    let decay = length.exp_minus();
    let gone = S::ONE - decay;
    let rows = phases.current.iter_mut().zip(&mut phases.charge);
    for ((((i, charge), u), to), f) in rows.zip(voltages).zip(settled).zip(shape) {
        let excess = *i - *to;
        let flowed = *to * length + excess * gone;
        *i = *to + excess * decay;
        *charge = *charge + flowed;
        phases.impulse = phases.impulse + flowed * *f;
        phases.supplied = phases.supplied + u.map_or(S::ZERO, |u| u * flowed);
        phases.heat = phases.heat
            + *to * (flowed + excess * gone)
            + excess * excess * (S::ONE - decay * decay) * S::HALF;
    }
}

/// Makes a phase's current exactly zero and keeps the sum of the others so.
fn stop<S: Real>(current: &mut [S; 3], phase: usize) {
    let mut rest = S::ZERO;
    let mut last = None;
    for (k, i) in current.iter_mut().enumerate() {
        if k == phase {
            *i = S::ZERO;
        } else {
            rest = rest + *i;
            last = Some(i);
        }
    }
    if let Some(last) = last {
        *last = *last - rest;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::Number;

    /// Equation (9) by small explicit steps, all phases driven, R = L = 1.
    fn printed(u: [f64; 3], e: [f64; 3], mut i: [f64; 2], duration: f64) -> [f64; 2] {
        let (uab, ubc) = (u[0] - u[1], u[1] - u[2]);
        let va = 2.0 * uab + ubc - 2.0 * e[0] + e[1] + e[2];
        let vb = -uab + ubc + e[0] - 2.0 * e[1] + e[2];
        let steps = 100_000;
        let h = duration / f64::from(steps);
        for _ in 0..steps {
            // The midpoint rule: its error is h² = 1e-11.
            let rate = |i: [f64; 2]| [(va - 3.0 * i[0]) / 3.0, (vb - 3.0 * i[1]) / 3.0];
            let first = rate(i);
            let second = rate([i[0] + 0.5 * h * first[0], i[1] + 0.5 * h * first[1]]);
            i = [i[0] + h * second[0], i[1] + h * second[1]];
        }
        i
    }

    #[test]
    fn three_driven_phases_obey_the_minimal_form() {
        let (turns, speed) = (0.37, 0.4);
        let start = [0.3, -0.1, -0.2];
        let mut phases = Phases { current: start, ..Phases::default() };
        advance(&mut phases, [Leg::High, Leg::Low, Leg::High], turns, speed, 0.8);
        let emf = back_emf::of_phases(turns).map(|f| speed * f);
        let [a, b] = printed([1.0, 0.0, 1.0], emf, [start[0], start[1]], 0.8);
        assert!((phases.current[0] - a).abs() < 1e-8 && (phases.current[1] - b).abs() < 1e-8);
    }

    #[test]
    fn two_driven_phases_obey_the_dc_equivalent() {
        let mut phases = Phases { current: [0.2, -0.2, 0.0], ..Phases::default() };
        // In the first sector a is at +1 and b at −1.
        advance(&mut phases, [Leg::High, Leg::Low, Leg::Open], 0.05, 0.3, 1.5);
        let settled = (1.0 - 2.0 * 0.3) / 2.0;
        let wanted = settled + (0.2 - settled) * (-1.5_f64).exp();
        assert!((phases.current[0] - wanted).abs() < 1e-9);
        assert_eq!(phases.current[2], 0.0);
    }

    #[test]
    fn an_opened_phase_runs_out_through_its_diode_and_stays_out() {
        let mut phases = Phases { current: [0.3, -0.5, 0.2], ..Phases::default() };
        let mut fine = phases;
        advance(&mut phases, [Leg::High, Leg::Low, Leg::Open], 0.02, 0.1, 2.0);
        assert_eq!(phases.current[2], 0.0);
        for _ in 0..20_000 {
            advance(&mut fine, [Leg::High, Leg::Low, Leg::Open], 0.02, 0.1, 1e-4);
        }
        for (one, many) in phases.current.iter().zip(fine.current) {
            assert!((one - many).abs() < 1e-6, "{phases:?} {fine:?}");
        }
        assert!((phases.heat - fine.heat).abs() < 1e-6);
    }

    #[test]
    fn a_motor_turned_faster_than_its_bus_feeds_it_back_through_the_diodes() {
        let mut phases = Phases::<f64>::default();
        advance(&mut phases, [Leg::Open; 3], 0.05, 0.4, 3.0);
        assert_eq!(phases.current, [0.0; 3]);
        advance(&mut phases, [Leg::Open; 3], 0.05, 0.8, 3.0);
        assert!(phases.current[0] < -0.1 && phases.supplied < 0.0, "{phases:?}");
    }

    #[test]
    fn what_is_supplied_is_heat_stored_and_moved() {
        let mut phases = Phases { current: [0.3, -0.5, 0.2], ..Phases::default() };
        let (stored, speed) = (phases.stored(), 0.35);
        for legs in [[Leg::High, Leg::Low, Leg::Open], [Leg::Open, Leg::Low, Leg::High]] {
            advance(&mut phases, legs, 0.17, speed, 0.7);
        }
        let balance = phases.supplied - phases.heat - (phases.stored() - stored);
        assert!((balance - speed * phases.impulse).abs() < 1e-9, "{phases:?}");
    }
}
