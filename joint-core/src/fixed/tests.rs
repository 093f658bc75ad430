use super::*;
use crate::angle::Turns;
use crate::friction::{Relaxation, Stribeck};

fn sweep(low: f64, high: f64) -> impl Iterator<Item = f64> {
    (0..=4000).map(move |k| low + (high - low) * f64::from(k) / 4000.0)
}

const LAST: f64 = 1.0 / 67_108_864.0;

#[test]
fn sums_and_products_stop_at_the_limits_instead_of_wrapping() {
    let big = Fixed::from_f64(25.0);
    assert_eq!(big + big, Fixed::MAX);
    assert_eq!(-big - big, Fixed::MIN);
    for (product, limit) in [
        (big * big, Fixed::MAX),
        (big * -big, Fixed::MIN),
        (big.times(Fixed::gain(1e4)), Fixed::MAX),
        ((-big).times(Fixed::gain(1e12)), Fixed::MIN),
    ] {
        assert!(product.is_at_limit() && (product.to_f64() - limit.to_f64()).abs() < 1e-3);
    }
    assert!(Fixed::MAX.is_at_limit() && !big.is_at_limit());
    assert_eq!(-Fixed::MIN, Fixed::MAX);
}

#[test]
fn a_gain_of_any_size_rounds_to_the_nearest() {
    for gain in [1e-9, 3e-7, 1e-4, 0.01, 0.3, 0.5, 0.75, 1.0, 1.7, 20.0, 193.0, 4096.0] {
        for x in sweep(-1.0, 1.0).chain(sweep(-1e-5, 1e-5)) {
            let x = Fixed::from_f64(x);
            let exact = x.to_f64() * gain;
            if exact.abs() < 32.0 {
                let error = x.times(Fixed::gain(gain)).to_f64() - exact;
                // A large constant has steps of 2⁻¹⁶ and its product is rounded down.
                let (last, share) = if gain < 0.25 { (0.51, 1e-9) } else { (1.01, 2e-5) };
                assert!(error.abs() <= last * LAST + share * exact.abs(), "{gain} {x:?}");
            }
        }
    }
    assert_eq!(Fixed::ONE.times(Fixed::gain(0.0)), Fixed::ZERO);
    assert_eq!(Fixed::ONE.times(Fixed::gain(1e-300)), Fixed::ZERO);
    assert_eq!(Fixed::ONE.times(Gain::default()), Fixed::ZERO);
}

#[test]
fn a_quotient_is_right_to_two_of_the_last_place() {
    for by in sweep(0.016, 31.0).chain(sweep(0.9, 2.1)) {
        for x in [-30.0, -1.0, 1e-6, 0.3, 1.0, 20.0] {
            let (x, by) = (Fixed::from_f64(x), Fixed::from_f64(by));
            let exact = x.to_f64() / by.to_f64();
            if exact.abs() < 31.0 {
                let error = x.over(by).to_f64() - exact;
                assert!(error.abs() < 2.0 * LAST + 1e-8 * exact.abs(), "{x:?} {by:?} {error}");
            }
        }
    }
}

#[test]
fn the_functions_keep_their_errors() {
    for x in sweep(0.0, 30.0).chain(sweep(0.0, 1.0)) {
        let x = Fixed::from_f64(x);
        let exact = (-x.to_f64()).exp();
        assert!((x.exp_minus().to_f64() - exact).abs() < 6e-6, "{x:?}");
    }
    for turns in sweep(-0.5, 0.5) {
        let angle = turns * core::f64::consts::TAU;
        assert!((Fixed::from_f64(turns).sin_turns().to_f64() - angle.sin()).abs() < 2e-6);
        assert!((Fixed::from_f64(turns).cos_turns().to_f64() - angle.cos()).abs() < 2e-6);
    }
    for turns in sweep(-1.0, 1.0) {
        let (whole, part) = Fixed::from_f64(turns).split_turns();
        assert!((f64::from(whole) + part.to_f64() - turns).abs() < LAST);
        assert!(part.to_f64().abs() <= 0.5);
    }
    let ratio = Fixed::gain(1.0 / 1024.0);
    let wrapped = Fixed::wrapped_turns(1000, ratio, Fixed::ZERO, ratio);
    assert!((wrapped.to_f64() + 24.0 / 1024.0).abs() < 2.0 * LAST);
}

#[test]
fn a_creep_far_below_the_last_place_of_an_angle_adds_up() {
    let mut angle = crate::angle::Angle::<Fixed>::default();
    let (speed, gain) = (Fixed::from_bits(-3), 0.005_512_3);
    for _ in 0..1_000_000 {
        angle.turn(speed, Fixed::gain(gain));
    }
    let exact = 1e6 * speed.to_f64() * gain;
    assert!((angle.to_turns() / exact - 1.0).abs() < 1e-6, "{}", angle.to_turns());
}

#[test]
fn a_bristle_relaxes_by_the_exponential_of_its_reach() {
    let to = Fixed::from_f64;
    for reach in sweep(-9.9, 9.9) {
        for zeta in [-1.2, -0.3, 0.0, 0.8] {
            let (rho, level) = (0.8_f64, 1.25_f64);
            let target = level.copysign(reach);
            let x = reach.abs() * rho;
            let exact = target + (zeta - target) * (-x).exp();
            let found = to(zeta).relaxed(to(reach), to(rho), to(level)).to_f64();
            // The table's error of the share over the reach, times the reach and the way.
            let bound = 6e-5 * x * (target - zeta).abs() + 3.0 * LAST;
            assert!((found - exact).abs() < bound, "{reach} {zeta}: {found} {exact}");
        }
    }
    // Beyond a reach of 8 nothing is left of the way but that error.
    let far = to(-0.5).relaxed(to(30.0), Fixed::ONE, Fixed::ONE);
    assert!((far.to_f64() - 1.0).abs() < 6e-5 * 8.0 * 1.5, "{far}");
}

#[test]
fn a_stribeck_curve_falls_and_rises_from_standstill() {
    for beta in [-0.96, -0.7, -0.3, 0.0, 0.5, 2.0, 6.9] {
        for square in sweep(0.0, 31.9) {
            let (share, level) = Fixed::from_f64(square).stribeck(Fixed::from_f64(beta));
            let exact = 1.0 + beta * (-0.5 * square).exp();
            // The exponential's error, and the inverse's 2e-5 of itself.
            let error = 5e-4 * beta.abs();
            assert!((level.to_f64() - exact).abs() < error + LAST, "{beta} {square}: {level}");
            let bound = error / (exact * (exact - error)) + 2e-5 / exact;
            assert!((share.to_f64() - 1.0 + 1.0 / exact).abs() < bound, "{beta} {square}: {share}");
        }
    }
}
