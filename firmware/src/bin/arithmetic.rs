//! `arithmetic`: what single operations cost and how far they are off, the joint's beside those of the
//! crates `fixed`, `micromath` and `libm`, as KEY=value lines.
//!
//! It runs on QEMU's netduinoplus2 with `-icount shift=0,sleep=off` alone. Each operation is a function
//! that is called; `call` lines are what that alone costs. Instructions are the most over the inputs,
//! errors the largest, in units of 10⁻⁹; of products in steps of 2⁻²⁶.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod on_board {
    use core::f64::consts::TAU;
    use core::hint::black_box;

    use firmware::board::{self, InstructionCounter};
    use fixed::types::{I6F26, I16F16};
    use joint_core::fixed::{Fixed, Gain};
    use joint_core::number::{Elementary, Number};
    use micromath::F32Ext;
    use semihosting::println;

    type Function = fn(f32) -> f32;
    type Operation = fn(Fixed, Fixed) -> Fixed;
    type Scaling = fn(Fixed, Gain, I16F16) -> Fixed;
    /// A row of the table: name, what is counted, what it should give, and over which range.
    type FloatRow = (&'static str, Function, fn(f64) -> f64, [f32; 2]);
    /// The same of two words.
    type FixedRow = (&'static str, Operation, fn(f64, f64) -> f64);

    /// Functions as they are called, none inlined into its measurement.
    macro_rules! functions {
        ($($name:ident($($x:ident: $type:ty),+) -> $to:ty $body:block)+) => {
            $(#[inline(never)] fn $name($($x: $type),+) -> $to $body)+
        };
    }

    functions! {
        same(x: f32) -> f32 { x }
        exp_joint(x: f32) -> f32 { x.exp_minus() }
        exp_libm(x: f32) -> f32 { libm::expf(-x) }
        exp_micromath(x: f32) -> f32 { F32Ext::exp(-x) }
        sin_joint(x: f32) -> f32 { x.sin_turns() }
        sin_libm(x: f32) -> f32 { libm::sinf(x * core::f32::consts::TAU) }
        sin_micromath(x: f32) -> f32 { F32Ext::sin(x * core::f32::consts::TAU) }
        tanh_joint(x: f32) -> f32 { Elementary::tanh(x) }
        tanh_libm(x: f32) -> f32 { libm::tanhf(x) }
        tanh_micromath(x: f32) -> f32 {
            let decayed = F32Ext::exp(-2.0 * x);
            (1.0 - decayed) / (1.0 + decayed)
        }
        sqrt_unit(x: f32) -> f32 { libm::sqrtf(x) }
        sqrt_micromath(x: f32) -> f32 { F32Ext::sqrt(x) }
        inverse_sqrt_unit(x: f32) -> f32 { 1.0 / libm::sqrtf(x) }
        inverse_sqrt_micromath(x: f32) -> f32 { F32Ext::invsqrt(x) }
        inverse_unit(x: f32) -> f32 { 1.0 / x }
        inverse_micromath(x: f32) -> f32 { F32Ext::inv(x) }

        first(a: Fixed, _b: Fixed) -> Fixed { a }
        add_joint(a: Fixed, b: Fixed) -> Fixed { a + b }
        add_crate(a: Fixed, b: Fixed) -> Fixed { I6F26::from(a).saturating_add(b.into()).into() }
        neg_joint(a: Fixed, _b: Fixed) -> Fixed { -a }
        neg_crate(a: Fixed, _b: Fixed) -> Fixed { I6F26::from(a).saturating_neg().into() }
        abs_joint(a: Fixed, _b: Fixed) -> Fixed { a.abs() }
        abs_crate(a: Fixed, _b: Fixed) -> Fixed { I6F26::from(a).saturating_abs().into() }
        mul_joint(a: Fixed, b: Fixed) -> Fixed { a * b }
        mul_nearest_joint(a: Fixed, b: Fixed) -> Fixed { a.nearest(b) }
        mul_crate(a: Fixed, b: Fixed) -> Fixed { I6F26::from(a).saturating_mul(b.into()).into() }
        mul_wrapping_crate(a: Fixed, b: Fixed) -> Fixed {
            I6F26::from(a).wrapping_mul(b.into()).into()
        }
        div_joint(a: Fixed, b: Fixed) -> Fixed { a.over(b) }
        div_crate(a: Fixed, b: Fixed) -> Fixed { I6F26::from(a).saturating_div(b.into()).into() }

        scale_none(x: Fixed, _gain: Gain, _factor: I16F16) -> Fixed { x }
        scale_joint(x: Fixed, gain: Gain, _factor: I16F16) -> Fixed { x.times(gain) }
        scale_crate(x: Fixed, _gain: Gain, factor: I16F16) -> Fixed {
            I6F26::saturating_from_num(I6F26::from(x).wide_mul(factor)).into()
        }
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let counter = InstructionCounter::start();
        let exp = |x: f64| libm::exp(-x);
        let sin = |x: f64| libm::sin(TAU * x);
        let inverse_sqrt = |x: f64| 1.0 / libm::sqrt(x);
        let floats: [FloatRow; 16] = [
            ("call", same, |x| x, [0.0, 1.0]),
            ("exp_joint", exp_joint, exp, [0.0, 12.0]),
            ("exp_libm", exp_libm, exp, [0.0, 12.0]),
            ("exp_micromath", exp_micromath, exp, [0.0, 12.0]),
            ("sin_joint", sin_joint, sin, [-0.5, 0.5]),
            ("sin_libm", sin_libm, sin, [-0.5, 0.5]),
            ("sin_micromath", sin_micromath, sin, [-0.5, 0.5]),
            ("tanh_joint", tanh_joint, libm::tanh, [-4.0, 4.0]),
            ("tanh_libm", tanh_libm, libm::tanh, [-4.0, 4.0]),
            ("tanh_micromath", tanh_micromath, libm::tanh, [-4.0, 4.0]),
            ("sqrt_unit", sqrt_unit, libm::sqrt, [1.0, 4.0]),
            ("sqrt_micromath", sqrt_micromath, libm::sqrt, [1.0, 4.0]),
            ("inverse_sqrt_unit", inverse_sqrt_unit, inverse_sqrt, [1.0, 4.0]),
            ("inverse_sqrt_micromath", inverse_sqrt_micromath, inverse_sqrt, [1.0, 4.0]),
            ("inverse_unit", inverse_unit, |x| 1.0 / x, [1.0, 2.0]),
            ("inverse_micromath", inverse_micromath, |x| 1.0 / x, [1.0, 2.0]),
        ];
        for (name, way, exact, range) in floats {
            of_float(&counter, name, way, exact, range);
        }
        let sum = |a: f64, b: f64| a + b;
        let product = |a: f64, b: f64| a * b;
        let operations: [FixedRow; 13] = [
            ("fixed_call", first, |a, _| a),
            ("add_joint", add_joint, sum),
            ("add_crate", add_crate, sum),
            ("neg_joint", neg_joint, |a, _| -a),
            ("neg_crate", neg_crate, |a, _| -a),
            ("abs_joint", abs_joint, |a, _| libm::fabs(a)),
            ("abs_crate", abs_crate, |a, _| libm::fabs(a)),
            ("mul_joint", mul_joint, product),
            ("mul_nearest_joint", mul_nearest_joint, product),
            ("mul_crate", mul_crate, product),
            ("mul_wrapping_crate", mul_wrapping_crate, product),
            ("div_joint", div_joint, |a, b| a / b),
            ("div_crate", div_crate, |a, b| a / b),
        ];
        for (name, way, exact) in operations {
            of_fixed(&counter, name, way, exact);
        }
        for (name, way) in [
            ("scale_call", scale_none as Scaling),
            ("scale_joint", scale_joint),
            ("scale_crate", scale_crate),
        ] {
            of_gain(&counter, name, way);
        }
        board::finish(Ok(()))
    }

    fn of_float(
        counter: &InstructionCounter,
        name: &str,
        way: Function,
        exact: fn(f64) -> f64,
        [low, high]: [f32; 2],
    ) {
        let (mut most, mut error) = (0, 0.0_f64);
        for k in 0..=2000_u16 {
            let x = black_box(low + (high - low) * f32::from(k) / 2000.0);
            let mut found = 0.0;
            let ((), spent) = counter.measure(|| found = black_box(way)(x));
            most = most.max(spent);
            error = error.max(libm::fabs(f64::from(found) - exact(f64::from(x))));
        }
        println!("{name}_instructions={most}");
        println!("{name}_error_ppb={}", (error * 1e9) as u64);
    }

    fn of_fixed(
        counter: &InstructionCounter,
        name: &str,
        way: Operation,
        exact: fn(f64, f64) -> f64,
    ) {
        let (mut most, mut error) = (0, 0.0_f64);
        for k in 0..=2000_u16 {
            let a = black_box(Fixed::from_f64(-4.0 + 0.004 * f64::from(k)));
            let b = black_box(Fixed::from_f64(1.0 + 0.0031 * f64::from(k)));
            let mut found = Fixed::ZERO;
            let ((), spent) = counter.measure(|| found = black_box(way)(a, b));
            most = most.max(spent);
            error = error.max(libm::fabs(found.to_f64() - exact(a.to_f64(), b.to_f64())));
        }
        println!("{name}_instructions={most}");
        println!("{name}_error_thousandths={}", (error * 67_108_864e3) as u64);
    }

    /// Products with a constant of 0.0123, which one of 16 binary places holds to 4e-4 of itself.
    fn of_gain(counter: &InstructionCounter, name: &str, way: Scaling) {
        const VALUE: f64 = 0.0123;
        let (gain, factor) = black_box((Fixed::gain(VALUE), I16F16::from_num(VALUE)));
        let (mut most, mut error) = (0, 0.0_f64);
        for k in 0..=2000_u16 {
            let x = black_box(Fixed::from_f64(-4.0 + 0.004 * f64::from(k)));
            let mut found = Fixed::ZERO;
            let ((), spent) = counter.measure(|| found = black_box(way)(x, gain, factor));
            most = most.max(spent);
            error = error.max(libm::fabs(found.to_f64() - x.to_f64() * VALUE));
        }
        println!("{name}_instructions={most}");
        println!("{name}_error_thousandths={}", (error * 67_108_864e3) as u64);
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("arithmetic runs on a board: build it for thumbv7em-none-eabihf");
}
