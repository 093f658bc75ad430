use std::f64::consts::TAU;

use super::*;
use crate::model::{Model, Sensor};
use crate::plant::{Inputs, Snapshot};
use crate::reference::{Equations, Held, Method, Options, Stepper, simulate};
use joint_core::joint::Drive;
use joint_core::params::{Friction, Load, Motor};

const G0: f64 = 0.02;
const G1: f64 = 0.01;
const V0: f64 = 2.0;
const SIGMA0: f64 = 10.0;

fn families() -> [Family; 5] {
    [
        Family::LuGre,
        Family::ElastoPlastic { breakaway: 0.7 },
        Family::MaxwellSlip { elements: 6, attraction: 1.0 },
        Family::Tanh { width: 0.05 },
        Family::LimitedViscous { limit: 0.2 },
    ]
}

/// A rotor with friction, of inertia `inertia`.
fn rotor(inertia: f64) -> Model {
    Model {
        name: "rotor".to_owned(),
        motor: Motor {
            phase_resistance_ohm: 2.0,
            phase_inductance_h: 1e-3,
            torque_constant_nm_per_a: 0.1,
            rotor_inertia_kg_m2: inertia,
            friction: Friction {
                sigma0_nm_per_rad: SIGMA0,
                sigma1_nm_s_per_rad: 0.02,
                sigma2_nm_s_per_rad: 1e-3,
                coulomb_nm: G0,
                stribeck_nm: G1,
                stribeck_velocity_rad_per_s: V0,
            },
            ..Motor::default()
        },
        stages: Vec::new(),
        load: Load::default(),
        sensor: Sensor::default(),
        effects: Vec::new(),
        friction_levels: Vec::new(),
    }
}

fn run(inertia: f64, family: Family, amperes: impl Fn(f64) -> f64, share: f64) -> Vec<Snapshot> {
    let time_s: Vec<f64> = (0..2000).map(|k| f64::from(k) * 5e-4).collect();
    let drive_values = time_s.iter().map(|t| amperes(*t)).collect();
    let inputs = Inputs { time_s, drive: Drive::Current, drive_values, load_nm: Vec::new() };
    let options = Options { friction: family, ..Options::of(Method::Scaled { share }) };
    simulate(&rotor(inertia), &inputs, &options).unwrap()
}

/// Friction torque at a state, Nm: what slows a mass of this inertia.
fn torque(equations: &Equations, state: &[f64], inertia: f64) -> f64 {
    let mut rate = vec![0.0; state.len()];
    equations.derivative(&Held::default(), state, &mut rate);
    -rate[equations.layout().speed(0)] * inertia
}

/// Friction against a prescribed motion: speed over time, sampled after each step.
fn prescribed(family: Family, speed: impl Fn(f64) -> f64, until: f64, step: f64) -> Vec<[f64; 3]> {
    // So heavy that friction changes its speed by less than 1e-9 rad/s over the run.
    let inertia = 1e9;
    let equations =
        Equations::new(&rotor(inertia), Drive::Current, 2.0).unwrap().with_friction(family);
    let mut stepper = Stepper::new(&equations, Method::BogackiShampine { step_s: step });
    let mut state = equations.rest();
    let layout = equations.layout();
    let mut told = Vec::new();
    for k in 0..(until / step) as u32 {
        let time = f64::from(k) * step;
        state[layout.speed(0)] = speed(time + 0.5 * step);
        stepper.advance(&mut state, &Held::default(), step);
        told.push([time, state[layout.speed(0)], torque(&equations, &state, inertia)]);
    }
    told
}

#[test]
fn even_sliding_is_on_the_stribeck_curve_with_the_viscous_part() {
    for family in families() {
        for speed in [0.5, 2.0, 20.0, -6.0_f64] {
            let g = G0 + G1 * (-(speed / V0).powi(2)).exp();
            let viscous: f64 = match family {
                Family::LimitedViscous { limit } => {
                    limit * G0 * (1e-3 * speed / (limit * G0)).tanh()
                }
                _ => 1e-3 * speed,
            };
            let sign = match family {
                Family::Tanh { width } => (speed / (width * V0)).tanh(),
                _ => speed.signum(),
            };
            let exact = g * sign + viscous;
            // Some hundred times the way to sliding, 3 mrad at 0.5 rad/s.
            let told = prescribed(family, |_| speed, 1.0, 1e-5);
            let [.., found] = told[told.len() - 1];
            assert!((found / exact - 1.0).abs() < 1e-6, "{family:?} {speed}: {found} {exact}");
        }
    }
}

#[test]
fn from_rest_a_law_with_bristles_is_as_stiff_as_sigma_0() {
    // 1 µrad, a thousandth of the way to sliding: LuGre has lost that share by then, and the first of
    // six Maxwell elements still sticks. Damping acts as well.
    for family in families() {
        let told = prescribed(family, |_| 1e-3, 1e-3, 1e-6);
        let [.., found] = told[told.len() - 1];
        let spring = SIGMA0 * 1e-6 + 0.02 * 1e-3 + 1e-3 * 1e-3;
        match family {
            // tanh(v/w v0) = v/(w v0) to 1e-4 at a hundredth of it.
            Family::Tanh { width } => {
                let exact = (G0 + G1) * 1e-3 / (width * V0) + 1e-6;
                assert!((found / exact - 1.0).abs() < 1e-3, "{found} {exact}");
            }
            _ => assert!((found / spring - 1.0).abs() < 1e-3, "{family:?}: {found} {spring}"),
        }
    }
}

