//! Where a friction law that is another than the model's shows: where a mass that rubs stands still or turns round.

use joint_core::params::Friction;
use joint_core::per_unit::Bases;
use joint_simulation::model::Model;

/// How a mass feels a noise of the reversal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reversal {
    /// Share of the noise's variance that it feels where it stands still.
    share: f64,
    /// Speed at which its friction falls, reflected to the motor, rad/s.
    slow: f64,
}

impl Reversal {
    /// On the rotor and on the last mass, as their breakaway torques are.
    pub(super) fn of(model: &Model, inertia: &[f64]) -> [Self; 2] {
        let bases = Bases::si(&model.motor, &model.stages);
        let last = match (model.stages.last(), inertia.last()) {
            (Some(stage), Some(inertia)) if *inertia > 0.0 => Some(&stage.friction),
            _ => None,
        };
        let shaft = bases.shaft(model.stages.len()).abs();
        let rotor = model.motor.friction.breakaway_nm();
        let behind = last.map_or(0.0, |friction| friction.breakaway_nm() * shaft);
        let [rotor, behind] = match rotor + behind > 0.0 {
            true => [rotor / (rotor + behind), behind / (rotor + behind)],
            false => [1.0, 0.0],
        };
        let slow = |friction: &Friction, shaft| friction.stribeck_velocity_rad_per_s / shaft;
        [
            Self { share: rotor * rotor, slow: slow(&model.motor.friction, 1.0) },
            Self { share: behind * behind, slow: last.map_or(1.0, |own| slow(own, shaft)) },
        ]
    }

    /// Share of the variance at a speed.
    pub(super) fn felt(self, speed: f64) -> f64 {
        match self.share > 0.0 {
            true => self.share / (1.0 + (speed / self.slow).powi(2)),
            false => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use joint_simulation::demo::actuator;
    use joint_simulation::plant::inertias;

    fn shares(model: &Model, speeds: [f64; 2]) -> [f64; 2] {
        let [rotor, last] = Reversal::of(model, &inertias(model));
        [rotor.felt(speeds[0]).sqrt(), last.felt(speeds[1]).sqrt()]
    }

    #[test]
    fn each_mass_feels_it_by_its_breakaway_torque_and_at_its_own_speed() {
        let model = actuator();
        let [rotor, last] = shares(&model, [0.0, 0.0]);
        let stage = &model.stages[0];
        let behind = stage.friction.breakaway_nm() / stage.reduction;
        let share = behind / (behind + model.motor.friction.breakaway_nm());
        assert!((last - share).abs() < 1e-12 && (rotor - (1.0 - share)).abs() < 1e-12);
        let slow = model.motor.friction.stribeck_velocity_rad_per_s;
        let [moving, still] = shares(&model, [slow, 0.0]);
        assert!((moving / rotor - 0.5_f64.sqrt()).abs() < 1e-12 && still == last);
    }

    #[test]
    fn the_rotor_feels_all_of_it_where_nothing_rubs_behind_it() {
        let mut model = actuator();
        model.stages[0].friction = Friction::default();
        assert_eq!(shares(&model, [0.0, 0.0]), [1.0, 0.0]);
        model.stages.clear();
        assert_eq!(shares(&model, [0.0, 0.0]), [1.0, 0.0]);
    }
}
