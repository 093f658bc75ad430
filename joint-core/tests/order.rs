//! What the step misses with effects that are large, in steps that are long: a share of second order that has the
//! wrong sign changes nothing else.

use std::f64::consts::TAU;

use joint_core::effect::{EffectParameters, EffectSet, Kind};
use joint_core::joint::{Drive, Joint, Method, Settings};
use joint_core::params::{Friction, Load, Location, Motor, Stage};

use Location::{Inverter, Output};

const DURATION_S: f64 = 4e-3;

/// Two gears whose masses rub or do not, driven by a voltage or a current, with these effects.
struct Case {
    effects: Vec<EffectParameters>,
    drive: Drive,
    rubs: bool,
    /// What the splitting and the implicit method may miss in 20 steps and in 40.
    most: [[f64; 2]; 2],
}

impl Case {
    /// Current, speeds and deflections, from the middle of a motion on.
    fn after(&self, method: Method, steps: u32) -> [f64; 6] {
        let friction = match self.rubs {
            true => Friction {
                sigma0_nm_per_rad: 14.0,
                sigma1_nm_s_per_rad: 0.012,
                sigma2_nm_s_per_rad: 9e-5,
                coulomb_nm: 0.014,
                stribeck_nm: 0.0,
                stribeck_velocity_rad_per_s: 3.0,
            },
            false => Friction::default(),
        };
        let motor = Motor {
            phase_resistance_ohm: 0.4,
            phase_inductance_h: 2e-4,
            torque_constant_nm_per_a: 0.085,
            rotor_inertia_kg_m2: 4e-5,
            friction,
            ..Motor::default()
        };
        let stages = [4e-4, 4e-3].map(|inertia_kg_m2| Stage {
            reduction: 3.0,
            inertia_kg_m2,
            stiffness_nm_per_rad: 60.0,
            friction,
            ..Stage::default()
        });
        let settings = Settings {
            micro_steps: Some(1),
            method: Some(method),
            effects: &self.effects,
            ..Settings::new(self.drive, DURATION_S / f64::from(steps))
        };
        let load = Load::default();
        let joint =
            Joint::<f64, 2, EffectSet<f64>>::new(&motor, &stages, &load, &settings).unwrap();
        let mut state = joint.rest();
        joint.set_current(&mut state, 4.0);
        for mass in 0..3 {
            joint.set_speed(&mut state, mass, 60.0);
            joint.set_bristle(&mut state, mass, f64::from(u8::from(self.rubs)));
        }
        joint.set_deflection(&mut state, 0, 0.15);
        joint.set_deflection(&mut state, 1, 0.3);
        joint.refresh(&mut state);
        let drive = if self.drive == Drive::Voltage { 9.0 } else { 4.0 };
        for _ in 0..steps {
            joint.step(&mut state, joint.input(drive, 0.1));
        }
        let [v0, v1, v2] = [0, 1, 2].map(|mass| joint.speed_rad_per_s(&state, mass));
        let [one, other] = [0, 1].map(|stage| joint.deflection_rad(&state, stage));
        [joint.current_a(&state), v0, v1, v2, one, other]
    }

    /// Largest share that a quantity is off from what the splitting makes of a thousandth of the step.
    fn missed(&self, method: Method, steps: u32, exact: &[f64; 6]) -> f64 {
        let found = self.after(method, steps);
        let shares = found.iter().zip(exact).map(|(found, exact)| (found / exact - 1.0).abs());
        shares.fold(0.0, f64::max)
    }
}

fn at(kind: Kind, location: Location, values: &[(&str, f64)]) -> EffectParameters {
    let example = EffectParameters { location, ..EffectParameters::example(kind) };
    values.iter().fold(example, |effect, (key, value)| effect.with(key, *value))
}

/// A torque on a shaft that comes again eight times in an interval of 0.8 rad.
fn waves(location: Location) -> EffectParameters {
    let curve: Vec<f64> = (0..16).map(|k| 2.0 * (f64::from(k) * TAU / 8.0).sin()).collect();
    let map = EffectParameters::new(Kind::TorqueMap, location).with_table(&curve, &[]).unwrap();
    map.with("period_rad", 0.8)
}

