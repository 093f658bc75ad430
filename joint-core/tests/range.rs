//! A fixed-point joint at the ends of what is admissible.

use joint_core::fixed::Fixed;
use joint_core::joint::{Drive, Joint, Settings};
use joint_core::number::Number;
use joint_core::params::{Friction, Load, Motor, Stage, Table};
use joint_core::range::largest_drive;

const LOAD_NM: f64 = 0.01;

fn friction(coulomb_nm: f64, stiffness: f64) -> Friction {
    Friction {
        sigma0_nm_per_rad: stiffness,
        sigma1_nm_s_per_rad: 1e-5 * stiffness,
        sigma2_nm_s_per_rad: 1e-8 * stiffness,
        coulomb_nm,
        stribeck_nm: 0.4 * coulomb_nm,
        stribeck_velocity_rad_per_s: 400.0 * coulomb_nm / stiffness,
    }
}

fn motor() -> Motor {
    Motor {
        phase_resistance_ohm: 4.55,
        phase_inductance_h: 13e-6,
        torque_constant_nm_per_a: 1.38e-3,
        rotor_inertia_kg_m2: 9.5e-10,
        friction: friction(9e-6, 0.05),
        ..Motor::default()
    }
}

/// The same gear, stiffer and heavier; a softer one swings for longer than the load here waits.
fn stages(stiffness: f64, inertia: f64) -> [Stage; 2] {
    [(2e-9, 0.35, 8e-5), (8e-7, 15.0, 1e-3)].map(|(own, spring, level)| Stage {
        reduction: 32.0,
        inertia_kg_m2: own * inertia,
        stiffness_nm_per_rad: spring * stiffness,
        friction: friction(level, 4.0 * spring),
        ..Stage::default()
    })
}

/// However drive and load turn round between their ends once a swing has died out, the numbers have
/// room.
#[test]
fn no_word_ends_its_range_up_to_the_largest_drive() {
    for (stiffness, inertia) in [(1.0, 1.0), (4.0, 3.0), (3.0, 1.0), (3.0, 10.0)] {
        let (motor, stages, load) = (motor(), stages(stiffness, inertia), Load::default());
        let settings = Settings::new(Drive::Voltage, 50e-6);
        let most = largest_drive::<Fixed>(&motor, &stages, &load, &settings, LOAD_NM);
        // The joint breaks away at 0.12 V; its motor is made for 6.
        assert!(most > 0.5, "{stiffness} {inertia}: only {most} V");
        let joint = Joint::<Fixed, 2>::new(&motor, &stages, &load, &settings).unwrap();
        let drive = [-most, most].map(Fixed::from_f64);
        let load = [-LOAD_NM, LOAD_NM].map(Fixed::from_f64);
        for pattern in 0..12_u32 {
            let mut state = joint.rest();
            for k in 0..2000_u32 {
                let (first, second) =
                    ((k / (80 + 13 * pattern)) % 2, (k / (100 + 7 * pattern)) % 2);
                let input = joint.input(drive[first as usize], load[second as usize]);
                joint.step(&mut state, input);
                assert_eq!(joint.saturated(&state), 0, "{stiffness} {inertia} {pattern} at {k}");
            }
        }
    }
}

#[test]
fn a_constant_beyond_the_format_names_its_parameter() {
    let settings = Settings::new(Drive::Voltage, 50e-6);
    let refused = |motor: &Motor, stages: &[Stage; 2]| {
        let load = Load::default();
        assert!(Joint::<f32, 2>::new(motor, stages, &load, &settings).is_ok());
        let error = Joint::<Fixed, 2>::new(motor, stages, &load, &settings).unwrap_err();
        (error.table, error.key)
    };
    let stiff = stages(1e6, 1.0);
    assert_eq!(refused(&motor(), &stiff), (Table::Stage(1), "stiffness_nm_per_rad"));
    let mut damped = motor();
    damped.friction.sigma1_nm_s_per_rad = 1e-3;
    assert_eq!(refused(&damped, &stages(1.0, 1.0)), (Table::MotorFriction, "sigma1_nm_s_per_rad"));
    let mut sticky = stages(1.0, 1.0);
    sticky[1].friction.stribeck_nm = 100.0 * sticky[1].friction.coulomb_nm;
    assert_eq!(refused(&motor(), &sticky), (Table::StageFriction(2), "stribeck_nm"));
}

#[test]
fn floats_have_room_for_any_drive() {
    let settings = Settings::new(Drive::Voltage, 50e-6);
    let load = Load::default();
    let most = largest_drive::<f32>(&motor(), &stages(1.0, 1.0), &load, &settings, LOAD_NM);
    assert!(most.is_infinite());
}
