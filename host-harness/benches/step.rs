//! `cargo bench -p host-harness`: what a tenth of a second of the joint costs, method by method.
//!
//! One run, one machine, one scenario: the embedded step, Bogacki and Shampine's method at the
//! paper's step, `diffsol`'s implicit method as loose as it may be at the error of the embedded step
//! and at the paper's 1 %, which one micro-step keeps here, and explicit Euler on the bristle, as MuJoCo's `dcmotor` advances its activations. The errors stand
//! above the times, and so does the step at which the explicit bristle leaves stability: σ1/σ0. Then
//! batches of joints with parameters of their own over all cores; divan's items are simulated joints
//! times steps.

use std::sync::OnceLock;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use host_harness::cross_check::{Quantity, REFERENCE_STEP_S, Speed};
use host_harness::model::Model;
use host_harness::plant::{self, Inputs, ScalarKind, Snapshot};
use host_harness::reference::{self, Equations, Held, Method, Options, PAPER_STEP_S};
use host_harness::scenario::{ALL, Scenario, paper};
use joint_core::joint::{Drive, Pace};
use rayon::prelude::*;

const STEP_S: f64 = 50e-6;
/// The paper's error.
const ONE_PER_CENT: f64 = 0.01;
/// Steps of explicit Euler that are tried, s.
const EULER_STEPS_S: [f64; 8] = [0.1e-6, 0.5e-6, 1e-6, 2e-6, 3e-6, 5e-6, 10e-6, 50e-6];

/// With reversals.
fn scenario() -> &'static Scenario {
    &ALL[1]
}

/// The joint, its inputs, the tolerance at which `diffsol` is no worse than the step, and that at which
/// it is within one per cent.
fn setting() -> &'static (Model, Inputs, Speed, f64) {
    static SETTING: OnceLock<(Model, Inputs, Speed, f64)> = OnceLock::new();
    SETTING.get_or_init(|| {
        let model = paper();
        let speed = Speed::measure(&model, scenario()).expect("the built-in joint runs");
        let inputs = scenario().inputs();
        let exact = refer(&model, &inputs, Method::BogackiShampine { step_s: REFERENCE_STEP_S });
        let mut loose = 1.0;
        let stiff = |tolerance| {
            let run =
                reference::simulate(&model, &inputs, &Options::of(Method::Stiff { tolerance }));
            run.map_or(f64::INFINITY, |run| worst(&model, &exact, &run))
        };
        while stiff(loose) > ONE_PER_CENT {
            loose *= 0.5;
        }
        (model, inputs, speed, loose)
    })
}

fn main() {
    let (model, inputs, speed, loose) = setting();
    let exact = refer(model, inputs, Method::BogackiShampine { step_s: REFERENCE_STEP_S });
    println!("worst state, relative RMS, 0.1 s of `{}`:", scenario().name);
    for forced in [Some(1), Some(2), None] {
        let run = embedded(model, inputs, ScalarKind::F32, forced);
        let n = forced.unwrap_or_else(|| {
            Pace::of(&model.motor, &model.stages, &model.load).micro_steps(STEP_S)
        });
        let chosen = if forced.is_none() { ", the rule's" } else { "" };
        println!(
            "  embedded f32, 50 µs, {n} micro-steps{chosen}: {}",
            percent(model, &exact, &run)
        );
    }
    let paper = refer(model, inputs, Method::BogackiShampine { step_s: PAPER_STEP_S });
    println!("  Bogacki-Shampine, 0.1 µs: {}", percent(model, &exact, &paper));
    println!(
        "  diffsol, tolerance {:.0e}: {:.4} %",
        speed.stiff_tolerance,
        100.0 * speed.stiff_error
    );
    let at_one = refer(model, inputs, Method::Stiff { tolerance: *loose });
    println!("  diffsol, tolerance {loose:.1e}: {}", percent(model, &exact, &at_one));
    let [explicit, stiff] = speed.ratios();
    println!(
        "  embedded f64 with the rule's micro-steps is {explicit:.0} times faster than \
         Bogacki-Shampine at 0.1 µs and {stiff:.0} times faster than diffsol"
    );
    for step in EULER_STEPS_S {
        let run = euler(model, inputs, step);
        println!("  explicit Euler, {:.1} µs: {}", 1e6 * step, percent(model, &exact, &run));
    }
    stability();
    divan::main();
}

/// A mass in stick, released from a bent bristle, under explicit Euler: whether it comes to rest.
fn stability() {
    let mut model = paper();
    model.stages.clear();
    let friction = model.motor.friction;
    let bent = 1e-3 * friction.coulomb_nm / friction.sigma0_nm_per_rad;
    let limit = friction.sigma1_nm_s_per_rad / friction.sigma0_nm_per_rad;
    let equations = Equations::new(&model, Drive::Current, 2.0).expect("the built-in joint");
    let layout = equations.layout();
    println!("explicit LuGre in stick, σ1/σ0 = {:.1} µs:", 1e6 * limit);
    for share in [0.25, 0.5, 0.9, 1.1, 2.0] {
        let (h, mut state) = (share * limit, equations.rest());
        let mut rate = equations.rest();
        state[layout.bristle(0)] = bent;
        let mut late = 0.0_f64;
        for k in 0..20_000 {
            euler_step(&equations, &Held::default(), &mut state, &mut rate, h);
            if k >= 19_000 {
                late = late.max(state[layout.bristle(0)].abs());
            }
        }
        let left = late / bent;
        let verdict = if left < 1.0 { "comes to rest" } else { "swings up" };
        println!("  {:.1} µs, {share} σ1/σ0: {verdict}, to {left:.1e} of the start", 1e6 * h);
    }
}

