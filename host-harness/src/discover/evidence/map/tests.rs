//! Maps of made disturbances, and the least-squares problem of one.

use super::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const SAMPLES: usize = 8000;

/// A joint that goes to and fro over some turns, and coloured noise of RMS one.
fn motion(seed: u64, travel: f64) -> [Vec<f64>; 3] {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let phase = |k: usize| k as f64 * 0.011 + 0.5 * (k as f64 * 0.0013).sin();
    let size = |k: usize| travel * (0.6 + 0.4 * (k as f64 * 0.00037).sin());
    let angle: Vec<f64> = (0..SAMPLES).map(|k| 0.5 * size(k) * phase(k).sin()).collect();
    let speed: Vec<f64> = (0..SAMPLES)
        .map(|k| 1e3 * (angle[(k + 1).min(SAMPLES - 1)] - angle[k.saturating_sub(1)]) / 2.0)
        .collect();
    let mut state = 0.0;
    let noise = (0..SAMPLES).map(|_| {
        state = 0.8 * state + 0.6 * 3.0_f64.sqrt() * random.random_range(-1.0..1.0);
        state
    });
    [angle, speed, noise.collect()]
}

fn fit(angle: &[f64], speed: &[f64], torque: &[f64]) -> Option<EffectParameters> {
    let of = Unexplained { torque_nm: torque, angle_rad: angle, speed_rad_per_s: speed };
    let map = *fitted_maps(&of, Location::Motor).first()?;
    assert_eq!(map.validate(1), Ok(()), "{map:?}");
    Some(map)
}

/// A curve of knots at a part of its length.
fn line(knots: &[f64], part: f64) -> f64 {
    let place = part * (knots.len() - 1) as f64;
    let at = (place as usize).min(knots.len() - 2);
    knots[at] + (knots[at + 1] - knots[at]) * (place - at as f64)
}

#[test]
fn noise_that_follows_nothing_hardly_ever_has_a_map() {
    let found = (0..40).filter(|seed| {
        let [angle, speed, noise] = motion(*seed, 4.0);
        fit(&angle, &speed, &noise).is_some()
    });
    // One in twenty is what the test allows; six of forty has a probability of 1 %.
    let count = found.count();
    assert!(count < 7, "{count} of 40");
}

#[test]
fn a_course_over_the_travel_is_found_to_a_tenth() {
    let [angle, speed, noise] = motion(3, 4.0);
    let law = |q: f64| 2.0 * (2.5 * q).sin() + 0.5 * q;
    let torque: Vec<f64> = angle.iter().zip(&noise).map(|(q, e)| law(*q) + e).collect();
    let map = fit(&angle, &speed, &torque).unwrap();
    let (start, span) = (map.get("start_rad").unwrap(), map.get("span_rad").unwrap());
    assert!(map.table.backward().is_empty() && span > 3.0, "{map:?}");
    let squares = |of: &dyn Fn(f64) -> f64| angle.iter().map(|q| of(*q).powi(2)).sum::<f64>();
    let told = |q: f64| line(map.table.forward(), (q - start) / span);
    let error = squares(&|q| told(q) - law(q)) / squares(&law);
    // Noise of RMS one has some 900 independent samples for at most 64 knots: 7 % of its square, of
    // a law with twice that square.
    assert!(error < 0.035, "{error}");
}

#[test]
fn what_comes_again_with_each_turn_is_found_as_such() {
    let [angle, speed, noise] = motion(4, 40.0);
    let law = |q: f64| 1.5 * (3.0 * q).cos();
    let torque: Vec<f64> = angle.iter().zip(&noise).map(|(q, e)| law(*q) + 0.3 * e).collect();
    let map = fit(&angle, &speed, &torque).unwrap();
    assert_eq!(map.get("period_rad"), Some(TAU), "{map:?}");
    let knots = map.table.forward();
    for (k, knot) in knots.iter().enumerate() {
        let wanted = law(TAU * k as f64 / knots.len() as f64);
        assert!((knot - wanted).abs() < 0.3, "{k}: {knot}, {wanted}");
    }
}

#[test]
fn directions_that_differ_have_a_curve_each() {
    let [angle, speed, noise] = motion(5, 4.0);
    let law = |q: f64, v: f64| if v > 0.0 { (2.0 * q).sin() } else { -q };
    let rows = angle.iter().zip(&speed).zip(&noise);
    let torque: Vec<f64> = rows.map(|((q, v), e)| law(*q, *v) + 0.3 * e).collect();
    let map = fit(&angle, &speed, &torque).unwrap();
    assert!(map.get("span_rad").unwrap() > 0.0, "{map:?}");
    assert_eq!(map.table.backward().len(), map.table.forward().len(), "{map:?}");
}

