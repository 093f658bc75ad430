//! Single operations of the joint beside those of the crates `fixed`, `micromath` and `libm`: where ours
//! is used, it is the better choice on a chip.

use std::path::Path;

use joint_tests::qemu::{self, Board, Run};

#[test]
fn each_operation_is_cheaper_than_a_crate_s_or_the_only_one_that_is_near_enough() {
    if !qemu::available(
        "each_operation_is_cheaper_than_a_crate_s_or_the_only_one_that_is_near_enough",
    ) {
        return;
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let run = qemu::run("arithmetic", Board::NetduinoPlus2, folder, &[]);
    assert_eq!(run.code, Some(0), "{run:?}");
    functions(&run);
    operations(&run);
}

fn number(run: &Run, name: &str, what: &str) -> f64 {
    run.value(&format!("{name}_{what}")).parse().unwrap()
}

/// Instructions without the call.
fn cost(run: &Run, name: &str, call: &str) -> f64 {
    number(run, name, "instructions") - number(run, call, "instructions")
}

fn functions(run: &Run) {
    println!("{:<24} {:>12} {:>10}", "f32", "instructions", "error");
    let (cost, error) =
        (|name: &str| cost(run, name, "call"), |name: &str| 1e-9 * number(run, name, "error_ppb"));
    let ways = ["joint", "libm", "micromath"].as_slice();
    let unit = ["unit", "micromath"].as_slice();
    let rows =
        [("exp", ways), ("sin", ways), ("tanh", ways), ("sqrt", unit), ("inverse_sqrt", unit)];
    for (function, ways) in rows.into_iter().chain([("inverse", unit)]) {
        for way in ways {
            let name = format!("{function}_{way}");
            println!("{name:<24} {:>12} {:>10.1e}", cost(&name), error(&name));
        }
    }
    for function in ["exp", "sin", "tanh"] {
        let [own, libm, micromath] = ways else { unreachable!() };
        let name = |way: &str| format!("{function}_{way}");
        assert!(cost(&name(own)) < cost(&name(libm)), "{function}");
        assert!(cost(&name(own)) < cost(&name(micromath)), "{function}");
        assert!(error(&name(own)) < 1e-2 * error(&name(micromath)), "{function}");
    }
    // Its roots and its inverse are off by more than the 1 % that a step is held to.
    for function in ["sqrt", "inverse_sqrt", "inverse"] {
        assert!(error(&format!("{function}_micromath")) > 1e-2, "{function}");
    }
}

fn operations(run: &Run) {
    println!("{:<24} {:>12} {:>10}", "fixed point", "instructions", "2^-26");
    let error = |name: &str| 1e-3 * number(run, name, "error_thousandths");
    let calls = [("fixed_call", ["add", "neg", "abs", "mul", "div"].as_slice())];
    let mut costs = Vec::new();
    for (call, names) in calls.into_iter().chain([("scale_call", ["scale"].as_slice())]) {
        for name in names {
            let [own, other] = ["joint", "crate"].map(|way| format!("{name}_{way}"));
            for name in [&own, &other] {
                println!("{name:<24} {:>12} {:>10.1}", cost(run, name, call), error(name));
            }
            costs.push([cost(run, &own, call), cost(run, &other, call)]);
        }
    }
    for name in ["mul_nearest_joint", "mul_wrapping_crate"] {
        println!("{name:<24} {:>12} {:>10.1}", cost(run, name, "fixed_call"), error(name));
    }
    // Sums are the crate's own; the rest it has only for more.
    assert!(costs[0][0] <= costs[0][1] && costs[1..].iter().all(|[own, other]| own < other));
}