#[test]
fn friction_takes_work_over_every_closed_cycle() {
    for family in families() {
        // Cycles within presliding (0.5 mrad), across breakaway, and fast ones.
        for (amplitude, hertz) in [(5e-4, 2.0), (5e-3, 2.0), (0.2, 5.0)] {
            let omega = TAU * hertz;
            let step = 1e-5;
            let speed = |t: f64| amplitude * omega * (omega * t).cos();
            let told = prescribed(family, speed, 3.0 / hertz, step);
            // The first cycle begins with relaxed bristles; the last one closes.
            let last = &told[told.len() * 2 / 3..];
            let work: f64 = last.iter().map(|[_, v, torque]| v * torque * step).sum();
            assert!(work > 0.0, "{family:?} {amplitude}: {work}");
        }
    }
}

#[test]
fn a_held_torque_below_breakaway_lets_elastoplastic_rest_where_lugre_creeps() {
    // Two thirds of the Coulomb level, with a ripple on it that makes LuGre creep.
    let amperes = |t: f64| 0.13 + 0.03 * (TAU * 40.0 * t).sin();
    let creep = |family: Family| {
        let run = run(1e-3, family, amperes, 0.4);
        run[1999].motor_angle_rad - run[999].motor_angle_rad
    };
    // Once the start has rung out, its bristle is bent by 1.3 mrad and 0.1 of ripple, and slides from
    // 2.1 on: what is left is the last of the ringing, after twenty whole periods of the ripple.
    let lugre = creep(Family::LuGre);
    let dupont = creep(Family::ElastoPlastic { breakaway: 0.7 });
    assert!(lugre > 1e-3 && dupont.abs() < 0.02 * lugre, "{lugre:e} {dupont:e}");
}

#[test]
fn maxwell_elements_remember_where_they_turned_back() {
    // Out to 4 mrad, where four of six elements slide (from 1.75 mrad on), back by less than turns the
    // first of them (3.5 mrad), and out again: the inner loop closes on the outer one.
    let out = 4e-3;
    let speed = |t: f64| match t {
        t if t < 0.1 => out / 0.1,
        t if t < 0.18 => -0.8 * out / 0.08,
        _ => 0.8 * out / 0.08,
    };
    let told =
        prescribed(Family::MaxwellSlip { elements: 6, attraction: 1.0 }, speed, 0.2602, 1e-5);
    let (first, again) = (told[9_998][2], told[told.len() - 1][2]);
    // The second is 8 µrad past where it turned, so that the four slide again and damp no more: the two
    // that stick have 1.43 Nm/rad, which is 0.05 % of 26 mNm.
    assert!((again / first - 1.0).abs() < 1e-3, "{first} {again}");
}

#[test]
fn elastoplastic_without_breakaway_deflection_slides_as_far_as_lugre() {
    // z_ba near z_ss: α jumps from 0 to 1, and the bristle bends to z_ss without giving way.
    let told = prescribed(Family::ElastoPlastic { breakaway: 0.99 }, |_| 0.01, 0.27, 1e-5);
    let [.., found] = told[told.len() - 1];
    let exact = SIGMA0 * 0.01 * 0.27 + 0.02 * 0.01 + 1e-3 * 0.01;
    assert!((found / exact - 1.0).abs() < 1e-4, "{found} {exact}");
}

#[test]
fn a_viscous_torque_without_limit_is_linear() {
    assert_eq!(limited_viscous::torque(0.3, 0.0), 0.3);
    assert!((limited_viscous::torque(1e-4, 1.0) - 1e-4).abs() < 1e-12);
    assert!((limited_viscous::torque(50.0, 1.0) - 1.0).abs() < 1e-12);
}

#[test]
fn a_step_scaled_to_the_speed_is_as_good_as_converged_in_every_family() {
    // Across breakaway and fast, both ways.
    let amperes = |t: f64| 0.6 * (TAU * 3.0 * t).sin() + 0.2 * (TAU * 31.0 * t).sin();
    for family in families() {
        let (coarse, fine) = (run(1e-4, family, amperes, 0.4), run(1e-4, family, amperes, 0.04));
        let speeds = coarse.iter().zip(&fine);
        let (mut error, mut size) = (0.0, 0.0);
        for (coarse, fine) in speeds {
            error += (coarse.motor_speed_rad_per_s - fine.motor_speed_rad_per_s).powi(2);
            size += fine.motor_speed_rad_per_s.powi(2);
        }
        // Distinct states change at a step's end: first order, a tenth of a thousandth here.
        let error = f64::sqrt(error / size);
        assert!(error < 1e-3, "{family:?}: {error:e}");
    }
}

#[test]
fn the_implicit_reference_agrees_on_the_laws_it_can_run() {
    let amperes = |t: f64| 0.6 * (TAU * 3.0 * t).sin();
    let time_s: Vec<f64> = (0..400).map(|k| f64::from(k) * 5e-4).collect();
    let drive_values = time_s.iter().map(|t| amperes(*t)).collect();
    let inputs = Inputs { time_s, drive: Drive::Current, drive_values, load_nm: Vec::new() };
    for family in families() {
        let options =
            Options { friction: family, ..Options::of(Method::Stiff { tolerance: 1e-8 }) };
        let stiff = simulate(&rotor(1e-4), &inputs, &options);
        if matches!(family, Family::MaxwellSlip { .. }) {
            assert!(stiff.is_err());
            continue;
        }
        let stiff = stiff.unwrap();
        let own = simulate(
            &rotor(1e-4),
            &inputs,
            &Options { friction: family, ..Options::of(Method::Scaled { share: 0.4 }) },
        );
        for (own, stiff) in own.unwrap().iter().zip(&stiff) {
            let error = own.motor_speed_rad_per_s - stiff.motor_speed_rad_per_s;
            assert!(error.abs() < 1e-2, "{family:?}: {error:e}");
        }
    }
}
