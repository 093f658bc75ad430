//! `joint-core` as the only dependency, in a control loop of one's own: what current the joint would
//! draw, beside what is measured.
//!
//! The parameters would be those that `joint export --format rust` has written. Double precision is
//! used once, to build the joint; the step has none.

#![cfg_attr(target_os = "none", no_std, no_main)]

use joint_core::joint::{Drive, Joint, Settings, State};
use joint_core::params::{Friction, Load, Motor, ParameterError, Stage};

/// A joint of one stage, without effects.
type Own = Joint<f32, 1>;

fn friction(coulomb_nm: f64) -> Friction {
    Friction {
        sigma0_nm_per_rad: 5_000.0 * coulomb_nm,
        sigma1_nm_s_per_rad: 0.04 * coulomb_nm,
        coulomb_nm,
        ..Friction::default()
    }
}

/// Once, at the start.
fn build() -> Result<Own, ParameterError> {
    let motor = Motor {
        phase_resistance_ohm: 0.4,
        phase_inductance_h: 0.2e-3,
        torque_constant_nm_per_a: 0.05,
        rotor_inertia_kg_m2: 2e-5,
        friction: friction(4e-3),
        ..Motor::default()
    };
    let stage = Stage {
        reduction: 50.0,
        inertia_kg_m2: 1e-3,
        stiffness_nm_per_rad: 8e3,
        friction: friction(0.5),
        ..Stage::default()
    };
    let load = Load { inertia_kg_m2: 0.05, ..Load::default() };
    Own::new(&motor, &[stage], &load, &Settings::new(Drive::Voltage, 50e-6))
}

/// Every control period: the voltage that is on the motor until the next, V; the current that the
/// model has at its end, A.
fn period(joint: &Own, state: &mut State<f32, 1>, voltage_v: f32) -> f32 {
    joint.step(state, joint.input(voltage_v, 0.0));
    joint.current(state)
}

#[cfg(target_os = "none")]
mod on_board {
    use firmware as _; // The panic handler, and the start of the board.

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let Ok(joint) = super::build() else {
            loop {
                cortex_m::asm::wfi();
            }
        };
        let mut state = joint.rest();
        loop {
            // Here the loop waits for its timer, and reads what it has put on the motor.
            let voltage_v = core::hint::black_box(6.0);
            core::hint::black_box(super::period(&joint, &mut state, voltage_v));
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() -> Result<(), ParameterError> {
    let joint = build()?;
    let mut state = joint.rest();
    for k in 0..2_000 {
        let current_a = period(&joint, &mut state, 6.0);
        if k % 200 == 0 {
            println!("{:.1} ms {current_a:.2} A", f64::from(k) * 0.05);
        }
    }
    Ok(())
}
