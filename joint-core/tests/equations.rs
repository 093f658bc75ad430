//! The step against equations (1) to (3) and (10), integrated by the classical Runge-Kutta method in SI, each mass
//! at its own side of the gear: what it does not share with the step are units, reflection and the splitting.

use joint_core::fixed::Fixed;
use joint_core::joint::{Drive, Joint, Method, Settings};
use joint_core::params::{Friction, Load, Motor, Stage};
use joint_core::scalar::Scalar;

const REDUCTION: f64 = -9.0;
const LOAD_NM: f64 = 0.3;

const MOTOR: Motor = Motor {
    phase_resistance_ohm: 0.4,
    phase_inductance_h: 2e-4,
    torque_constant_nm_per_a: 0.085,
    phase_back_emf_constant_v_s_per_rad: None,
    pole_pairs: 1,
    rotor_inertia_kg_m2: 4e-5,
    friction: Friction {
        sigma0_nm_per_rad: 14.0,
        sigma1_nm_s_per_rad: 0.012,
        sigma2_nm_s_per_rad: 9e-5,
        coulomb_nm: 0.014,
        stribeck_nm: 0.008,
        stribeck_velocity_rad_per_s: 12.0,
    },
};

fn stage() -> Stage {
    Stage {
        reduction: REDUCTION,
        inertia_kg_m2: 0.003,
        stiffness_nm_per_rad: 260.0,
        cubic_stiffness_nm_per_rad3: 4e6,
        damping_nm_s_per_rad: 0.5,
        friction: Friction {
            sigma0_nm_per_rad: 500.0,
            sigma1_nm_s_per_rad: 0.7,
            sigma2_nm_s_per_rad: 0.02,
            coulomb_nm: 0.2,
            stribeck_nm: 0.1,
            stribeck_velocity_rad_per_s: 1.5,
        },
        ..Stage::default()
    }
}

/// Current, speeds of rotor and output, deflection at the output, bristles of both.
type State = [f64; 6];

/// Torque of a mass's friction and the rate of its bristle z.
fn rubbed(own: &Friction, speed: f64, z: f64) -> [f64; 2] {
    let falling = (-(speed / own.stribeck_velocity_rad_per_s).powi(2)).exp();
    let level = own.coulomb_nm + own.stribeck_nm * falling;
    let rate = speed - own.sigma0_nm_per_rad * speed.abs() / level * z;
    let torque = own.sigma0_nm_per_rad * z
        + own.sigma1_nm_s_per_rad * rate
        + own.sigma2_nm_s_per_rad * speed;
    [torque, rate]
}

fn rates([i, v0, v1, x, z0, z1]: State, volts: f64) -> State {
    let (motor, stage) = (MOTOR, stage());
    let winding = 2.0 * motor.phase_resistance_ohm * i + motor.torque_constant_nm_per_a * v0;
    let wound = v0 / REDUCTION - v1;
    let spring = stage.stiffness_nm_per_rad * x
        + stage.cubic_stiffness_nm_per_rad3 * x.powi(3)
        + stage.damping_nm_s_per_rad * wound;
    let ([f0, bent0], [f1, bent1]) =
        (rubbed(&motor.friction, v0, z0), rubbed(&stage.friction, v1, z1));
    [
        (volts - winding) / (2.0 * motor.phase_inductance_h),
        (motor.torque_constant_nm_per_a * i - f0 - spring / REDUCTION) / motor.rotor_inertia_kg_m2,
        (spring - f1 - LOAD_NM) / (stage.inertia_kg_m2 + LOAD.inertia_kg_m2),
        wound,
        bent0,
        bent1,
    ]
}

const LOAD: Load = Load { inertia_kg_m2: 0.001, gravity_nm: 0.0, gravity_phase_rad: 0.0 };

/// A voltage from a state on, for 4 ms.
struct Run {
    from: State,
    volts: f64,
}

/// The output turns against the rotor. One run slides on, one turns round on both sides of the gear.
const RUNS: [Run; 2] = [
    Run { from: [3.0, 30.0, -3.0, -1e-3, 1e-3, -4e-4], volts: 6.0 },
    Run { from: [2.0, 8.0, -1.0, -1e-3, 1e-3, -4e-4], volts: -4.0 },
];
const DURATION_S: f64 = 4e-3;

