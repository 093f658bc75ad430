//! The torque that the drive makes against the motion that follows: what several checks ask.
//!
//! Below the joint's first anti-resonance it turns as one: T = J ω̇ + F_c sgn ω + F_v ω + T_0 + g(q), with
//! T = k_t i, or k_t (u − 2 k_e ω) / 2R where no current is logged, J the inertia of all masses at the
//! motor, and g a torque that follows the output's angle: sine and cosine of one turn where the log covers
//! half of one, else a parabola. It is linear in its coefficients and solved for the acceleration, which is
//! the noisy side; where the joint hardly accelerates, for the torque.

use joint_core::per_unit::Bases;

use super::regression::{Fit, Rows};
use super::windows::{Windows, extremes, scatter};
use crate::log::Log;
use crate::model::Model;
use crate::plant::{inertias, output_shaft};

/// Columns of the regression.
pub(super) const ACCELERATION: usize = 0;
pub(super) const COULOMB: usize = 1;
pub(super) const VISCOUS: usize = 2;
const POSITION: usize = 3;
/// Periods of the first anti-resonance in a window: the filter passes what is slower than half of it.
const PERIODS: f64 = 4.0;
/// Standard deviations of a speed beyond which its sign is known.
const MOVING: f64 = 3.0;
/// Share of half a window within which the speed may change its sign: its weights beyond are a twentieth.
const WITHIN: f64 = 0.4;
/// Travel of the output from which on a turn's sine is told from a parabola, rad.
const HALF_TURN: f64 = std::f64::consts::PI;

/// How well the torque's share in the acceleration has to be known for the latter to be solved for.
const KNOWN: f64 = 0.1;
/// Standard errors beyond which a coefficient is there.
pub(super) const CERTAIN: f64 = 5.0;

/// The regression, and what it was made from.
#[derive(Clone, Debug)]
pub(super) struct TorqueBalance {
    /// Solved for the torque, or for the acceleration; the torque's column is the acceleration's then.
    fit: Fit,
    for_acceleration: bool,
    /// Robust standard deviation of the torque that is left, Nm at the motor.
    pub(super) residual: f64,
    /// Inertia of all masses at the motor by the model, kg m².
    pub(super) inertia: f64,
    /// Torque that follows the output angle once a turn, where sine and cosine explain more than a parabola.
    pub(super) weight: Option<Weight>,
    /// Mean speed and mean square of the speed where the joint moves.
    pub(super) speeds: [f64; 2],
    /// RMS of the acceleration where the joint moves, rad/s².
    pub(super) acceleration: f64,
    /// RMS of the drive's torque, Nm at the motor.
    pub(super) torque: f64,
    /// Highest speed of the rotor, rad/s.
    pub(super) fastest: f64,
    /// Whether the joint moves both ways.
    pub(super) both_ways: bool,
}

/// A torque sine · sin q + cosine · cos q of the output angle, Nm at the motor, with standard errors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weight {
    pub(super) sine: (f64, f64),
    pub(super) cosine: (f64, f64),
    /// Robust standard deviation of the torque that is left beside it.
    pub(super) residual: f64,
}

impl Weight {
    /// Amplitude with its standard error, and whether it stands out of that and of what is left.
    pub(super) fn amplitude(&self) -> (f64, f64) {
        let ((sine, sine_error), (cosine, cosine_error)) = (self.sine, self.cosine);
        let amplitude = sine.hypot(cosine);
        (amplitude, (sine * sine_error).hypot(cosine * cosine_error) / amplitude)
    }

    /// Whether it is certain by so many standard errors, and more than what is left.
    pub(super) fn stands_out(&self, certain: f64) -> bool {
        let (amplitude, error) = self.amplitude();
        amplitude > certain * error && amplitude > 2.0_f64.sqrt() * self.residual
    }

    /// From fits with sine and cosine and with a parabola, times `scale` a torque.
    fn of(turning: &Fit, bowed: &Fit, scale: f64) -> Option<Self> {
        let told = |column: usize| {
            let (value, error) = turning.coefficient(column);
            (scale * value, (scale * error).abs())
        };
        (turning.residual < bowed.residual).then(|| Self {
            sine: told(POSITION),
            cosine: told(POSITION + 1),
            residual: (scale * turning.residual).abs(),
        })
    }
}

