//! The three-phase motor behind its amplifier, beside the equations it stands for.

use joint_core::joint::{Drive, Joint, Settings};
use joint_core::motor::back_emf::{of_phases, shape};
use joint_core::motor::commutation::{SECTORS, from_hall, hall};
use joint_core::motor::inverter::Amplifier;
use joint_core::params::{Friction, Load, Motor, Table};
use joint_core::scalar::Real;
use joint_core::six_step::{Command, SixStep, SixStepState};
use proptest::prelude::*;

/// A 6 mm micromotor.
fn motor(pole_pairs: u32) -> Motor {
    Motor {
        phase_resistance_ohm: 4.55,
        phase_inductance_h: 13e-6,
        torque_constant_nm_per_a: 1.38e-3,
        rotor_inertia_kg_m2: 9.5e-10,
        pole_pairs,
        friction: Friction {
            sigma0_nm_per_rad: 0.05,
            sigma1_nm_s_per_rad: 4e-7,
            sigma2_nm_s_per_rad: 4e-9,
            coulomb_nm: 2.5e-5,
            stribeck_nm: 4e-6,
            stribeck_velocity_rad_per_s: 20.0,
        },
        ..Motor::default()
    }
}

fn amplifier(bus_v: f64) -> Amplifier {
    Amplifier {
        bus_v,
        pwm_period_s: 10e-6,
        dead_time_s: 1e-7,
        current_bandwidth_rad_per_s: 3e4,
        current_limit_a: 0.5,
    }
}

fn six_step<S: Real>(motor: &Motor, amplifier: &Amplifier) -> SixStep<S, 0> {
    SixStep::with(motor, &[], &Load::default(), amplifier, |_| Some(())).unwrap()
}

/// Rotor speed, rad/s, and current where no commutation was under way, A: means over the second
/// half of 0.1 s.
fn settled<S: Real>(motor: &Motor, amplifier: &Amplifier, command: Command<S>) -> [f64; 2] {
    let joint = six_step::<S>(motor, amplifier);
    let mut state = joint.rest();
    let (mut speed, mut current, mut counted) = (0.0, 0.0, 0);
    let mut since = 0;
    let mut last = None;
    for k in 0..10_000 {
        joint.step(&mut state, command, S::ZERO);
        since = if state.conduction == last { since + 1 } else { 0 };
        last = state.conduction;
        if k >= 5000 {
            speed += joint.joint().speed(&state.joint, 0).to_f64() / 5000.0;
            // Five lags are two periods.
            if since > 2 {
                current += joint.measured_current(&state).to_f64();
                counted += 1;
            }
        }
    }
    assert!(counted > 2000);
    [speed, current / f64::from(counted)]
}

/// The same of the DC equivalent, equation (10).
fn equivalent(motor: &Motor, volts: f64) -> [f64; 2] {
    let settings = Settings::new(Drive::Voltage, 10e-6);
    let joint = Joint::<f64, 0>::new(motor, &[], &Load::default(), &settings).unwrap();
    let mut state = joint.rest();
    let mut sums = [0.0; 2];
    for k in 0..10_000 {
        joint.step(&mut state, joint.input(volts, 0.0));
        if k >= 5000 {
            sums[0] += joint.speed(&state, 0) / 5000.0;
            sums[1] += joint.current(&state) / 5000.0;
        }
    }
    sums
}

#[track_caller]
fn assert_near(found: [f64; 2], wanted: [f64; 2], share: f64) {
    for (found, wanted) in found.into_iter().zip(wanted) {
        assert!((found - wanted).abs() < share * wanted.abs(), "{found} for {wanted}");
    }
}

#[test]
fn the_dc_equivalent_follows_from_the_three_phases_within_one_per_cent() {
    for (pole_pairs, volts) in [(1, 1.0), (1, -2.5), (4, 1.0)] {
        let motor = motor(pole_pairs);
        let wanted = equivalent(&motor, volts);
        let bus = amplifier(volts.abs());
        assert_near(settled(&motor, &bus, Command::Voltage(volts)), wanted, 0.01);
        assert_near(settled(&motor, &bus, Command::Voltage(volts as f32)), wanted, 0.01);
    }
}

/// Share of the DC equivalent's speed that a chopped bus of 6 V reaches at 2 V.
fn chopped(motor: &Motor, dead_time_s: f64) -> f64 {
    let amplifier = Amplifier { dead_time_s, ..amplifier(6.0) };
    settled(motor, &amplifier, Command::Voltage(2.0_f64))[0] / equivalent(motor, 2.0)[0]
}

#[test]
fn a_chopped_bus_loses_what_the_open_phase_s_diode_carries() {
    // While both driven phases are at ground, an open phase with negative back-EMF conducts and
    // brakes: two per cent here, which equation (10) does not know.
    let share = chopped(&motor(1), 0.0);
    assert!(share > 0.97 && share < 0.99, "{share}");
}

#[test]
fn dead_time_costs_its_share_of_the_bus_where_the_current_keeps_its_sign() {
    let smooth = Motor { phase_inductance_h: 2e-3, ..motor(1) };
    let lost = chopped(&smooth, 0.0) - chopped(&smooth, 3e-7);
    // 0.3 µs of 10 µs at 6 V, of 1.8 V that turn the motor.
    let wanted = 0.18 / (1.38e-3 * equivalent(&smooth, 2.0)[0]);
    assert!((lost - wanted).abs() < 0.2 * wanted, "{lost} for {wanted}");
    // A ripple that crosses zero meets the other diode and gets the voltage back.
    let rippling = chopped(&motor(1), 0.0) - chopped(&motor(1), 3e-7);
    assert!(rippling < 0.1 * wanted, "{rippling}");
}

