//! Whether equation (1) keeps the low and middle frequencies of the full model.
//!
//! Two full stages in a row, the rotor on the first sun and the link behind the second carrier, against
//! three turning masses with two springs. The masses of (1) are what turns between the springs. What (1) leaves out depends on where a real gear is soft, which
//! the paper does not say; so both ends are compared: soft shafts behind stiff stages, and stages whose
//! meshes and bearings alone are as soft as the joint's springs.

use nalgebra::{DMatrix, DVector};

use super::gear::{CARRIER, Gear, PER_BODY, SPIN, SUN};
use super::modes::eigen;
use crate::model::Model;
use joint_core::params::Stage;

/// Where the compliance of a stage sits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Soft {
    /// In the shaft behind its carrier, as far as its meshes and bearings leave it.
    Shafts,
    /// In meshes and bearings, scaled until their static stiffness is the joint's.
    Meshes,
}

/// The comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Reduction {
    /// Natural frequencies of (1), Hz, low and middle.
    pub reduced_hz: [f64; 2],
    /// The two lowest frequencies of the full chain in which it turns, Hz.
    pub full_hz: [f64; 2],
    /// The next frequency of the full chain, Hz: what (1) leaves out begins here.
    pub next_hz: f64,
    /// Degrees of freedom of the full chain.
    pub freedoms: usize,
}

impl Reduction {
    /// Largest relative error of the two frequencies.
    pub fn error(&self) -> f64 {
        let pairs = self.reduced_hz.iter().zip(&self.full_hz);
        pairs.map(|(reduced, full)| (reduced / full - 1.0).abs()).fold(0.0, f64::max)
    }
}

/// Stiffness of a stage seen from its carrier with the sun held, Nm/rad.
pub(super) fn static_stiffness(gear: &Gear) -> f64 {
    let sun = PER_BODY * SUN + SPIN;
    let held = gear.stiffness().remove_row(sun).remove_column(sun);
    let mut torque = DVector::zeros(held.nrows());
    // The carrier stands behind the sun, so its row has moved up by one.
    let carrier = PER_BODY * CARRIER + SPIN - 1;
    torque[carrier] = 1.0;
    match held.cholesky() {
        Some(factors) => 1.0 / factors.solve(&torque)[carrier],
        None => 0.0,
    }
}

/// Inertia that turns with the carrier: itself and the planets, moving round and spinning.
fn rigid_inertia(gear: &Gear) -> f64 {
    let distance = gear.sun_radius_m + gear.planet_radius_m;
    // Against the held ring a planet spins by its radii.
    let spin = 1.0 - (distance + gear.planet_radius_m) / gear.planet_radius_m;
    let planet = gear.planet.mass_kg * distance * distance + gear.planet.spin_kg_m2 * spin * spin;
    gear.carrier.spin_kg_m2 + gear.planets as f64 * planet
}

/// Compares the full chain with the reduction, for a joint of two stages: static stiffness and
/// inertia of each stage are the joint's.
///
/// `None` where the joint has other than two stages, or stages stiffer than the gear's meshes.
pub fn reduction(gear: &Gear, model: &Model, soft: Soft) -> Option<Reduction> {
    let [one, two] = model.stages.as_slice() else { return None };
    let base = static_stiffness(gear);
    let full = |stage: &Stage| match soft {
        Soft::Meshes => (gear.clone().stiffened(stage.stiffness_nm_per_rad / base), None),
        Soft::Shafts => {
            let compliance = 1.0 / stage.stiffness_nm_per_rad - 1.0 / base;
            (gear.clone(), Some(1.0 / compliance))
        }
    };
    let ((mut first, shaft_one), (second, shaft_two)) = (full(one), full(two));
    if [shaft_one, shaft_two].into_iter().flatten().any(|stiffness| stiffness <= 0.0) {
        return None;
    }
    first.sun.spin_kg_m2 += model.motor.rotor_inertia_kg_m2;
    // What the joint has behind its springs beside the gear's own parts there.
    let rest = |stage: &Stage, gear: &Gear| match soft {
        Soft::Shafts => stage.inertia_kg_m2,
        Soft::Meshes => (stage.inertia_kg_m2 - rigid_inertia(gear)).max(0.0),
    };
    let mut chain = Chain::default();
    let input = chain.stage(&first, None);
    let middle = chain.shaft(input + CARRIER_SPIN, shaft_one, rest(one, &first));
    let output = chain.stage(&second, Some(middle));
    let carrier = output + CARRIER_SPIN;
    let link = chain.shaft(carrier, shaft_two, rest(two, &second));
    let turning = [input + SUN_SPIN, input + CARRIER_SPIN, middle, carrier, link];
    let all = chain.modes(&turning);
    // The free turning comes first.
    let through: Vec<usize> = (1..all.len()).filter(|k| all[*k].1 > 0.5).take(2).collect();
    let [low, high] = through.as_slice() else { return None };
    let next = (1..all.len()).find(|k| !through.contains(k))?;
    // (1) has what turns between its springs as one mass.
    let (before, behind) = match soft {
        Soft::Shafts => (1.0, 0.0),
        Soft::Meshes => (0.0, 1.0),
    };
    let carried = |gear: &Gear| before * rigid_inertia(gear) / gear.ratio().powi(2);
    let inertia = [
        first.sun.spin_kg_m2 + carried(&first),
        behind * rigid_inertia(&first)
            + rest(one, &first)
            + second.sun.spin_kg_m2
            + carried(&second),
        behind * rigid_inertia(&second) + rest(two, &second),
    ];
    let springs = [(one, &first), (two, &second)].map(|(k, g)| (k.stiffness_nm_per_rad, g.ratio()));
    Some(Reduction {
        reduced_hz: three_masses(inertia, springs),
        full_hz: [all[*low].0, all[*high].0],
        next_hz: all[next].0,
        freedoms: all.len(),
    })
}