/// Shortest window in which the joint turns as one, s.
pub(super) fn as_one_s(model: &Model) -> f64 {
    let bases = Bases::si(&model.motor, &model.stages);
    let inertias = inertias(model);
    let mut behind = 0.0;
    let mut longest = 0.0_f64;
    for stage in (0..model.stages.len()).rev() {
        behind += inertias[stage + 1];
        let shaft = bases.shaft(stage + 1);
        let stiffness = model.stages[stage].stiffness_nm_per_rad * shaft * shaft;
        let period = std::f64::consts::TAU * (behind / stiffness).sqrt();
        longest = longest.max(PERIODS * period);
    }
    longest
}

/// What the drive makes, Nm at the motor, in windows.
pub(super) fn drive_torque(
    model: &Model,
    log: &Log,
    windows: &Windows,
    speeds: &[f64],
) -> Option<Vec<f64>> {
    let motor = &model.motor;
    let constant = motor.torque_constant_nm_per_a;
    if let Some(current) = &log.current_a {
        let means = match log.voltage_v {
            Some(_) => windows.means(&log.time_s, current),
            None => windows.held_means(&log.time_s, current),
        };
        return Some(means.into_iter().map(|i| constant * i).collect());
    }
    let (voltage, resistance) = (log.voltage_v.as_ref()?, 2.0 * motor.phase_resistance_ohm);
    let pairs = windows.held_means(&log.time_s, voltage).into_iter().zip(speeds);
    (resistance > 0.0).then(|| {
        pairs
            .map(|(u, w)| constant * (u - 2.0 * motor.back_emf_constant() * w) / resistance)
            .collect()
    })
}

impl TorqueBalance {
    pub(super) fn of(model: &Model, log: &Log) -> Option<Self> {
        let windows = Windows::clear(log, &log.motor_angle_rad, as_one_s(model));
        let (speeds, accelerations) = windows.derivatives(&log.time_s, &log.motor_angle_rad);
        let torques = drive_torque(model, log, &windows, &speeds)?;
        let loads = log.load_torque_nm.as_ref().map(|load| windows.means(&log.time_s, load));
        let shaft = output_shaft(model);
        let angles: Vec<f64> = match &log.output_angle_rad {
            Some(output) => windows.means(&log.time_s, output),
            None => {
                windows.means(&log.time_s, &log.motor_angle_rad).iter().map(|q| q * shaft).collect()
            }
        };
        let [low, high] = extremes(&angles);
        let periodic = high - low > HALF_TURN;
        let position = |angle: f64, periodic: bool| {
            if periodic {
                return [angle.sin(), angle.cos()];
            }
            let across = (2.0 * angle - low - high) / (high - low);
            [across, across * across - 1.0 / 3.0]
        };
        let slowest = MOVING * windows.noise().0 * scatter(&log.motor_angle_rad);
        let half = 0.5 * WITHIN * windows.length_s();
        let moving = |k: usize| speeds[k].abs() > slowest.max(accelerations[k].abs() * half);
        let rows_at = |k: usize, periodic: bool| {
            let [first, second] = position(angles[k], periodic);
            [accelerations[k], speeds[k].signum(), speeds[k], first, second, 1.0]
        };
        let used: Vec<usize> = (0..windows.len()).filter(|k| moving(*k)).collect();
        let ahead = used.iter().filter(|k| speeds[**k] > 0.0).count();
        let both_ways = ahead.min(used.len() - ahead) * 20 >= used.len();
        // Moving one way, friction and a constant torque are the same; a log that hardly moves the output
        // does not tell the position's columns.
        let solved = |columns: &[usize], periodic: bool, for_acceleration: bool| {
            let mut rows = Rows::new(columns.len());
            for k in used.iter().copied() {
                let load = loads.as_ref().map_or(0.0, |loads| loads[k] * shaft);
                let mut all = rows_at(k, periodic);
                let mut target = torques[k] - load;
                if for_acceleration {
                    std::mem::swap(&mut target, &mut all[ACCELERATION]);
                }
                let chosen: Vec<f64> = columns.iter().map(|column| all[*column]).collect();
                rows.push(target, &chosen);
            }
            rows.fit()
        };
        let inertia: f64 = inertias(model).iter().sum();
        let columns: &[usize] = if both_ways { &[0, 1, 2, 3, 4, 5] } else { &[0, 1, 2, 3, 4] };
        let plain: &[usize] = if both_ways { &[0, 1, 2, 5] } else { &[0, 1, 2] };
        let [by_acceleration, by_torque] = [true, false].map(|side| {
            let turning = if periodic { solved(columns, true, side) } else { None };
            [turning, solved(columns, false, side).or_else(|| solved(plain, false, side))]
        });
        let known = |fit: &Fit| {
            let (value, error) = fit.coefficient(ACCELERATION);
            error < KNOWN * value.abs()
        };
        // What swings freely shows a weight in its acceleration, whatever the drive does; its inertia is the
        // model's where the log does not tell it.
        let swing = match &by_acceleration {
            [Some(turning), Some(bowed)] => {
                let own = turning.coefficients[ACCELERATION];
                let scale = if known(turning) { -1.0 / own } else { -inertia };
                Weight::of(turning, bowed, scale)
            }
            _ => None,
        };
        let weight =
            swing.filter(|weight| weight.stands_out(CERTAIN)).or_else(|| match &by_torque {
                [Some(turning), Some(bowed)] => Weight::of(turning, bowed, 1.0),
                _ => None,
            });
        let better = |[turning, bowed]: [Option<Fit>; 2]| match (turning, bowed) {
            (Some(turning), Some(bowed)) if bowed.residual < turning.residual => Some(bowed),
            (turning, bowed) => turning.or(bowed),
        };
        let accelerating = better(by_acceleration).filter(known);
        let for_acceleration = accelerating.is_some();
        let fit = accelerating.or_else(|| better(by_torque))?;
        let residual = match for_acceleration {
            true => fit.residual / fit.coefficients[ACCELERATION].abs(),
            false => fit.residual,
        };
        let count = used.len() as f64;
        let sums = used.iter().fold([0.0; 2], |sums, k| {
            [sums[0] + speeds[*k].abs() / count, sums[1] + speeds[*k].powi(2) / count]
        });
        let squares: f64 = used.iter().map(|k| accelerations[*k].powi(2)).sum();
        let acceleration = (squares / count).sqrt();
        let squares: f64 = used.iter().map(|k| torques[*k].powi(2)).filter(|t| t.is_finite()).sum();
        let torque = (squares / count).sqrt();
        let fastest =
            speeds.iter().filter(|w| w.is_finite()).fold(0.0_f64, |most, w| most.max(w.abs()));
        Some(Self {
            fit,
            for_acceleration,
            residual,
            inertia,
            weight,
            speeds: sums,
            acceleration,
            torque,
            fastest,
            both_ways,
        })
    }

