use std::collections::BTreeMap;

use joint_core::effect::Kind;

use super::words::capital;
use super::{File, Refit, Source, html, refit, residuals_csv};
use crate::demo::actuator;
use crate::discover::candidates::card;
use crate::discover::evidence::{Budget, FreeRun};
use crate::discover::findings::*;
use crate::discover::goodness_of_fit::Remainder;
use crate::log::Log;
use crate::plot::text::{digits, escape, per_cent, si, si_with_sigma};
use crate::synthetic::{Experiment, record};

fn shape(height: f64) -> Shape {
    Shape {
        explained: 0.8,
        coordinate: "motor_angle_rad".into(),
        centres: vec![0.0, 1.0, 2.0],
        before: vec![0.0, height, 0.5],
        after: vec![0.0, f64::NAN, 0.1],
    }
}

pub(super) fn findings(samples: usize) -> Findings {
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
            unnamed: false,
            knots: BTreeMap::new(),
            parameters: BTreeMap::from([("order".into(), 42.0), ("amplitude_nm".into(), 0.01)]),
            standard_errors: BTreeMap::from([("amplitude_nm".into(), 1e-4)]),
            confidence: 0.97,
            gain: 900.0,
            share: 0.9,
            share_error: 0.02,
            borne_out: Some(0.98),
            borne_out_error: Some(0.03),
            unseen_t: 12.0,
            transfer_t: Some(5.0),
            stays_ahead: 1.0,
            rivals: vec![Rival {
                kind: "gravity".into(),
                location: "output".into(),
                confidence: 0.01,
                gain: 600.0,
            }],
        }],
        possible: Vec::new(),
        unnamed: Vec::new(),
        budget: Some(Budget {
            named: 0.9,
            unnamed: 0.05,
            unnamed_error: 0.01,
            coloured: 0.02,
            white: 0.03,
            equation: "rotor torque".into(),
            unit: "Nm".to_owned(),
            rms_before: 0.01,
            rms_after: 0.003,
            unnamed_follows: "motor_speed_rad_per_s".into(),
            unnamed_of_drive: Some(0.02),
            rms_left: 0.0026,
            left_of_drive: Some(0.04),
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
        refitted: actuator(),
        improved: actuator(),
        held_out: (0..samples).map(|k| (k * 10 / samples) == 3).collect(),
        before: rows(3.0),
        after: rows(1.0),
        disturbance: Disturbance {
            equation: "rotor torque".into(),
            unit: "Nm",
            before: wave(1.0),
            after: wave(0.1),
        },
        shape: shape(1.0),
        courses: ["motor_speed_rad_per_s", "i_a"]
            .map(|name| Shape { coordinate: name.into(), ..shape(0.3) })
            .to_vec(),
        angles: Angles {
            motor_rad: time_s.iter().map(|t| 500.0 * t).collect(),
            windup_rad: wave(1e-3),
        },
        orders: vec![42.0],
        parameters: vec![ParameterRow {
            key: "motor.phase_resistance_ohm".into(),
            nominal: 1.0,
            refitted: 1.1,
            improved: 1.05,
            relative_sigma: 0.01,
            interval: [1.03, 1.07],
            determined: true,
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

pub(super) fn source() -> Source {
    let file = |path: &str| File { path: path.into(), sha256: "00ff".into() };
    Source {
        command: "joint discover --model a.toml --log b.csv --out found".into(),
        model: file("a.toml"),
        logs: vec![file("b.csv")],
        out: "found".into(),
        date: "2026-01-01 00:00 UTC".into(),
        assumed: vec!["motor.phase_resistance_ohm".into()],
    }
}

pub(super) fn log() -> Log {
    record(&actuator(), &Experiment::clean(1.0), 2).unwrap()
}

/// The findings with this answer and nothing named.
pub(super) fn without_a_name(answer: Answer) -> Findings {
    let mut findings = findings(10_000);
    findings.verdict.verdict = answer;
    findings.verdict.possible = std::mem::take(&mut findings.verdict.effects);
    findings
}

#[test]
fn the_page_has_the_verdicts_numbers_escapes_what_it_shows_and_draws_no_nan() {
    let findings = findings(2000);
    let verdict = &findings.verdict;
    let page = html(&findings, &[log()], &source());
    let (effect, budget) = (&verdict.effects[0], verdict.budget.as_ref().unwrap());
    let gap = &verdict.gap;
    let [before, after] = verdict.free_run.signals["motor_angle_rad"];
    for text in [
        "The model lacks cogging in the motor".to_owned(),
        per_cent(effect.confidence),
        per_cent(budget.named),
        format!("{:.1} ± {:.1} %", 100.0 * effect.share, 100.0 * effect.share_error),
        si(budget.rms_before, &budget.unit, 3),
        si(budget.rms_left, &budget.unit, 2),
        // Shares are of squares, so that the RMS of a part is the root of its share.
        si(budget.rms_before * budget.coloured.sqrt(), &budget.unit, 2),
        format!("{} → {}", digits(gap.before, 3), digits(gap.after, 3)),
        si_with_sigma(effect.parameters["amplitude_nm"], Some(1e-4), "Nm"),
        format!("<td class=n>{}<td class=n>{}</tr>", si(before, "rad", 3), si(after, "rad", 3)),
        "gravity at the output".to_owned(),
        "1.030 to 1.070 Ω".to_owned(),
        escape(&capital(card(Kind::Cogging).words)),
        "a reason".to_owned(),
    ] {
        assert!(page.contains(&text), "{text}");
    }
    assert!(page.contains("close: 67 % of the improvement"), "the rival has 600 of 900");
    assert!(page.contains("Scan &lt;slowly&gt; &amp; twice"), "escaped");
    assert!(!page.contains("NaN") && !page.contains("inf "));
    for link in ["src=", "href=", "@import", "url("] {
        assert!(!page.contains(link), "the page loads something from elsewhere: {link}");
    }
}

#[test]
fn the_budgets_bar_is_made_of_the_verdicts_shares() {
    let page = html(&findings(2000), &[log()], &source());
    // 0.90, 0.05, 0.02 and 0.03 add up to one.
    for width in ["90.000%", "5.000%", "2.000%", "3.000%"] {
        assert!(page.contains(&format!("width:{width}")), "{width}");
    }
}

#[test]
fn every_answer_leads_with_what_its_reader_needs_first() {
    let page = |findings: &Findings| html(findings, &[log()], &source());
    let at = |page: &str, text: &str| page.find(text).unwrap_or_else(|| panic!("{text}"));
    let effect = page(&findings(2000));
    assert!(at(&effect, "Measured and simulated") < at(&effect, "Where they disagree"));
    let unknown = page(&without_a_name(Answer::Unknown));
    let headline = "In the rotor torque something is missing that follows the motor speed";
    assert!(at(&unknown, headline) < at(&unknown, "Where they disagree"));
    assert!(at(&unknown, "Where they disagree") < at(&unknown, "Possible, not confirmed</h2>"));
    assert!(at(&unknown, "Possible, not confirmed</h2>") < at(&unknown, "Measured and simulated"));
    assert!(at(&unknown, "against motor speed") < at(&unknown, "The same against everything else"));
    let adequate = page(&without_a_name(Answer::Adequate));
    assert!(adequate.contains("Nothing is missing that this log shows"));
    assert!(adequate.contains(">refitted</span>") && !adequate.contains(">improved</span>"));
    let undecided = page(&without_a_name(Answer::Undecided));
    assert!(at(&undecided, "A reason.") < at(&undecided, "What to measure next"));
    assert!(
        !undecided.contains("Measured and simulated") && undecided.contains("What the log shows")
    );
}

#[test]
fn a_free_run_that_leaves_the_log_says_so_and_windows_are_drawn() {
    let mut findings = findings(2000);
    // Of a third of the torque constant, nearly without friction, a voltage makes three times the speed.
    findings.improved = findings.improved.with_friction(0.05);
    findings.improved.motor.torque_constant_nm_per_a *= 0.3;
    let page = html(&findings, &[log()], &source());
    assert!(page.contains("The free run diverges") && page.contains("windows of 100 ms"));
}

#[test]
fn what_the_model_file_or_the_log_leaves_open_is_marked_as_assumed() {
    let mut findings = findings(2000);
    findings.parameters[0].determined = false;
    let page = html(&findings, &[log()], &source());
    assert!(page.contains("assumed, also in the model file"));
}

#[test]
fn the_commands_are_those_of_this_run_and_the_end_says_where_the_page_comes_from() {
    let page = html(&findings(2000), &[log()], &source());
    assert_eq!(page.matches("class=paste").count(), 3);
    assert!(page.contains("joint transfer --model a.toml found/model.toml --log next.csv"));
    assert!(page.contains("joint discover --model a.toml --log b.csv next.csv --out found.next"));
    let end = page.find("Where this page comes from").unwrap();
    for text in ["00ff", "2026-01-01", env!("CARGO_PKG_VERSION"), &escape(&source().command)] {
        assert!(page[end..].contains(text), "{text}");
    }
}

#[test]
fn the_same_run_gives_the_same_bytes() {
    let (one, other) = (findings(2000), findings(2000));
    assert_eq!(html(&one, &[log()], &source()), html(&other, &[log()], &source()));
    let later = Findings { verdict: Verdict { seconds: 99.0, ..other.verdict.clone() }, ..other };
    assert_eq!(html(&one, &[log()], &source()), html(&later, &[log()], &source()));
}

#[test]
fn a_million_samples_make_a_page_below_one_megabyte() {
    assert!(html(&findings(1_000_000), &[log()], &source()).len() < 1_000_000);
}

#[test]
fn a_refit_tells_how_far_it_misses_in_si_units_and_per_cent() {
    let nominal = actuator();
    let mut refitted = nominal.clone();
    refitted.motor.torque_constant_nm_per_a *= 1.01;
    let parameters = findings(10).parameters;
    let found =
        Refit { nominal: &nominal, refitted: &refitted, parameters: &parameters, timing: None };
    let log = log();
    let page = refit(&found, &log, &source());
    let run = &crate::transfer::courses(&refitted, &log, 1.0).unwrap()[0];
    let share = digits(100.0 * run.free_errors.rms / run.size, 2);
    let told = format!("<b>{} ({share} %)</b>", si(run.free_errors.rms, "rad", 3));
    assert!(page.contains(&told), "{told}");
    assert!(page.contains("The log tells 1 of 1 parameters<"));
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
