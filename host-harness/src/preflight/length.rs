//! Whether there is anything to learn from.

use super::{Case, Check, Finding};

/// Samples that a fit needs at least.
pub const LEAST_SAMPLES: usize = 200;

pub(super) const CHECK: Check =
    Check { name: "length", compares: "the number of samples with what a fit needs", run };

fn run(case: &Case<'_>) -> Vec<Finding> {
    let samples = case.log.len();
    if samples >= LEAST_SAMPLES {
        return Vec::new();
    }
    vec![
        Finding::error(format!("has {samples} samples; give at least {LEAST_SAMPLES}"))
            .help("log a longer motion, or at a higher rate"),
    ]
}

#[cfg(test)]
mod tests {
    use super::super::made::{actuator_and_log, of};
    use super::*;

    #[test]
    fn a_log_is_too_short_below_two_hundred_samples() {
        let (model, log) = actuator_and_log();
        let first = |count: usize| -> Vec<bool> { (0..log.len()).map(|k| k < count).collect() };
        assert_eq!(of(&CHECK, &model, &log.only(&first(200))), []);
        let told = of(&CHECK, &model, &log.only(&first(199)));
        assert_eq!(told[0].message, "has 199 samples; give at least 200");
    }
}
