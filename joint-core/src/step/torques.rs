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
        let mut torques = Torques {
            motor: unit(state.current * factor),
            motor_friction: unit(self.felt_by(0, &self.rotor, &state.rotor)),
            stages: [S::ZERO; N],
            stage_friction: [S::ZERO; N],
        };
        let (mut wound, mut input, mut before) = (S::ZERO, state.angle, state.rotor.speed);
        let out = torques.stages.iter_mut().zip(&mut torques.stage_friction);
        let own = state.stages.iter().zip(&self.stages).enumerate();
        for ((number, (stage, own)), (torque, friction)) in own.zip(out) {
            let felt = self.felt(number, stage.deflection, input);
            let mut sum = own.spring.torque(felt.deflection);
            if self.effects.has_stage(number) {
                sum = sum + self.effects.stage_torque(number, felt.deflection, &state.memory).value;
            }
            let damped = own.spring.damping_torque(before - stage.mass.speed);
            *torque = unit(sum + damped * felt.contact);
            *friction = unit(self.felt_by(number + 1, &own.friction, &stage.mass));
            wound = wound + stage.deflection;
            input = own.own_angle(state.angle.ahead(-wound.times(self.turns)));
            before = stage.mass.speed;
        }
        torques
    }
}

#[cfg(test)]
mod tests {
    use crate::joint::{Drive, Joint, Settings};
    use crate::params::{Friction, Load, Motor, Stage};

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
}