#[test]
fn what_follows_the_speed_alone_is_odd() {
    let [angle, speed, noise] = motion(6, 4.0);
    let most = speed.iter().fold(0.0_f64, |most, v| v.abs().max(most));
    let law = |v: f64| -2.0 * (v / most).tanh() - 3.0 * (v / most).powi(3);
    let torque: Vec<f64> = speed.iter().zip(&noise).map(|(v, e)| law(*v) + 0.3 * e).collect();
    let map = fit(&angle, &speed, &torque).unwrap();
    assert!(map.get("speed_rad_per_s").unwrap() > 0.0, "{map:?}");
    let told = line(map.table.forward(), 0.5);
    assert!((told - law(0.5 * most)).abs() < 0.2, "{told}");
}

#[test]
fn a_joint_that_rests_has_no_map() {
    let rest = [0.0; 500];
    assert!(fit(&rest, &rest, &[1.0; 500]).is_none());
    assert!(fit(&[f64::NAN; 500], &rest, &[1.0; 500]).is_none());
    assert!(fit(&[], &[], &[]).is_none());
}

/// Rows of a motion over that travel.
fn rows(samples: usize, travel: f64) -> Rows {
    let part = |k: usize| k as f64 / (samples - 1) as f64;
    let angle: Vec<f64> = (0..samples).map(|k| travel * part(k)).collect();
    let speed: Vec<f64> = (0..samples).map(|k| if k % 2 == 0 { 3.0 } else { -4.0 }).collect();
    let torque = vec![1.0; samples];
    Rows::of(&Unexplained { torque_nm: &torque, angle_rad: &angle, speed_rad_per_s: &speed })
        .unwrap()
}

#[test]
fn directions_blend_within_a_tenth_of_the_rms_speed_and_one_that_stands_still_has_no_map() {
    let rows = rows(100, 2.0);
    assert!((rows.blend - 0.1 * 12.5_f64.sqrt()).abs() < 1e-12);
    assert_eq!((rows.start, rows.span, rows.largest_speed), (0.0, 2.0, 4.0));
    let of = |angle: &[f64], speed: &[f64]| {
        Rows::of(&Unexplained { torque_nm: &[1.0; 2], angle_rad: angle, speed_rad_per_s: speed })
    };
    assert!(of(&[0.0, 1.0], &[0.0; 2]).is_none() && of(&[1.0; 2], &[1.0; 2]).is_none());
}

#[test]
fn a_knot_has_sixteen_samples_and_a_turn_comes_again_from_one_and_a_half_on() {
    let told = |samples, turns: f64| -> Vec<(Over, bool, usize)> {
        let shapes = rows(samples, turns * TAU).shapes().into_iter();
        shapes.map(|shape| (shape.over, shape.by_direction, shape.knots)).collect()
    };
    let of = |over, [plain, both]: [&[usize]; 2]| -> Vec<(Over, bool, usize)> {
        let plain = plain.iter().map(|knots| (over, false, *knots));
        plain.chain(both.iter().map(|knots| (over, true, *knots))).collect()
    };
    let all: [&[usize]; 2] = [&[8, 16, 32, 64], &[8, 16, 32]];
    assert_eq!(told(1024, 1.4), [of(Over::Span, all), of(Over::Speed, all)].concat());
    let three = [of(Over::Span, all), of(Over::Turn, all), of(Over::Speed, all)].concat();
    assert_eq!(told(8000, 1.6), three);
    let few: [&[usize]; 2] = [&[8, 16], &[8]];
    assert_eq!(told(511, 1.4), [of(Over::Span, few), of(Over::Speed, few)].concat());
    let shape = Shape { over: Over::Span, by_direction: false, knots: 8 };
    assert_eq!([shape, Shape { by_direction: true, ..shape }].map(Shape::numbers), [8, 16]);
}

