//! Channels that never change, or stop changing.

use super::windows::{scatter, travel};
use super::{Case, Check, Finding};
use crate::log::{CURRENT, MOTOR_ANGLE, OUTPUT_ANGLE, VOLTAGE};
use crate::plant::output_shaft;

/// Counts of travel that an output must be expected to make for its rest to tell.
const COUNTS: f64 = 10.0;
/// Samples without a change from which on a channel that scatters is stuck.
const STUCK: usize = 50;
/// Share of its samples in which a channel changes for its scatter to be known.
const LIVELY: f64 = 0.9;

pub(super) const CHECK: Check =
    Check { name: "moves", compares: "each channel against a constant", run };

fn run(case: &Case<'_>) -> Vec<Finding> {
    let log = case.log;
    let turned = travel(&log.motor_angle_rad);
    if turned == 0.0 {
        return vec![
            Finding::warning(format!(
                "{MOTOR_ANGLE} never changes: a joint at rest shows next to nothing"
            ))
            .help("log while the joint moves, in both directions"),
        ];
    }
    let mut all = Vec::new();
    if let Some(output) = &log.output_angle_rad {
        let step = case.model.sensor.output_encoder_counts_per_rev;
        let step = if step > 0.0 { std::f64::consts::TAU / step } else { scatter(output) };
        if travel(output) == 0.0 && turned * output_shaft(case.model).abs() > COUNTS * step {
            all.push(
                Finding::warning(format!(
                    "{OUTPUT_ANGLE} never changes while the motor turns by {turned:.2} rad"
                ))
                .help("is that encoder connected? leave the column out if not"),
            );
        }
    }
    let inputs = [(VOLTAGE, &log.voltage_v), (CURRENT, &log.current_a)];
    for (name, values) in inputs.into_iter().filter_map(|(name, v)| Some((name, v.as_deref()?))) {
        if travel(values) == 0.0 {
            all.push(
                Finding::warning(format!(
                    "{name} never changes while the motor turns by {turned:.2} rad"
                ))
                .help(format!("is {name} measured? leave the column out if not")),
            );
        }
    }
    if let (Some(current), Some(_)) = (&log.current_a, &log.voltage_v) {
        all.extend(stuck(case, CURRENT, current));
    }
    all
}

/// A measured channel that changes all the time, and then no more.
fn stuck(case: &Case<'_>, name: &str, values: &[f64]) -> Option<Finding> {
    let angle = &case.log.motor_angle_rad;
    let same = |k: &usize| values[*k] == values[k - 1];
    let (mut run, mut longest, mut still) = (0, (0, 0), 0);
    for k in 1..values.len() {
        run = if same(&k) { run + 1 } else { 0 };
        still += usize::from(same(&k));
        // While the joint rests, a channel may rest.
        if run > longest.0 && angle[k] != angle[k - run] {
            longest = (run, k);
        }
    }
    let others = (values.len() - longest.0).max(1);
    let lively = (still - longest.0.min(still)) as f64 <= (1.0 - LIVELY) * others as f64;
    (longest.0 >= STUCK && lively).then(|| {
        let [from, to] = [longest.1 - longest.0, longest.1];
        let time = &case.log.time_s;
        Finding::warning(format!(
            "{name} is stuck from t_s = {} to {} while the joint moves",
            time[from], time[to]
        ))
        .help("leave these fields empty")
        .at(from)
    })
}

#[cfg(test)]
mod tests {
    use super::super::made::{actuator_and_log, of};
    use super::*;

    #[test]
    fn channels_that_never_change_are_told_by_name() {
        let (model, good) = actuator_and_log();
        assert_eq!(of(&CHECK, &model, &good), []);
        let mut log = good.clone();
        log.motor_angle_rad.fill(0.3);
        assert!(of(&CHECK, &model, &log)[0].message.starts_with("motor_angle_rad never changes"));
        let mut log = good.clone();
        log.output_angle_rad.as_mut().unwrap().fill(0.0);
        log.current_a.as_mut().unwrap().fill(1.0);
        let told = of(&CHECK, &model, &log);
        assert!(told[0].message.starts_with("output_angle_rad never changes"), "{told:?}");
        assert!(told[1].message.starts_with("i_a never changes"), "{told:?}");
    }

    #[test]
    fn a_current_that_stops_changing_is_told_with_its_time() {
        let (model, mut log) = actuator_and_log();
        log.current_a.as_mut().unwrap()[3000..3400].fill(0.77);
        let told = of(&CHECK, &model, &log);
        assert_eq!(told[0].row, Some(3000), "{told:?}");
    }
}