#[test]
fn the_current_loop_holds_its_command_on_a_locked_rotor_and_a_running_one() {
    for (inertia, periods) in [(1.0, 200), (9.5e-10, 300)] {
        let motor = Motor { rotor_inertia_kg_m2: inertia, ..motor(1) };
        let joint = six_step::<f64>(&motor, &amplifier(6.0));
        let mut state = joint.rest();
        for _ in 0..periods {
            joint.step(&mut state, Command::Current(-0.05), 0.0);
        }
        let current = joint.measured_current(&state);
        assert!((current + 0.05).abs() < 1e-3, "{current}");
    }
}

#[test]
fn commutation_leaves_a_ripple_of_six_per_electrical_turn() {
    let joint = six_step::<f64>(&motor(1), &amplifier(3.0));
    let mut state = joint.rest();
    let run = |state: &mut SixStepState<f64, 0>| joint.step(state, Command::Voltage(3.0), 0.0);
    (0..8000).for_each(|_| run(&mut state));
    let start = state.joint.angle.to_turns();
    let (mut dips, mut low) = (0, false);
    let mean = joint.torque_current(&state);
    while state.joint.angle.to_turns() < start + 10.0 {
        run(&mut state);
        let ratio = joint.torque_current(&state) / mean;
        if !low && ratio < 0.9 {
            dips += 1;
        }
        low = ratio < 0.95;
    }
    assert!((59..=61).contains(&dips), "{dips} dips in ten turns");
}

#[test]
fn bus_work_is_heat_motion_and_what_is_stored() {
    let motor = Motor { friction: Friction::default(), ..motor(2) };
    let joint = six_step::<f64>(&motor, &amplifier(6.0));
    let mut state = joint.rest();
    let (mut work, mut heat, mut moved) = (0.0, 0.0, 0.0);
    for k in 0..5000 {
        let command = if k < 2500 { 0.15 } else { -0.1 };
        let before = joint.joint().speed(&state.joint, 0);
        joint.step(&mut state, Command::Current(command), 0.0);
        let mean = 0.5 * (before + joint.joint().speed(&state.joint, 0));
        let [supplied, lost] = joint.work_and_heat(&state);
        work += supplied;
        heat += lost;
        moved += 1.38e-3 * joint.torque_current(&state) * mean * 10e-6;
    }
    let speed = joint.joint().speed(&state.joint, 0);
    let kinetic = 0.5 * 9.5e-10 * speed * speed;
    let residue = work - heat - kinetic - joint.stored(&state);
    let scale = heat + kinetic;
    assert!(residue.abs() < 1e-3 * scale, "{residue} of {scale}");
    assert!((moved - kinetic).abs() < 1e-3 * moved.abs(), "{moved} for {kinetic}");
}

#[test]
fn an_amplifier_that_cannot_be_is_refused_by_name() {
    let bad = Amplifier { dead_time_s: 8e-6, ..amplifier(6.0) };
    let with = |motor: &Motor, amplifier: &Amplifier| {
        SixStep::<f32, 0>::with(motor, &[], &Load::default(), amplifier, |_| Some(())).unwrap_err()
    };
    let error = with(&motor(1), &bad);
    assert_eq!((error.table, error.key), (Table::Amplifier, "dead_time_s"));
    let unwound = Motor { phase_inductance_h: 0.0, ..motor(1) };
    assert_eq!(with(&unwound, &amplifier(6.0)).key, "phase_inductance_h");
}

proptest! {
    #[test]
    fn the_shape_repeats_with_a_turn_and_turns_over_with_half_of_it(turns in -40.0..40.0_f64) {
        prop_assert!((shape(turns) - shape(turns + 1.0)).abs() < 1e-11);
        prop_assert!((shape(turns) + shape(turns + 0.5)).abs() < 1e-11);
        // Even about the middle of its flat.
        prop_assert!((shape(1.0 / 6.0 + turns) - shape(1.0 / 6.0 - turns)).abs() < 1e-11);
    }

    #[test]
    fn the_table_picks_the_phases_on_their_flats(
        rotor in -0.5..0.5_f64, whole in -1000_i32..1000, pole_pairs in 1_u32..=24,
    ) {
        use joint_core::angle::{Angle, Ratio};
        let angle = Angle { whole, part: rotor, lost: 0.0 };
        let electrical = Ratio::<f64>::new(f64::from(pole_pairs)).of(angle);
        let f = of_phases(electrical);
        let conduction = from_hall(hall(electrical)).unwrap();
        prop_assert!(f[conduction.high] > 1.0 - 1e-9 && f[conduction.low] < -1.0 + 1e-9);
        prop_assert!(f[conduction.open].abs() <= 1.0);
        let reversed = conduction.reversed();
        prop_assert_eq!((reversed.high, reversed.low), (conduction.low, conduction.high));
        prop_assert!(SECTORS.contains(&conduction));
        // Torque of one ampere through the pair: k_t/2 (f_high − f_low) = k_t.
        prop_assert!((0.5 * (f[conduction.high] - f[conduction.low]) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn the_torque_constant_is_twice_the_back_emf_constant_or_an_error(share in 0.5..1.5_f64) {
        let motor = Motor { phase_back_emf_constant_v_s_per_rad: Some(share * 0.69e-3), ..motor(1) };
        let balanced = (share - 1.0).abs() <= 0.01;
        let found = SixStep::<f64, 0>::with(
            &motor, &[], &Load::default(), &amplifier(6.0), |_| Some(()));
        prop_assert_eq!(found.is_ok(), balanced);
    }
}