#[test]
fn a_sample_follows_from_the_two_knots_beside_it_in_its_direction() {
    let mut rows = rows(101, 2.0);
    (rows.speed[30], rows.blend) = (1.0, 2.0);
    let shape = Shape { over: Over::Span, by_direction: true, knots: 6 };
    let told = |shape, sample: usize| rows.design(shape).rows[sample];
    let near = |told: [(usize, f64); 4], wanted: [(usize, f64); 4]| {
        let pairs = told.iter().zip(wanted);
        pairs.into_iter().all(|(a, b)| a.0 == b.0 && (a.1 - b.1).abs() < 1e-12)
    };
    // Half of the five intervals before knot 2, three quarters of the blend forward.
    assert!(near(told(shape, 30), [(1, 0.375), (2, 0.375), (7, 0.125), (8, 0.125)]));
    assert!(near(told(shape, 31), [(1, 0.0), (2, 0.0), (7, 0.45), (8, 0.55)]));
    let plain = Shape { by_direction: false, ..shape };
    assert!(near(told(plain, 30), [(1, 0.5), (2, 0.5), (1, 0.0), (2, 0.0)]));
    // Of a speed of 1 out of 4, which blends by a half; of 0.6 of a turn's six intervals the last goes to the first.
    let speed = Shape { over: Over::Speed, ..plain };
    assert!(near(told(speed, 30), [(1, 0.375), (2, 0.125), (1, 0.0), (2, 0.0)]));
    rows.angle[30] = -TAU / 12.0;
    let told = rows.design(Shape { over: Over::Turn, ..plain }).rows[30];
    assert!(near(told, [(5, 0.5), (0, 0.5), (5, 0.0), (0, 0.0)]), "{told:?}");
}

#[test]
fn bends_are_held_down_in_each_curve_and_over_the_end_of_a_turn_alone() {
    let mut rows = rows(1000, 20.0);
    rows.correlation = 2.0;
    let energy = |over, by_direction, knots: &[f64]| {
        let shape = Shape { over, by_direction, knots: 8 };
        let knots = DVector::from_row_slice(knots);
        // But for the ridge.
        let all = knots.dot(&(rows.design(shape).penalty(3.0) * &knots));
        all - 2e-3 * knots.dot(&knots)
    };
    let line: Vec<f64> = (0..8).map(|k| f64::from(k) - 3.0).collect();
    let tent: Vec<f64> = (0..8).map(|k| f64::from(u8::from(k == 3))).collect();
    assert!(energy(Over::Span, false, &line).abs() < 1e-9);
    // A bend of one beside each of one of −2, by three and by two samples.
    assert!((energy(Over::Span, false, &tent) - 36.0).abs() < 1e-9);
    assert!((energy(Over::Turn, false, &tent) - 36.0).abs() < 1e-9);
    // The last bend but one has it at its end, the last in its middle.
    let late: Vec<f64> = (0..8).map(|k| f64::from(u8::from(k == 6))).collect();
    assert!((energy(Over::Span, false, &late) - 30.0).abs() < 1e-9);
    // Over the end of a turn the line bends by eight, there and back.
    assert!((energy(Over::Turn, false, &line) - 6.0 * 128.0).abs() < 1e-9);
    assert!((energy(Over::Span, true, &[line, tent].concat()) - 36.0).abs() < 1e-9);
}

#[test]
fn noise_has_a_law_smoothed_and_left_out_blocks_say_its_share() {
    let [angle, speed, noise] = motion(3, 4.0);
    let law = |q: f64| 1.5 * q.sin();
    let torque: Vec<f64> = angle.iter().zip(&noise).map(|(q, e)| law(*q) + 2.0 * e).collect();
    let of = Unexplained { torque_nm: &torque, angle_rad: &angle, speed_rad_per_s: &speed };
    let rows = Rows::of(&of).unwrap();
    let shape = Shape { over: Over::Span, by_direction: false, knots: 64 };
    let (smoothing, share) = rows.design(shape).best_smoothing();
    let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    let own = squares(&mut angle.iter().map(|q| law(*q))) / squares(&mut torque.iter().copied());
    assert!(smoothing > 1.0 && (share.value - own).abs() < 0.05, "{smoothing} {share:?} {own}");
}

#[test]
fn a_law_of_the_travel_and_one_of_the_speed_have_a_map_each_the_larger_first() {
    let [angle, speed, noise] = motion(5, 4.0);
    let most = speed.iter().fold(0.0_f64, |most, v| v.abs().max(most));
    let rows = angle.iter().zip(&speed).zip(&noise);
    let torque: Vec<f64> =
        rows.map(|((q, v), e)| 2.0 * (3.0 * q).sin() - (v / most).powi(3) + 0.1 * e).collect();
    let of = Unexplained { torque_nm: &torque, angle_rad: &angle, speed_rad_per_s: &speed };
    let maps = fitted_maps(&of, Location::Motor);
    let over =
        |key: &str| maps.iter().map(|map| map.get(key).unwrap_or(0.0) > 0.0).collect::<Vec<_>>();
    assert_eq!([over("span_rad"), over("speed_rad_per_s")], [[true, false], [false, true]]);
}
