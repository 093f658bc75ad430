//! Whether a derivative is believed: no small step of a state, or of the drive, gains a hundredfold in an
//! interval.
//!
//! Springs and friction add no energy; friction that falls with speed lets a step grow a little. A stepped joint may jump
//! all the same: where friction's solution ends, the next one is another, and a difference over that jump is no derivative.
//! A filter that takes it for one forgets all that it knew.

use joint_core::joint::Drive;
use joint_core::params::Friction;
use joint_core::per_unit::Bases;
use joint_simulation::model::Model;
use joint_simulation::plant::Layout;

/// Most times the amplitude of a step that speeds gain in an interval: friction that falls with speed makes tens of it where
/// samples are long, a jump thousands.
const MOST_GAIN: f64 = 100.0;

/// How much energy is in a joint's state.
#[derive(Clone, Debug)]
pub(super) struct Energy {
    layout: Layout,
    /// By number of the state, the drive last: twice the energy of a unit of it, and what that grows by with its square,
    /// J; zero where it has none.
    units: Vec<[f64; 2]>,
}

impl Energy {
    /// In a joint with masses of these inertias. What drives it counts by the speed that it gives the rotor in an interval.
    pub(super) fn of(model: &Model, drive: Drive, inertia: &[f64], interval: f64) -> Self {
        let layout = Layout::of(model);
        let bases = Bases::si(&model.motor, &model.stages);
        let bent = |own: &Friction| own.breakaway_nm().powi(2) / own.sigma0_nm_per_rad;
        let mut units = vec![[0.0; 2]; layout.len() + 1];
        let driven = |torque: f64| (torque * interval).powi(2) / inertia[0];
        let per_ampere = model.motor.torque_constant_nm_per_a;
        let per_drive = match drive {
            Drive::Voltage => per_ampere / model.motor.phase_resistance_ohm,
            Drive::Current => per_ampere,
        };
        units[Layout::CURRENT][0] = driven(per_ampere);
        units[layout.len()][0] = driven(per_drive);
        for (k, stage) in model.stages.iter().enumerate() {
            let square = bases.shaft(k + 1).powi(2);
            let cubic = stage.cubic_stiffness_nm_per_rad3 * square * square;
            units[layout.deflection(k)] = [stage.stiffness_nm_per_rad * square, 3.0 * cubic];
        }
        let frictions = model.stages.iter().map(|stage| &stage.friction);
        let frictions = std::iter::once(&model.motor.friction).chain(frictions);
        for (mass, (inertia, friction)) in inertia.iter().zip(frictions).enumerate() {
            units[layout.speed(mass)][0] = *inertia;
            units[layout.bristle(mass)][0] = bent(friction);
        }
        Self { layout, units }
    }

    /// The numbers of a state, and the drive's, whose steps gain more than is believed, by the derivatives of the next
    /// state.
    pub(super) fn unbelieved<'a>(
        &'a self,
        x: &'a [f64],
        derivatives: (&'a [f64], &'a [f64]),
    ) -> impl Iterator<Item = usize> + 'a {
        let most = MOST_GAIN * MOST_GAIN;
        (0..self.units.len()).filter(move |number| {
            let [own, growing] = self.units[*number];
            let square = x.get(*number).map_or(0.0, |x| x * x);
            let gained = self.gained(*number, derivatives);
            own > 0.0 && (gained.is_nan() || gained > most * (own + growing * square))
        })
    }

    /// Twice the energy that a unit of a number gives to the speeds, J.
    pub(super) fn gained(&self, number: usize, (by_state, by_drive): (&[f64], &[f64])) -> f64 {
        let n = self.layout.len();
        let gained = |mass: usize| {
            let speed = self.layout.speed(mass);
            let [inertia, _] = self.units[speed];
            let change = if number == n { by_drive[speed] } else { by_state[speed * n + number] };
            inertia * change.powi(2)
        };
        (0..=self.layout.stages).map(gained).sum()
    }
}