fn assert_missed(cases: &[Case]) {
    for case in cases {
        let exact = case.after(Method::Splitting, 20_480);
        for (method, most) in [Method::Splitting, Method::Implicit].into_iter().zip(case.most) {
            for (steps, most) in [20, 40].into_iter().zip(most) {
                let missed = case.missed(method, steps, &exact);
                let kinds: Vec<_> =
                    case.effects.iter().map(|own| (own.kind, own.location)).collect();
                assert!(missed < most, "{kinds:?}, {method:?} of {steps}: {missed}");
            }
        }
    }
}

fn case(effects: &[EffectParameters], drive: Drive, rubs: bool, most: [[f64; 2]; 2]) -> Case {
    // A quarter more than is missed.
    Case { effects: effects.to_vec(), drive, rubs, most: most.map(|own| own.map(|it| 1.25 * it)) }
}

#[test]
fn torques_and_springs_of_effects_are_missed_by_no_more_than_their_order_leaves() {
    let cog = at(Kind::Cogging, Location::Motor, &[("order", 12.0), ("amplitude_nm", 0.2)]);
    let drag = at(Kind::QuadraticDrag, Location::Motor, &[("coefficient_nm_s2", 2e-4)]);
    let of = |effect, most| case(&[effect], Drive::Current, false, most);
    assert_missed(&[
        of(cog, [[2.4e-7, 1.5e-8], [2.8e-3, 6.8e-4]]),
        of(waves(Output), [[3.1e-7, 2e-8], [4.2e-3, 1.1e-3]]),
        of(drag, [[7.8e-3, 3.9e-3], [10e-3, 5.3e-3]]),
        of(
            at(Kind::HardeningStiffness, Location::Stage(1), &[]),
            [[9.6e-5, 5.8e-6], [4.5e-2, 1.1e-2]],
        ),
        of(
            at(Kind::StructuralHysteresis, Location::Stage(1), &[]),
            [[3.6e-7, 2.2e-8], [4.1e-3, 1.1e-3]],
        ),
        of(
            at(Kind::TransmissionError, Location::Stage(2), &[]),
            [[2.1e-7, 5.3e-9], [4.2e-3, 1.1e-3]],
        ),
    ]);
}

#[test]
fn effects_of_the_winding_are_those_of_the_middle_of_a_kick_alone_and_beside_each_other() {
    let ripple = at(Kind::TorqueRipple, Location::Motor, &[]);
    let saturation = at(Kind::TorqueSaturation, Location::Motor, &[]);
    let dead = at(Kind::DeadTime, Inverter, &[("voltage_v", 0.8), ("softening_a", 1.0)]);
    let limit = at(Kind::CurrentLimit, Inverter, &[("limit_a", 5.0)]);
    let of = |effects: &[EffectParameters], most| case(effects, Drive::Voltage, false, most);
    assert_missed(&[
        of(&[ripple], [[2e-2, 9.9e-3], [5.7e-2, 1.4e-2]]),
        of(&[saturation], [[1.1e-3, 2.8e-4], [2e-3, 5.5e-4]]),
        of(&[dead], [[3.6e-4, 9.8e-5], [7.3e-3, 1.8e-3]]),
        of(&[limit], [[7.7e-4, 2.1e-4], [4.4e-3, 1.1e-3]]),
        of(&[dead, ripple], [[2.5e-3, 1.4e-3], [7.2e-3, 1.8e-3]]),
        of(&[dead, saturation], [[1.1e-3, 2.9e-4], [2e-3, 5.4e-4]]),
        of(&[limit, ripple], [[2.3e-4, 1.6e-4], [4.8e-3, 1.2e-3]]),
        of(&[limit, dead], [[6.5e-4, 1.8e-4], [3.3e-3, 8.2e-4]]),
        of(&[limit, dead, ripple], [[2.9e-4, 9.4e-5], [3.4e-3, 8.4e-4]]),
    ]);
}

#[test]
fn friction_that_follows_an_angle_is_that_of_both_ends_of_a_drift() {
    let of = |effect, most| case(&[effect], Drive::Current, true, most);
    let position = |location| at(Kind::PositionDependentFriction, location, &[]);
    assert_missed(&[
        of(position(Location::Motor), [[4e-4, 2.7e-4], [3.7e-3, 8.9e-4]]),
        of(position(Location::Stage(1)), [[8e-4, 1.4e-4], [3.9e-3, 9.5e-4]]),
        of(position(Location::Stage(2)), [[9.7e-6, 2.3e-6], [3.9e-3, 9.6e-4]]),
        of(at(Kind::FrictionShape, Location::Stage(1), &[]), [[5.1e-4, 1.7e-4], [3.9e-3, 9.6e-4]]),
    ]);
}
