//! Hardening stiffness: a stage that winds up less at large torques than its spring says. A spring that bends
//! by more than its own stiffness is out of a linear step's reach, so it is tried at finite sizes as well.

use joint_core::effect::{EffectParameters, Kind};

use super::Scene;
use super::card::{Axis, Bench, Benchmark, EffectCard, Residual};
use super::hypothesis::{Free, Hypothesis};
use super::rules::Rules;

/// Shares of the stiffness that a spring gains at the typical wind-up where its trials start.
const SHARES: [f64; 4] = [0.0, 0.3, 1.0, 3.0];

pub(super) const CARD: EffectCard = EffectCard {
    words: "a stage that grows stiffer the further it winds up",
    residual: Residual::Windup,
    axis: Axis::OutputWindup,
    experiment: "lock the output and ramp the motor torque slowly through zero to its limit in both \
         directions: a stiffness above zero at zero torque means no gap, one that grows with \
         torque means hardening",
    reference: None,
    rules: Rules::NONE,
    benchmark: Benchmark::Hidden(hidden),
    propose,
};

fn propose(scene: &Scene<'_>) -> Vec<Hypothesis> {
    let free = scene.masses().skip(1).filter(|(_, p)| !scene.has(Kind::HardeningStiffness, *p));
    free.flat_map(|(mass, place)| {
        let windup = scene.typical_windup(mass - 1).max(1e-12);
        let doubled = scene.model.stages[mass - 1].stiffness_nm_per_rad / (windup * windup);
        SHARES.map(|share| Hypothesis {
            start: EffectParameters::new(Kind::HardeningStiffness, place)
                .with("cubic_stiffness_nm_per_rad3", share * doubled),
            free: vec![Free::Value { value: 0, scale: 0.05 * doubled, sigma: 200.0 }],
        })
    })
    .collect()
}

fn hidden(joint: &mut Bench<'_>) -> Option<EffectParameters> {
    let cubic = 0.5 * joint.size * joint.stiffness_nm_per_rad / (2.0 * joint.windup_rad()).powi(2);
    Some(
        EffectParameters::new(Kind::HardeningStiffness, joint.gear()?)
            .with("cubic_stiffness_nm_per_rad3", cubic),
    )
}

#[cfg(test)]
mod tests {
    use joint_core::params::Location;

    use super::*;
    use crate::demo::actuator;
    use crate::discover::proposals::score_test::ScoreTest;
    use crate::discover::trial;
    use crate::estimate::fit::Problem;
    use crate::estimate::record::Record;

    /// What a hypothesis of the last stage explains at best from nothing, and from a finite size, where its
    /// spring holds a cubic part that is `times` its stiffness at a hundredth of a radian.
    fn explained(times: f64) -> [f64; 2] {
        let nominal = actuator();
        let last = nominal.stages.len();
        let place = Location::Stage(last as u8);
        let cubic = times * nominal.stages[last - 1].stiffness_nm_per_rad / 1e-4;
        let hidden = EffectParameters::new(Kind::HardeningStiffness, place)
            .with("cubic_stiffness_nm_per_rad3", cubic);
        let record = Record::new(&trial::log(&nominal, hidden, 8.0), None);
        let mask = vec![1.0; record.measured.len()];
        let problem = Problem::new(&record, &mask).rough();
        let base = trial::fitted(&problem, &nominal, &[]);
        let test = ScoreTest::new(problem, &base.origin, &base.fit, 1).unwrap();
        let proposed = propose(&test.scene());
        let gains = test.gains(&proposed);
        [true, false].map(|nothing| {
            let own = proposed
                .iter()
                .zip(&gains)
                .filter(|(h, _)| h.start.location == place && h.starts_at_nothing() == nothing);
            own.map(|(_, gain)| gain.real).fold(0.0, f64::max)
        })
    }

    #[test]
    fn a_spring_that_bends_much_is_spotted_at_a_finite_size() {
        let [nothing, finite] = explained(100.0);
        assert!(finite > 1.2 * nothing, "{finite} {nothing}");
        let [nothing, finite] = explained(0.01);
        assert!(finite <= nothing, "{finite} {nothing}");
    }
}
