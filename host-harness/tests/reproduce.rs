//! The paper's numbers, taken from every scenario with both motors.

use std::collections::HashSet;

use host_harness::reproduce;
use host_harness::scenario;

#[test]
fn every_stated_number_has_its_row_and_few_are_tuned() {
    let runs = reproduce::run(&scenario::paper(), || ()).unwrap();
    let numbers = runs.numbers();
    let ids: HashSet<&str> = numbers.iter().map(|row| row.id.as_str()).collect();
    assert_eq!(ids.len(), numbers.len(), "two rows have one name");
    assert!(numbers.iter().all(|row| row.ours.is_finite() && !row.note.is_empty()));
    assert!(numbers.iter().filter(|row| row.tuned).count() <= 3);
    for row in &numbers {
        assert_eq!(!row.agrees, row.note.starts_with("disagrees"), "{row:?}");
    }
    let agree = |id: &str| numbers.iter().find(|row| row.id == id).unwrap().agrees;
    for id in [
        "explicit-step",
        "fig6-overshoot",
        "fig8-speed",
        "fig10-phase",
        "friction-loss",
        "equivalent",
    ] {
        assert!(agree(id), "{id}");
    }
    // What the notes of the rows that disagree say.
    let why = &runs.why;
    assert!(why.light_angle > why.frictionless_angle && why.frictionless_angle > 0.01, "{why:?}");
    assert!(why.stiffer[0] < 1.5 && (why.stiffer[1] - 6000.0).abs() < 600.0, "{why:?}");
    assert!(why.gentle[0] < 1.5 && why.gentle[1] < 0.5 * why.stiffer[1], "{why:?}");
    assert!(why.loss_at_catalogue > 1.5 * 0.15, "{why:?}");
    // Section 5.1: the paper's limit, and a step five hundred times longer that holds it.
    let claim = &runs.claim;
    assert_eq!(claim.longest_explicit_us(), 0.1);
    assert!(claim.embedded.iter().all(|point| point.error < reproduce::claim::TOLERANCE));
    // The six-step motor follows the prescribed speed, so the gear moves alike.
    for file in ["figure06", "figure08", "figure09"] {
        let [one, other] = [false, true].map(|six_step| &runs.of(file, six_step).angle[2]);
        let apart = one.iter().zip(other).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
        let travel = one.iter().fold(0.0, |most: f64, a| most.max(a.abs()));
        assert!(apart < 0.02 * travel, "{file}: {apart} of {travel}");
    }
    let figures = reproduce::figures(&runs);
    assert_eq!(figures.len(), 14);
    let page = reproduce::page(&numbers, &figures);
    assert!(!page.contains("NaN") && !page.contains("href=") && !page.contains("src="));
}