impl Run {
    /// By the classical Runge-Kutta method.
    fn exact(&self) -> State {
        let h = 1e-7;
        let mut state = self.from;
        let along = |state: &State, rate: &State, h: f64| -> State {
            std::array::from_fn(|k| state[k] + h * rate[k])
        };
        for _ in 0..(DURATION_S / h).round() as u32 {
            let first = rates(state, self.volts);
            let second = rates(along(&state, &first, 0.5 * h), self.volts);
            let third = rates(along(&state, &second, 0.5 * h), self.volts);
            let fourth = rates(along(&state, &third, h), self.volts);
            let rate = std::array::from_fn(|k| {
                (first[k] + 2.0 * (second[k] + third[k]) + fourth[k]) / 6.0
            });
            state = along(&state, &rate, h);
        }
        state
    }

    /// By the step.
    fn stepped<S: Scalar>(&self, method: Method, steps: u32) -> State {
        let settings = Settings {
            micro_steps: Some(1),
            method: Some(method),
            ..Settings::new(Drive::Voltage, DURATION_S / f64::from(steps))
        };
        let joint = Joint::<S, 1>::new(&MOTOR, &[stage()], &LOAD, &settings).unwrap();
        let mut state = joint.rest();
        let [i, v0, v1, x, z0, z1] = self.from;
        let per_z =
            [&MOTOR.friction, &stage().friction].map(|own| own.sigma0_nm_per_rad / own.coulomb_nm);
        let sign = REDUCTION.signum();
        joint.set_current(&mut state, i);
        joint.set_speed(&mut state, 0, v0);
        joint.set_speed(&mut state, 1, v1 * REDUCTION);
        joint.set_deflection(&mut state, 0, x * REDUCTION);
        joint.set_bristle(&mut state, 0, z0 * per_z[0]);
        joint.set_bristle(&mut state, 1, z1 * per_z[1] * sign);
        joint.refresh(&mut state);
        let input = joint.input(S::from_f64(self.volts), S::from_f64(LOAD_NM));
        for _ in 0..steps {
            joint.step(&mut state, input);
        }
        [
            joint.current_a(&state),
            joint.speed_rad_per_s(&state, 0),
            joint.speed_rad_per_s(&state, 1) / REDUCTION,
            joint.deflection_rad(&state, 0) / REDUCTION,
            joint.bristle(&state, 0).to_f64() / per_z[0],
            joint.bristle(&state, 1).to_f64() / per_z[1] * sign,
        ]
    }

    /// What is missed of each, over its size.
    fn missed<S: Scalar>(&self, exact: &State, method: Method, steps: u32) -> State {
        let found = self.stepped::<S>(method, steps);
        std::array::from_fn(|k| (found[k] - exact[k]).abs() / exact[k].abs())
    }
}

/// What may be missed of each quantity: half as much again as the step misses.
fn assert_missed<S: Scalar>(method: Method, steps: u32, most: [State; 2]) {
    for (run, most) in RUNS.iter().zip(most) {
        let missed = run.missed::<S>(&run.exact(), method, steps);
        for (k, (missed, most)) in missed.into_iter().zip(most).enumerate() {
            assert!(missed < most, "{method:?} of {steps} from {:?}, {k}: {missed}", run.from);
        }
    }
}

#[test]
fn both_methods_give_the_equations() {
    let splitting =
        [[1.5e-4, 8e-5, 6e-5, 5e-4, 4e-8, 5e-7], [2.5e-4, 5e-4, 6e-3, 1.4e-3, 2e-3, 5e-5]];
    assert_missed::<f64>(Method::Splitting, 20, splitting);
    let implicit =
        [[2.3e-4, 1.5e-4, 9e-5, 2e-4, 4e-9, 9e-7], [6e-4, 1.4e-3, 9e-3, 6e-4, 6e-4, 5e-5]];
    assert_missed::<f64>(Method::Implicit, 20, implicit);
    // A sixteenth of the step, within three times a sixteenth's square: the second run's errors change their sign.
    let [splitting, implicit] =
        [splitting, implicit].map(|all| all.map(|own| own.map(|it| it / 85.0)));
    assert_missed::<f64>(Method::Splitting, 320, splitting);
    assert_missed::<f64>(Method::Implicit, 320, implicit);
}

#[test]
fn every_format_gives_the_equations() {
    let single = [[1e-5; 6], [1e-4; 6]].map(|own| own.map(|it| 2.0 * it));
    assert_missed::<f32>(Method::Splitting, 160, single);
    assert_missed::<f32>(Method::Implicit, 160, single);
    assert_missed::<Fixed>(Method::Splitting, 160, [[5e-5; 6], [2e-4; 6]]);
}
