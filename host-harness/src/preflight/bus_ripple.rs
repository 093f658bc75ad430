//! A bus reading that is the switching ripple, caught at random.
//!
//! Sampled slower than the inverter switches, a bus voltage scatters from sample to sample by what the motor
//! never saw: fast, and not following the power. Multiplied by the duty it becomes
//! noise in the voltage itself; then relative changes of u_v follow those of bus_v one to one.

use super::regression::Rows;
use super::{Case, Check, Finding};

/// Share of a reading's standard deviation that its changes from sample to sample make of a ripple; of a
/// white one they make all.
const FAST: f64 = 0.3;
/// Share of their variance that a sag leaves of a ripple.
const FOLLOWS: f64 = 0.5;
/// Steps of the reading's digits below which its scatter is rounding.
const ROUNDING: f64 = 1.5;
/// Standard errors beyond which the voltage carries it.
const CERTAIN: f64 = 4.0;
/// Share of the voltage from which on the scatter is told as an error: ten times what a supply is expected
/// to scatter in a fit.
const LARGE: f64 = 0.02;
/// Share of the largest voltage below which a relative change is rounding.
const STANDING: f64 = 0.2;

pub(super) const CHECK: Check =
    Check { name: "bus-ripple", compares: "bus_v against its neighbours, the power and u_v", run };

fn run(case: &Case<'_>) -> Vec<Finding> {
    let Some(bus) = case.log.bus_v.as_deref() else { return Vec::new() };
    let Some(scatter) = scatter(case, bus) else { return Vec::new() };
    let told = format!(
        "bus_v scatters by {scatter:.2} V from sample to sample and does not follow the power"
    );
    let Some((slope, error)) = carried(case, bus) else {
        return vec![warned(told)];
    };
    if slope - CERTAIN * error < 0.5 {
        return vec![warned(told)];
    }
    let level = bus.iter().filter(|v| v.is_finite()).sum::<f64>() / bus.len() as f64;
    let told = format!(
        "{told}, and u_v carries it ({slope:.2} of it): u_v was computed with readings of the switching \
         ripple that the motor never saw"
    );
    let help = "compute u_v from the duty and the supply's mean voltage";
    match scatter > LARGE * level.abs() {
        true => vec![Finding::error(told).help(help)],
        false => vec![Finding::warning(told).help(help)],
    }
}

fn warned(told: String) -> Finding {
    Finding::warning(told)
        .help("it looks like switching ripple, caught at random: leave bus_v out, or filter it")
}

/// Standard deviation of a reading's changes from sample to sample beside what a sag explains of them, over
/// √2, V; `None` where they are rounding, follow the power, or are small beside slow changes.
fn scatter(case: &Case<'_>, bus: &[f64]) -> Option<f64> {
    let log = case.log;
    // A supply sags with the power: u i, or u² where no current is logged.
    let power = |k: usize| match (&log.voltage_v, &log.current_a) {
        (Some(voltage), Some(current)) => voltage[k] * current[k],
        (Some(voltage), None) => voltage[k].powi(2),
        (None, Some(current)) => current[k].powi(2),
        (None, None) => 0.0,
    };
    let mut rows = Rows::new(1);
    (1..bus.len()).for_each(|k| rows.push(bus[k] - bus[k - 1], &[power(k) - power(k - 1)]));
    // The bus falls with the power; a voltage that was multiplied by the reading rises with it.
    let sag = rows.fit().map_or(0.0, |fit| fit.coefficients[0].min(0.0));
    let (mut whole, mut left, mut count, mut step) = (0.0, 0.0, 0.0, f64::INFINITY);
    for k in 1..bus.len() {
        let change = bus[k] - bus[k - 1];
        let own = change - sag * (power(k) - power(k - 1));
        if own.is_finite() {
            whole += change * change;
            left += own * own;
            count += 1.0;
            if change.abs() > 1e-9 * bus[k].abs() {
                step = step.min(change.abs());
            }
        }
    }
    let known = || bus.iter().filter(|v| v.is_finite());
    let (total, squares) = known().fold((0.0, 0.0), |(sum, squares), v| (sum + v, squares + v * v));
    let all = known().count() as f64;
    let spread = (squares / all - (total / all).powi(2)).max(0.0).sqrt();
    let scatter = (0.5 * left / count).sqrt();
    let fast = scatter > FAST * spread && left > FOLLOWS * whole;
    (count > 100.0 && fast && scatter > ROUNDING * step).then_some(scatter)
}

/// How much of the bus reading's relative changes the voltage makes along, and its standard error.
fn carried(case: &Case<'_>, bus: &[f64]) -> Option<(f64, f64)> {
    let voltage = case.log.voltage_v.as_ref()?;
    let largest = voltage.iter().fold(0.0_f64, |most, u| most.max(u.abs()));
    let mut rows = Rows::new(2);
    for k in 1..bus.len() {
        let stands = |k: usize| voltage[k].abs() > STANDING * largest;
        if stands(k) && stands(k - 1) && voltage[k] * voltage[k - 1] > 0.0 {
            rows.push((voltage[k] / voltage[k - 1]).ln(), &[(bus[k] / bus[k - 1]).ln(), 1.0]);
        }
    }
    Some(rows.fit()?.coefficient(0))
}

#[cfg(test)]
mod tests {
    use super::super::Severity;
    use super::super::made::{actuator_and_log, of};
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// What is found where the bus reads 24 V with this ripple and sag, and u_v was computed with it or not.
    fn found(ripple: f64, sag: f64, carried: bool) -> Vec<Finding> {
        let (model, mut log) = actuator_and_log();
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let current = log.current_a.clone().unwrap();
        let voltage = log.voltage_v.as_mut().unwrap();
        let bus: Vec<f64> = voltage
            .iter()
            .zip(&current)
            .map(|(u, i)| {
                let reading = 24.0 - sag * u * i / 24.0 + ripple * random.random_range(-1.0..1.0);
                (100.0 * reading).round() / 100.0
            })
            .collect();
        if carried {
            voltage.iter_mut().zip(&bus).for_each(|(u, bus)| *u *= bus / 24.0);
        }
        log.bus_v = Some(bus);
        of(&CHECK, &model, &log)
    }

    #[test]
    fn ripple_is_told_and_is_an_error_where_the_voltage_carries_it() {
        let beside = found(2.0, 0.0, false);
        assert!(beside.len() == 1 && beside[0].severity == Severity::Warning, "{beside:?}");
        assert!(beside[0].message.contains("does not follow the power"));
        let within = found(2.0, 0.0, true);
        assert!(within.len() == 1 && within[0].severity == Severity::Error, "{within:?}");
        assert!(within[0].message.contains("u_v carries it"));
    }

    #[test]
    fn a_steady_bus_and_one_that_sags_are_no_ripple() {
        assert_eq!(found(0.0, 0.0, false), []);
        assert_eq!(found(0.05, 1.0, false), []);
    }
}