const SUN_SPIN: usize = PER_BODY * SUN + SPIN;
const CARRIER_SPIN: usize = PER_BODY * CARRIER + SPIN;

/// Natural frequencies of equation (1), Hz; springs with the ratio before each.
fn three_masses(inertia: [f64; 3], springs: [(f64, f64); 2]) -> [f64; 2] {
    let mut stiffness = DMatrix::zeros(3, 3);
    for (stage, (k, ratio)) in springs.into_iter().enumerate() {
        let mut along = DVector::zeros(3);
        along[stage] = 1.0 / ratio;
        along[stage + 1] = -1.0;
        stiffness.ger(k, &along, &along, 1.0);
    }
    let all = eigen(&inertia, &stiffness);
    [all[1].0, all[2].0]
}

/// Full stages and shafts in a row.
#[derive(Default)]
struct Chain {
    inertia: Vec<f64>,
    /// Entries of the stiffness matrix; those at one place add up.
    stiffness: Vec<(usize, usize, f64)>,
}

impl Chain {
    /// Adds a stage whose sun turns as one with a freedom that is there already, or freely. Where its
    /// first freedom stands, were the sun's turning among its own.
    fn stage(&mut self, gear: &Gear, sun: Option<usize>) -> usize {
        let start = self.inertia.len();
        let (inertia, stiffness) = (gear.inertia(), gear.stiffness());
        // The sun's turning keeps a place of its own in the numbering; a shared one stays without
        // inertia and stiffness there and is dropped with the modes.
        let place = |row: usize| match sun {
            Some(shared) if row == SUN_SPIN => shared,
            _ => start + row,
        };
        self.inertia.resize(start + gear.len(), 0.0);
        for row in 0..gear.len() {
            self.inertia[place(row)] += inertia[row];
            for column in 0..gear.len() {
                self.stiffness.push((place(row), place(column), stiffness[(row, column)]));
            }
        }
        start
    }

    /// Adds a shaft behind a freedom and what turns at its end; a rigid one adds inertia only.
    fn shaft(&mut self, behind: usize, stiffness: Option<f64>, inertia: f64) -> usize {
        let Some(k) = stiffness else {
            self.inertia[behind] += inertia;
            return behind;
        };
        let end = self.inertia.len();
        self.inertia.push(inertia);
        for (row, column, k) in
            [(behind, behind, k), (end, end, k), (behind, end, -k), (end, behind, -k)]
        {
            self.stiffness.push((row, column, k));
        }
        end
    }

    /// Frequency in Hz of every mode, lowest first, and the share of its energy in these freedoms.
    fn modes(&self, turning: &[usize]) -> Vec<(f64, f64)> {
        let there: Vec<usize> =
            (0..self.inertia.len()).filter(|row| self.inertia[*row] > 0.0).collect();
        let at = |row: usize| there.binary_search(&row).ok();
        let mut stiffness = DMatrix::zeros(there.len(), there.len());
        for (row, column, k) in &self.stiffness {
            if let (Some(row), Some(column)) = (at(*row), at(*column)) {
                stiffness[(row, column)] += k;
            }
        }
        let inertia: Vec<f64> = there.iter().map(|row| self.inertia[*row]).collect();
        let mut turning: Vec<usize> = turning.iter().filter_map(|row| at(*row)).collect();
        turning.dedup();
        let share = |shape: &[f64]| turning.iter().map(|row| shape[*row].powi(2)).sum();
        eigen(&inertia, &stiffness).into_iter().map(|(hz, shape)| (hz, share(&shape))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_static_stiffness_grows_with_every_part() {
        let gear = Gear::micro();
        let base = static_stiffness(&gear);
        assert!((static_stiffness(&gear.clone().stiffened(3.0)) - 3.0 * base).abs() < 1e-6 * base);
        let softer = Gear { sun_mesh_n_per_m: 0.5 * gear.sun_mesh_n_per_m, ..gear };
        assert!(static_stiffness(&softer) < base);
    }

    #[test]
    fn equation_1_keeps_the_low_and_middle_frequencies_of_soft_shafts() {
        let found = reduction(&Gear::micro(), &crate::scenario::paper(), Soft::Shafts).unwrap();
        assert_eq!(found.freedoms, 85);
        assert!(found.error() < 0.01, "{found:?}");
        assert!(found.next_hz > 5.0 * found.full_hz[1], "{found:?}");
    }

    #[test]
    fn where_the_meshes_are_soft_it_keeps_the_low_one() {
        let found = reduction(&Gear::micro(), &crate::scenario::paper(), Soft::Meshes).unwrap();
        assert_eq!(found.freedoms, 83);
        assert!((found.reduced_hz[0] / found.full_hz[0] - 1.0).abs() < 0.02, "{found:?}");
        // The gear's own modes then begin below the middle frequency.
        assert!(found.next_hz < found.full_hz[1], "{found:?}");
    }
}
