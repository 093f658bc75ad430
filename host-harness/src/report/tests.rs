use std::collections::BTreeMap;

use joint_core::effect::Kind;

use super::{html, residuals_csv};
use crate::demo::actuator;
use crate::discover::candidates::card;
use crate::discover::evidence::{Budget, FreeRun};
use crate::discover::findings::*;
use crate::discover::gate::Remainder;
use crate::plot::text::escape;

fn shape(height: f64) -> Shape {
    Shape {
        coordinate: "motor_angle_rad".into(),
        centres: vec![0.0, 1.0, 2.0],
        before: vec![0.0, height, 0.5],
        after: vec![0.0, f64::NAN, 0.1],
    }
}

fn findings(samples: usize) -> Findings {
    let time_s: Vec<f64> = (0..samples).map(|k| k as f64 * 1e-4).collect();
    let wave =
        |scale: f64| -> Vec<f64> { time_s.iter().map(|t| scale * (40.0 * t).sin()).collect() };
    let rows = |scale: f64| -> Vec<[f64; 3]> {
        wave(scale).into_iter().map(|e| [e, 2.0 * e, f64::NAN]).collect()
    };
    let verdict = Verdict {
        verdict: Answer::Effect,
        effects: vec![Named {
            kind: "cogging".into(),
            location: "motor".into(),
            parameters: BTreeMap::from([("order".into(), 42.0), ("amplitude_nm".into(), 0.01)]),
            standard_errors: BTreeMap::from([("amplitude_nm".into(), 1e-4)]),
            confidence: 0.97,
            gain: 900.0,
            share: 0.9,
            share_error: 0.02,
            unseen_t: 12.0,
            stays_ahead: 1.0,
            rivals: vec![Rival {
                kind: "gravity".into(),
                location: "output".into(),
                confidence: 0.01,
                gain: 600.0,
            }],
        }],
        possible: Vec::new(),
        budget: Some(Budget {
            named: 0.9,
            unnamed: 0.05,
            coloured: 0.02,
            white: 0.03,
            equation: "rotor torque".into(),
            unit: "Nm".to_owned(),
            rms_before: 0.01,
            rms_after: 0.003,
            unnamed_follows: "motor_speed_rad_per_s".into(),
            unnamed_of_drive: 0.02,
            rms_left: 0.0026,
            left_of_drive: 0.04,
        }),
        free_run: FreeRun {
            signals: BTreeMap::from([("motor_angle_rad".into(), [0.2, 0.01])]),
            mode: "open loop",
            stretches: 3,
            longest_s: 0.2,
        },
        whereabouts: Whereabouts {
            equation: "rotor torque".into(),
            varies_with: "motor_angle_rad".into(),
            orders: vec![42.0],
            explained: 0.8,
        },
        gap: Gap {
            before: 3.0,
            after: 1.01,
            floor: 1.0,
            unit: "noise sigmas, held-out part",
            signals: BTreeMap::from([("i_a".into(), [1.5, 1.0, 1.0])]),
        },
        next_experiment: "scan <slowly> & twice".into(),
        seconds: 1.0,
        reasons: vec!["a reason".into()],
    };
    Findings {
        verdict,
        left: Remainder::default(),
        nominal: actuator(),
        improved: actuator(),
        held_out: (0..samples).map(|k| (k * 10 / samples) == 3).collect(),
        before: rows(3.0),
        after: rows(1.0),
        push: Push {
            equation: "rotor torque".into(),
            unit: "Nm",
            before: wave(1.0),
            after: wave(0.1),
        },
        shape: shape(1.0),
        along_effects: vec![(
            Kind::QuadraticDrag,
            Shape { coordinate: "motor_speed_rad_per_s".into(), ..shape(0.3) },
        )],
        orders: vec![[42.0, f64::NAN, f64::NAN]],
        parameters: vec![ParameterRow {
            key: "motor.phase_resistance_ohm".into(),
            nominal: 1.0,
            refitted: 1.1,
            improved: 1.05,
            relative_sigma: 0.01,
        }],
        scores: vec![ScoreRow {
            round: 1,
            name: "cogging (motor)".into(),
            score: 900.0,
            refitted: None,
        }],
        noises: vec![NoiseRow {
            name: "rotor torque",
            unit: "Nm",
            expected: 1.0,
            before: 9.0,
            after: 1.0,
        }],
        experiment: None,
        time_s,
    }
}

#[test]
fn the_page_says_what_was_found_escapes_what_it_shows_and_draws_no_nan() {
    let page = html(&findings(2000));
    for text in ["cogging", "motor", "0.97", "rotor torque", "42", "gravity", "a reason"] {
        assert!(page.contains(text), "{text}");
    }
    let own = "Disturbance of the rotor torque against motor_speed_rad_per_s, with which quadratic-drag varies";
    assert!(page.contains(own), "the effect is drawn against what it varies with");
    let words = escape(card(Kind::Cogging).words);
    assert!(page.contains(&words), "the effect found is explained: {words}");
    assert!(page.contains("scan &lt;slowly&gt; &amp; twice"));
    assert!(!page.contains("NaN") && !page.contains("inf "));
    for link in ["src=", "href=", "@import", "url("] {
        assert!(!page.contains(link), "the page loads something from elsewhere: {link}");
    }
}

#[test]
fn a_million_samples_make_a_page_below_one_megabyte() {
    assert!(html(&findings(1_000_000)).len() < 1_000_000);
}

#[test]
fn the_table_has_a_row_a_sample_and_the_measured_channels_only() {
    let csv = residuals_csv(&findings(50));
    let mut lines = csv.lines();
    assert_eq!(
        lines.next(),
        Some(
            "t_s,held_out,i_a_before_sigma,i_a_after_sigma,motor_angle_rad_before_sigma,motor_angle_rad_after_sigma,push_before,push_after"
        )
    );
    assert_eq!(lines.count(), 50);
}
