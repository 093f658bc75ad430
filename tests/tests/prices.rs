//! What the parts of a step cost: the Stribeck curve by five methods, stages, effects.

use std::path::Path;

use joint_core::effect::Kind;
use joint_tests::qemu::{self, Board};

#[test]
fn the_curve_of_the_step_is_the_cheapest_of_its_accuracy() {
    if !qemu::available("the_curve_of_the_step_is_the_cheapest_of_its_accuracy") {
        return;
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let run = qemu::run("prices", Board::NetduinoPlus2, folder, &[]);
    assert_eq!(run.code, Some(0), "{run:?}");
    let number = |key: &str| run.value(key).parse::<u32>().unwrap();
    let call = number("stribeck_call_instructions");
    println!("{:<22} {:>12} {:>12}", "Stribeck curve", "instructions", "error");
    for name in ["cubic", "rational", "table", "libm", "micromath"] {
        let (key, error) =
            (format!("stribeck_{name}_instructions"), format!("stribeck_{name}_error_ppb"));
        println!(
            "{name:<22} {:>12} {:>12.1e}",
            number(&key) - call,
            f64::from(number(&error)) * 1e-9
        );
    }
    let price = |name: &str| number(&format!("stribeck_{name}_instructions"));
    let error = |name: &str| number(&format!("stribeck_{name}_error_ppb"));
    assert!(error("cubic") < 40_000, "as the step's documentation states");
    for other in ["table", "libm", "micromath"] {
        assert!(price("cubic") < price(other), "{other}");
    }
    println!("{:<22} {:>12}", "stages", "instructions");
    let stages: Vec<u32> = (0..=4).map(|n| number(&format!("stages_{n}"))).collect();
    for (n, spent) in stages.iter().enumerate() {
        println!("{n:<22} {spent:>12}");
    }
    assert!(stages.is_sorted());
    let none = number("effects_none");
    println!("{:<22} {:>12}", "effect on two stages", "added");
    println!("{:<22} {:>12}", "(any, chosen to run)", none - stages[2]);
    for kind in Kind::ALL {
        let (name, sensor) = (kind.spec().kind, kind.is_of_a_sensor());
        let spent = number(&format!("effect_{name}")).checked_sub(none);
        let Some(added) = spent.filter(|added| sensor || *added > 0) else {
            panic!("{name} costs nothing in firmware/src/bin/prices.rs: its law does not run")
        };
        println!("{name:<27} {added:>7}");
    }
    // What host-harness/src/cross_check/pareto.rs draws error over cost with.
    assert!(number("explicit_rates").abs_diff(268) <= 10);
    assert!(stages[2].abs_diff(698) <= 30);
    let [one, two] = ["implicit_1", "implicit_2"].map(number);
    println!("{:<22} {:>12}", "step in f64", number("step_f64"));
    println!("{:<22} {one:>12}", "implicit step");
    println!("{:<22} {:>12}", "its further ones", two - one);
    assert!(number("step_f64").abs_diff(53_434) <= 2000);
    assert!(one.abs_diff(1895) <= 60 && (two - one).abs_diff(1708) <= 60);
}
