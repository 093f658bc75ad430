//! The torques that act in a joint, for hosts and other simulators; not for a drive.

use super::constants::Joint;
use crate::effect::Effects;
use crate::scalar::Scalar;
use crate::state::State;

/// Torques as they are felt at the motor, Nm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Torques<S, const N: usize> {
    /// Of the motor on its rotor, k_t i with what effects make of k_t.
    pub motor: S,
    /// Of the friction on the rotor, positive against positive motion.
    pub motor_friction: S,
    /// Of each stage's spring and damper on the mass behind it, with hysteresis; positive where the motor's
    /// side leads.
    pub stages: [S; N],
    /// Of the friction on the mass behind each stage, positive against positive motion.
    pub stage_friction: [S; N],
}

impl<S: Scalar, const N: usize, E: Effects<S>> Joint<S, N, E> {
    /// The torques in a state, as equations (1) to (3) have them.
    pub fn torques(&self, state: &State<S, N>) -> Torques<S, N> {
        let unit = |torque: S| torque.times(self.units.torque);
        let mut factor = S::ONE;
        if self.effects.has_constants() {
            factor = factor + self.effects.constants(state.angle, state.current).torque;
        }
        let (rotor, masses) = self.friction(state);
        let mut torques = Torques {
            motor: unit(state.current * factor),
            motor_friction: unit(rotor),
            stages: [S::ZERO; N],
            stage_friction: masses.map(unit),
        };
        let (mut wound, mut input, mut before) = (S::ZERO, state.angle, state.rotor.speed);
        let own = state.stages.iter().zip(&self.stages).enumerate();
        for ((number, (stage, own)), torque) in own.zip(&mut torques.stages) {
            let felt = self.felt(number, stage.deflection, input);
            let mut sum = own.spring.torque(felt.deflection);
            if self.effects.has_stage(number) {
                sum = sum + self.effects.stage_torque(number, felt.deflection, &state.memory).value;
            }
            let damped = own.spring.damping_torque(before - stage.mass.speed);
            *torque = unit(sum + damped * felt.contact);
            wound = wound + stage.deflection;
            input = own.own_angle(state.angle.ahead(-wound.times(self.turns)));
            before = stage.mass.speed;
        }
        torques
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;

    use super::Torques;
    use crate::effect::{EffectParameters, EffectSet, Kind};
    use crate::joint::{Drive, Joint, Settings};
    use crate::params::{Friction, Load, Location, Motor, Stage};
    use crate::state::State;

    /// What is left over on rotor and output of a joint that has slid for ten seconds, of the motor's torque.
    fn left_over(step_s: f64) -> [f64; 3] {
        let friction = Friction {
            sigma0_nm_per_rad: 14.0,
            sigma1_nm_s_per_rad: 0.012,
            sigma2_nm_s_per_rad: 9e-5,
            coulomb_nm: 0.014,
            ..Friction::default()
        };
        let motor = Motor {
            phase_resistance_ohm: 0.4,
            phase_inductance_h: 2e-4,
            torque_constant_nm_per_a: 0.085,
            rotor_inertia_kg_m2: 4e-5,
            friction,
            ..Motor::default()
        };
        let stage = Stage {
            reduction: -9.0,
            inertia_kg_m2: 0.004,
            stiffness_nm_per_rad: 260.0,
            damping_nm_s_per_rad: 0.5,
            friction: Friction { coulomb_nm: 0.2, sigma0_nm_per_rad: 500.0, ..friction },
            ..Stage::default()
        };
        let settings = Settings::new(Drive::Voltage, step_s);
        let joint = Joint::<f64, 1>::new(&motor, &[stage], &Load::default(), &settings).unwrap();
        let mut state = joint.rest();
        // The load is the output's own; reflected by the gear, which reverses.
        let load_nm = 0.3;
        for _ in 0..(10.0 / step_s) as usize {
            joint.step(&mut state, joint.input(6.0, load_nm));
        }
        let torques = joint.torques(&state);
        // It slides: no bristle holds a mass.
        assert!(torques.motor > 0.0 && state.rotor.speed > 1.0);
        let speed = joint.speed_rad_per_s(&state, 1) / 9.0;
        let slipping = (0.2 + 9e-5 * speed) / 9.0;
        [
            torques.motor - torques.motor_friction - torques.stages[0],
            torques.stages[0] - torques.stage_friction[0] + load_nm / 9.0,
            torques.stage_friction[0] - slipping,
        ]
        .map(|left| left.abs() / torques.motor)
    }

    /// At constant speed nothing accelerates: what drives a mass is what brakes it. The step balances forces
    /// with their gradient in the middle kick, h²/24 of it, so that those at a sample balance to the second order.
    #[test]
    fn at_constant_speed_the_torques_on_every_mass_balance() {
        let [coarse, fine] = [1e-4, 5e-5].map(left_over);
        for (coarse, fine) in coarse.into_iter().zip(fine) {
            assert!(coarse < 1e-3, "{coarse}");
            // Rounding of a state that has settled: 1e-9.
            assert!(fine < 1e-9 || (3.5..4.5).contains(&(coarse / fine)), "{coarse} {fine}");
        }
    }

    const RUBS: Friction = Friction {
        sigma0_nm_per_rad: 14.0,
        sigma1_nm_s_per_rad: 0.012,
        sigma2_nm_s_per_rad: 9e-5,
        coulomb_nm: 0.014,
        stribeck_nm: 0.004,
        stribeck_velocity_rad_per_s: 3.0,
    };

    /// Two gears in motion, a step of a microsecond later, with these effects.
    fn moving(effects: &[EffectParameters]) -> (Joint<f64, 2, EffectSet<f64>>, State<f64, 2>) {
        let motor = Motor {
            phase_resistance_ohm: 0.4,
            phase_inductance_h: 2e-4,
            torque_constant_nm_per_a: 0.085,
            rotor_inertia_kg_m2: 4e-5,
            friction: RUBS,
            ..Motor::default()
        };
        let stages = [4e-4, 4e-3].map(|inertia_kg_m2| Stage {
            reduction: 3.0,
            inertia_kg_m2,
            stiffness_nm_per_rad: 60.0,
            damping_nm_s_per_rad: 0.01,
            friction: RUBS,
            ..Stage::default()
        });
        let settings =
            Settings { micro_steps: Some(1), effects, ..Settings::new(Drive::Voltage, 1e-6) };
        let joint =
            Joint::<f64, 2, EffectSet<f64>>::new(&motor, &stages, &Load::default(), &settings)
                .unwrap();
        let mut state = joint.rest();
        joint.set_current(&mut state, 6.0);
        for (mass, speed) in [60.0, 40.0, 20.0].into_iter().enumerate() {
            joint.set_speed(&mut state, mass, speed);
        }
        joint.set_deflection(&mut state, 0, 0.15);
        joint.set_deflection(&mut state, 1, 0.3);
        joint.refresh(&mut state);
        for _ in 0..1000 {
            joint.step(&mut state, joint.input(9.0, 0.1));
        }
        (joint, state)
    }

    /// Each mass takes up what its torques leave: they are those of the step, whatever effect changes them.
    #[test]
    fn what_the_torques_on_a_mass_leave_accelerates_it_with_every_effect() {
        let at = |kind, location| EffectParameters { location, ..EffectParameters::example(kind) };
        // Inertias at the motor.
        let inertias = [4e-5, 4e-4 / 9.0, 4e-3 / 81.0];
        for (effect, masses) in [
            (at(Kind::TorqueRipple, Location::Motor), 0..3),
            (at(Kind::TorqueSaturation, Location::Motor), 0..3),
            (at(Kind::StructuralHysteresis, Location::Stage(2)), 0..3),
            (at(Kind::FrictionShape, Location::Motor), 0..3),
            (at(Kind::FrictionShape, Location::Stage(1)), 0..3),
            (at(Kind::FrictionShape, Location::Stage(2)), 0..3),
            (at(Kind::LoadDependentFriction, Location::Stage(1)), 0..3),
            (at(Kind::AsymmetricFriction, Location::Motor), 0..3),
            (at(Kind::PositionDependentFriction, Location::Stage(2)), 0..3),
            (at(Kind::DriveEfficiency, Location::Stage(2)), 0..3),
            // An error of the gear pulls at the mass before it by another lever.
            (at(Kind::TransmissionError, Location::Stage(2)).with("amplitude_rad", 0.02), 2..3),
        ] {
            let (joint, mut state) = moving(&[effect]);
            let (plain, other) = moving(&[]);
            assert_ne!(joint.torques(&state), plain.torques(&other), "{:?}", effect.kind);
            let look = |state: &State<f64, 2>| {
                let speeds = [0, 1, 2].map(|mass| joint.speed_rad_per_s(state, mass));
                let Torques { motor, motor_friction, stages, stage_friction } =
                    joint.torques(state);
                let left = [
                    motor - motor_friction - stages[0],
                    stages[0] - stage_friction[0] - stages[1],
                    stages[1] - stage_friction[1] - 0.1 / 9.0,
                ];
                (speeds, left)
            };
            let (before, first) = look(&state);
            joint.step(&mut state, joint.input(9.0, 0.1));
            let (after, last) = look(&state);
            for mass in masses {
                let taken = inertias[mass] * (after[mass] - before[mass]) / 1e-6;
                let left = 0.5 * (first[mass] + last[mass]);
                // A microsecond of a bristle's 0.2 ms, squared, of torques of an Nm.
                let kind = effect.kind;
                assert!((taken - left).abs() < 1e-5, "{kind:?}, {mass}: {taken} {left}");
            }
        }
    }

    #[test]
    fn friction_that_follows_the_load_follows_that_of_a_gears_hysteresis_too() {
        let location = Location::Stage(1);
        let rubs =
            EffectParameters { location, ..EffectParameters::example(Kind::LoadDependentFriction) };
        let bends =
            EffectParameters { location, ..EffectParameters::example(Kind::StructuralHysteresis) };
        let (joint, mut state) = moving(&[rubs, bends]);
        joint.refresh(&mut state);
        let torques = joint.torques(&state);
        let (other, mut like) = moving(&[rubs]);
        // The same torque by the spring alone, of 60 Nm/rad behind a gear of 3.
        let spring = |torque: f64| 9.0 / 60.0 * torque;
        like.current = state.current;
        like.rotor = state.rotor;
        like.stages = state.stages;
        let beside = torques.stages[0] - other.torques(&like).stages[0];
        other.set_deflection(&mut like, 0, joint.deflection_rad(&state, 0) + spring(beside));
        other.refresh(&mut like);
        let found = other.torques(&like);
        assert!(beside.abs() > 1e-4, "{beside}");
        assert!((found.stages[0] / torques.stages[0] - 1.0).abs() < 1e-9);
        let [one, two] = [torques, found].map(|torques| torques.stage_friction[0]);
        assert!((one / two - 1.0).abs() < 1e-9, "{one} {two}");
    }

    #[test]
    fn friction_that_follows_an_angle_follows_that_of_its_own_shaft() {
        let location = Location::Stage(2);
        let course = EffectParameters::example(Kind::PositionDependentFriction);
        let (joint, state) = moving(&[EffectParameters { location, ..course }]);
        let told = |turned: f64, wound: f64| {
            let mut state = state;
            state.angle = state.angle.ahead(turned / TAU);
            let wound = wound + joint.deflection_rad(&state, 0);
            joint.set_deflection(&mut state, 0, wound);
            joint.refresh(&mut state);
            joint.torques(&state).stage_friction[1]
        };
        // The output is turned by neither, by a ninth of 3 rad, and by both, which take each other away.
        let [plain, turned, both] = [told(0.0, 0.0), told(3.0, 0.0), told(3.0, 3.0)];
        assert!((both / plain - 1.0).abs() < 1e-9 && (turned / plain - 1.0).abs() > 1e-3);
    }
}