/// Speeds, bristles and current from the forces of the old state, angles with the new speeds.
fn euler_step(equations: &Equations, held: &Held, state: &mut [f64], rate: &mut [f64], h: f64) {
    let layout = equations.layout();
    equations.derivative(held, state, rate);
    for (value, rate) in state.iter_mut().zip(&*rate) {
        *value += h * rate;
    }
    // What the new speeds add to the angles, beyond the old ones.
    let gained = |rate: &[f64], mass| h * h * rate[layout.speed(mass)];
    state[plant::Layout::ANGLE] += gained(rate, 0);
    for stage in 0..layout.stages {
        state[layout.deflection(stage)] += gained(rate, stage) - gained(rate, stage + 1);
    }
}

fn euler(model: &Model, inputs: &Inputs, step_s: f64) -> Vec<Snapshot> {
    let equations = Equations::new(model, inputs.drive, 2.0).expect("the built-in joint");
    let (mut state, mut rate) = (equations.rest(), equations.rest());
    let mut snapshots = Vec::with_capacity(inputs.time_s.len());
    for (k, pair) in inputs.time_s.windows(2).enumerate() {
        snapshots.push(equations.snapshot(&state));
        let held =
            Held { drive: inputs.drive_values[k], load: inputs.load_nm[k], ..Held::default() };
        let steps = ((pair[1] - pair[0]) / step_s - 1e-6).ceil();
        for _ in 0..steps as u64 {
            euler_step(&equations, &held, &mut state, &mut rate, (pair[1] - pair[0]) / steps);
        }
    }
    snapshots
}

fn embedded(
    model: &Model,
    inputs: &Inputs,
    scalar: ScalarKind,
    forced: Option<u32>,
) -> Vec<Snapshot> {
    plant::simulate(model, inputs, scalar, Some(STEP_S), forced).expect("the built-in joint")
}

fn refer(model: &Model, inputs: &Inputs, method: Method) -> Vec<Snapshot> {
    reference::simulate(model, inputs, &Options::of(method)).expect("the built-in joint")
}

fn worst(model: &Model, exact: &[Snapshot], run: &[Snapshot]) -> f64 {
    Quantity::of(model.stages.len())
        .into_iter()
        .map(|quantity| quantity.relative_rms(exact, run))
        .fold(0.0, |a, b| if b.is_nan() { f64::INFINITY } else { f64::max(a, b) })
}

fn percent(model: &Model, exact: &[Snapshot], run: &[Snapshot]) -> String {
    let worst = worst(model, exact, run);
    if worst < 10.0 { format!("{:.3} %", 100.0 * worst) } else { "unstable".to_owned() }
}

#[divan::bench(args = [1, 2])]
fn embedded_f32(bencher: Bencher<'_, '_>, micro_steps: u32) {
    let (model, inputs, ..) = setting();
    bencher.bench(|| embedded(model, black_box(inputs), ScalarKind::F32, Some(micro_steps)));
}

#[divan::bench]
fn embedded_f32_rule(bencher: Bencher<'_, '_>) {
    let (model, inputs, ..) = setting();
    bencher.bench(|| embedded(model, black_box(inputs), ScalarKind::F32, None));
}

#[divan::bench]
fn embedded_f64_rule(bencher: Bencher<'_, '_>) {
    let (model, inputs, ..) = setting();
    bencher.bench(|| embedded(model, black_box(inputs), ScalarKind::F64, None));
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn bogacki_shampine_at_a_tenth_of_a_microsecond(bencher: Bencher<'_, '_>) {
    let (model, inputs, ..) = setting();
    let method = Method::BogackiShampine { step_s: PAPER_STEP_S };
    bencher.bench(|| refer(model, black_box(inputs), method));
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn diffsol_at_the_same_error(bencher: Bencher<'_, '_>) {
    let (model, inputs, speed, _) = setting();
    let method = Method::Stiff { tolerance: speed.stiff_tolerance };
    bencher.bench(|| refer(model, black_box(inputs), method));
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn diffsol_at_one_per_cent(bencher: Bencher<'_, '_>) {
    let (model, inputs, _, loose) = setting();
    let method = Method::Stiff { tolerance: *loose };
    bencher.bench(|| refer(model, black_box(inputs), method));
}

#[divan::bench(sample_count = 10, sample_size = 1)]
fn explicit_euler_at_half_a_microsecond(bencher: Bencher<'_, '_>) {
    let (model, inputs, ..) = setting();
    bencher.bench(|| euler(model, black_box(inputs), 0.5e-6));
}

/// Joints over all cores, each with an inertia of its own.
#[divan::bench(args = [64, 1024], sample_count = 5, sample_size = 1)]
fn batch_f32(bencher: Bencher<'_, '_>, joints: usize) {
    let (model, inputs, ..) = setting();
    let models: Vec<Model> = (0..joints)
        .map(|k| {
            let mut model = model.clone();
            model.motor.rotor_inertia_kg_m2 *= 1.0 + k as f64 / joints as f64;
            model
        })
        .collect();
    let steps = (inputs.time_s[inputs.time_s.len() - 1] / STEP_S).round() as usize;
    bencher.counter(ItemsCount::new(joints * steps)).bench(|| {
        models
            .par_iter()
            .map(|model| embedded(model, inputs, ScalarKind::F32, None).len())
            .sum::<usize>()
    });
}
