//! The joint as a matrix at every sample of a motion, with what the observer carries beside it.

use joint_core::joint::Drive;
use joint_core::observer::winding;
use joint_core::per_unit::Bases;
use nalgebra::{DMatrix, DVector};

use super::twin::Twin;
use crate::estimate::record::CHANNELS;
use crate::grid::Grid;
use crate::model::Model;
use crate::plant::{BuildError, Layout, inertias, output_shaft, plant};

/// Order of the observer's quantities: those of the plant, then load (Nm), its slope (Nm a step),
/// the drive beside the applied one (V or A), and the shares by which resistance (less that of the
/// flux), flux and friction are larger.
#[derive(Clone, Copy, Debug)]
pub struct Order {
    /// The plant's part.
    pub plant: Layout,
}

impl Order {
    /// Number of quantities that are corrected: what effects remember is not.
    pub fn size(self) -> usize {
        self.states() + 6
    }

    /// Quantities of the joint among them.
    pub fn states(self) -> usize {
        4 + 3 * self.plant.stages
    }

    /// The load.
    pub fn load(self) -> usize {
        self.states()
    }

    /// Its slope.
    pub fn slope(self) -> usize {
        self.states() + 1
    }

    /// The missing drive.
    pub fn bias(self) -> usize {
        self.states() + 2
    }

    /// The resistance that the model does not know.
    pub fn ohm(self) -> usize {
        self.states() + 3
    }

    /// The flux that the model does not know.
    pub fn flux(self) -> usize {
        self.states() + 4
    }

    /// The friction that the model does not know.
    pub fn level(self) -> usize {
        self.states() + 5
    }
}

/// Linearisation along a motion.
#[derive(Clone, Debug)]
pub struct Linear {
    /// Which quantity stands where.
    pub order: Order,
    /// By sample: the next state from the present one, drive and load; the slope's leak is not in it.
    pub transition: Vec<DMatrix<f64>>,
    /// What a torque of 1 Nm on the rotor does in a step.
    pub kick: DVector<f64>,
    /// What each channel shows.
    pub shows: DMatrix<f64>,
    /// By sample: current, A, and rotor speed, rad/s.
    pub running: Vec<[f64; 2]>,
    /// By sample: what friction takes of the rotor's speed in a step, rad/s.
    pub deceleration: Vec<f64>,
    /// By sample: whether the rotor is held by its friction.
    pub held: Vec<bool>,
    /// By sample: whether the last spring is hardened.
    pub hardened: Vec<bool>,
}

/// Linearises a model along a motion.
///
/// # Errors
/// The model cannot be built.
pub fn linearise(
    model: &Model,
    kind: Drive,
    step_s: f64,
    twin: &Twin,
    sigma: &[f64; CHANNELS],
) -> Result<Linear, BuildError> {
    let layout = Layout::of(model);
    let order = Order { plant: layout };
    let (n, size) = (order.states(), order.size());
    let samples = twin.states.len();
    let times: Vec<f64> = (0..samples).map(|k| k as f64 * step_s).collect();
    let plant = plant(model, &Grid::new(&times, None), kind)?;
    let steps = steps(layout, twin, sigma);
    let most = |values: &[f64]| values.iter().fold(1e-12_f64, |most, v| most.max(v.abs()));
    let (push, weight) = (1e-4 * most(&twin.drive), 1e-4 * most(&twin.load));
    let mut transition = Vec::with_capacity(samples);
    let mut held = Vec::with_capacity(samples);
    let mut running = Vec::with_capacity(samples);
    let mut deceleration = Vec::with_capacity(samples);
    let decelerations = decelerations(model, step_s);
    let share = winding(&model.motor, step_s);
    let (resistance, constant) =
        (2.0 * model.motor.phase_resistance_ohm, model.motor.torque_constant_nm_per_a);
    let mut hardened = Vec::with_capacity(samples);
    let shaft = output_shaft(model);
    let bend = bend(model) / shaft.abs();
    let mut moved = vec![0.0; layout.len()];
    for k in 0..samples {
        let state = &twin.states[k];
        held.push(is_held(model, state[layout.speed(0)], state[layout.bristle(0)]));
        let last = layout.stages.checked_sub(1);
        hardened.push(last.is_some_and(|stage| state[layout.deflection(stage)].abs() > bend));
        let mut run = |change: &dyn Fn(&mut [f64]), drive: f64, load: f64| -> Vec<f64> {
            moved.copy_from_slice(state);
            change(&mut moved);
            plant.propagate(k, &mut moved, twin.drive[k] + drive, twin.load[k] + load);
            moved[..n].to_vec()
        };
        let base = run(&|_| {}, 0.0, 0.0);
        let mut f = DMatrix::<f64>::identity(size, size);
        let mut fill = |column: usize, after: &[f64], step: f64| {
            for (row, (a, b)) in after.iter().zip(&base).enumerate() {
                f[(row, column)] = (a - b) / step;
            }
        };
        for (j, own) in steps.iter().copied().enumerate() {
            let step = if state[j] < 0.0 { -own } else { own };
            fill(j, &run(&|x| x[j] += step, 0.0, 0.0), step);
        }
        fill(order.load(), &run(&|_| {}, 0.0, weight), weight);
        fill(order.bias(), &run(&|_| {}, push, 0.0), push);
        // The load acts with its slope already added.
        for row in 0..n {
            f[(row, order.slope())] = f[(row, order.load())];
        }
        f[(order.load(), order.slope())] = 1.0;
        let (now, speed) = (state[Layout::CURRENT], state[layout.speed(0)]);
        running.push([now, speed]);
        let mean = match kind {
            Drive::Voltage => {
                let last = (twin.drive[k] - constant * speed) / resistance;
                now + share * (last - now)
            }
            Drive::Current => 0.0,
        };
        for row in 0..n {
            f[(row, order.ohm())] = -resistance * mean * f[(row, order.bias())];
            f[(row, order.flux())] = -constant * speed * f[(row, order.bias())];
        }
        let taken = |mass: usize| {
            let [bristle, viscous] = decelerations[mass];
            state[layout.bristle(mass)] * bristle + state[layout.speed(mass)] * viscous
        };
        for row in 0..n {
            f[(row, order.level())] =
                (0..=layout.stages).map(|mass| -taken(mass) * f[(row, layout.speed(mass))]).sum();
        }
        deceleration.push(taken(0));
        transition.push(f);
    }
    let mut kick = DVector::zeros(size);
    kick[layout.speed(0)] = step_s / inertias(model)[0];
    kick[Layout::ANGLE] = 0.5 * step_s * kick[layout.speed(0)];
    if layout.stages > 0 {
        kick[layout.deflection(0)] = kick[Layout::ANGLE];
    }
    let mut shows = DMatrix::zeros(CHANNELS, size);
    shows[(0, Layout::CURRENT)] = 1.0;
    shows[(1, Layout::ANGLE)] = 1.0;
    shows[(2, Layout::ANGLE)] = shaft;
    for stage in 0..layout.stages {
        shows[(2, layout.deflection(stage))] = -shaft;
    }
    Ok(Linear { order, transition, kick, shows, running, deceleration, held, hardened })
}