    /// A quantity that follows from the coefficients of the torque, and its standard error.
    fn quantity(&self, of: impl Fn(&dyn Fn(usize) -> f64) -> f64) -> (f64, f64) {
        self.fit.quantity(|fitted| {
            of(&|column| match (self.for_acceleration, column) {
                (false, column) => fitted[column],
                (true, ACCELERATION) => 1.0 / fitted[ACCELERATION],
                (true, column) => -fitted[column] / fitted[ACCELERATION],
            })
        })
    }

    /// A coefficient of the torque, in Nm at the motor over the unit of its column, and its standard error.
    pub(super) fn coefficient(&self, column: usize) -> (f64, f64) {
        self.quantity(|coefficient| coefficient(column))
    }

    /// Mean power that friction takes by the log, W, and its standard error.
    pub(super) fn dissipated(&self) -> (f64, f64) {
        let [mean, square] = self.speeds;
        self.quantity(|coefficient| coefficient(COULOMB) * mean + coefficient(VISCOUS) * square)
    }
}

#[cfg(test)]
mod tests {
    use super::super::made::actuator_and_log;
    use super::*;

    #[test]
    fn inertia_and_friction_of_a_made_log_come_out() {
        let (model, log) = actuator_and_log();
        let balance = TorqueBalance::of(&model, &log).unwrap();
        let (inertia, error) = balance.coefficient(ACCELERATION);
        // Bristles and the gear's spring bias what is taken for rigid: a tenth is far from any unit.
        assert!((inertia / balance.inertia - 1.0).abs() < 0.1 + 4.0 * error / balance.inertia);
        let coulomb = balance.coefficient(COULOMB).0;
        let nominal = 0.014 + 0.12 / 9.0;
        assert!((coulomb / nominal - 1.0).abs() < 0.3, "{coulomb} of {nominal}");
        assert!(balance.both_ways && balance.dissipated().0 > 0.0);
    }
}