/// Small changes of every quantity, of the order of what is known of it.
fn steps(layout: Layout, twin: &Twin, sigma: &[f64; CHANNELS]) -> Vec<f64> {
    let most = |index: usize| twin.states.iter().map(|x| x[index].abs()).fold(1e-9, f64::max);
    let mut steps = vec![0.0; 4 + 3 * layout.stages];
    steps[Layout::CURRENT] = 1e-3 * most(Layout::CURRENT);
    steps[Layout::ANGLE] = 0.1 * sigma[1];
    for stage in 0..layout.stages {
        steps[layout.deflection(stage)] = 1e-4 * most(layout.deflection(stage));
    }
    for mass in 0..=layout.stages {
        steps[layout.speed(mass)] = 1e-5 * most(layout.speed(0));
        steps[layout.bristle(mass)] = 1e-3;
    }
    steps
}

/// Whether the rotor's bristle takes more than half of its motion.
fn is_held(model: &Model, speed: f64, zeta: f64) -> bool {
    let friction = &model.motor.friction;
    if friction.coulomb_nm <= 0.0 {
        return false;
    }
    let bell = (-(speed / friction.stribeck_velocity_rad_per_s).powi(2)).exp();
    let level = 1.0 + friction.stribeck_nm / friction.coulomb_nm * bell;
    1.0 - speed.signum() * zeta / level > 0.5
}

/// What friction takes of every mass's speed in a step: for a bristle at its Coulomb level, rad/s at
/// the motor, and for its viscous part, as a share of the speed.
///
/// It is taken at once, so that a bristle that is too stiff for that is felt at the rotor.
pub fn decelerations(model: &Model, step_s: f64) -> Vec<[f64; 2]> {
    let bases = Bases::si(&model.motor, &model.stages);
    let inertias = inertias(model);
    let mut decelerations = vec![[0.0; 2]; inertias.len()];
    for (mass, own) in inertias.iter().enumerate() {
        let friction = match mass.checked_sub(1) {
            None => &model.motor.friction,
            Some(stage) => &model.stages[stage].friction,
        };
        let shaft = bases.shaft(mass).abs();
        let stiff = friction.sigma0_nm_per_rad * shaft * shaft * step_s * step_s / own;
        let (at, inertia) = if stiff > MOST_STIFF { (0, inertias[0]) } else { (mass, *own) };
        decelerations[at][0] += friction.coulomb_nm * shaft * step_s / inertia;
        decelerations[mass][1] += friction.sigma2_nm_s_per_rad * shaft * shaft * step_s / own;
    }
    decelerations
}

/// Largest σ0 h²/J of a bristle a third of whose torque acts on its own mass all at once.
const MOST_STIFF: f64 = 4.0;

/// From where on the last spring is hardened, rad: its tangent is a quarter stiffer than at rest.
pub fn bend(model: &Model) -> f64 {
    match model.stages.last() {
        Some(stage) if stage.cubic_stiffness_nm_per_rad3 > 0.0 => {
            (0.25 / 3.0 * stage.stiffness_nm_per_rad / stage.cubic_stiffness_nm_per_rad3).sqrt()
        }
        _ => f64::INFINITY,
    }
}
