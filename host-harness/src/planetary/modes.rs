//! Natural modes of a stage, and which of the three kinds each is.

use nalgebra::{DMatrix, SymmetricEigen};

use super::gear::{CARRIER, Gear, PER_BODY, SPIN};

/// What moves in a mode of a stage with evenly spaced planets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModeKind {
    /// Sun, ring and carrier turn and move along their axis; all planets alike.
    RotationalAxial,
    /// Sun, ring and carrier move across their axis and tilt; every frequency twice.
    TranslationalTilting,
    /// Only planets move; every frequency p − 3 times.
    Planet,
    /// None of them: the planets are not alike, or two kinds share a frequency.
    Mixed,
}

/// One mode.
#[derive(Clone, Debug, PartialEq)]
pub struct Mode {
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// What moves.
    pub kind: ModeKind,
    /// Share of the energy in turning about the axis, of the sun and the carrier.
    pub turning: f64,
}

/// Frequencies and mass-weighted shapes of `M q̈ + K q = 0`, lowest first.
pub(super) fn eigen(inertia: &[f64], stiffness: &DMatrix<f64>) -> Vec<(f64, Vec<f64>)> {
    let scaled = DMatrix::from_fn(inertia.len(), inertia.len(), |row, column| {
        stiffness[(row, column)] / (inertia[row] * inertia[column]).sqrt()
    });
    let eigen = SymmetricEigen::new(scaled);
    let shapes = eigen.eigenvectors.column_iter();
    let mut all: Vec<(f64, Vec<f64>)> = eigen
        .eigenvalues
        .iter()
        .zip(shapes)
        .map(|(value, shape)| {
            (value.max(0.0).sqrt() / std::f64::consts::TAU, shape.iter().copied().collect())
        })
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all
}

/// The modes of a stage, lowest first.
pub fn modes(gear: &Gear) -> Vec<Mode> {
    let all = eigen(gear.inertia().as_slice(), &gear.stiffness());
    all.into_iter().map(|(frequency_hz, shape)| classified(frequency_hz, &shape)).collect()
}

fn classified(frequency_hz: f64, shape: &[f64]) -> Mode {
    // Less energy than this is rounding.
    const NOTHING: f64 = 1e-9;
    let central = &shape[..PER_BODY * (CARRIER + 1)];
    let share = |freedoms: &[usize]| {
        let rows = central.iter().enumerate();
        let own = rows.filter(|(row, _)| freedoms.contains(&(row % PER_BODY)));
        own.map(|(_, value)| value * value).sum::<f64>()
    };
    let (axial, across) = (share(&[2, SPIN]), share(&[0, 1, 3, 4]));
    let kind = match (axial > NOTHING, across > NOTHING) {
        (true, false) => ModeKind::RotationalAxial,
        (false, true) => ModeKind::TranslationalTilting,
        (false, false) => ModeKind::Planet,
        (true, true) => ModeKind::Mixed,
    };
    let spin = |body: usize| shape[PER_BODY * body + SPIN].powi(2);
    Mode { frequency_hz, kind, turning: spin(0) + spin(CARRIER) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(all: &[Mode], kind: ModeKind) -> usize {
        all.iter().filter(|mode| mode.kind == kind).count()
    }

    #[test]
    fn the_modes_fall_into_the_three_kinds_of_the_citation() {
        for planets in [3, 4, 5] {
            let all = modes(&Gear { planets, ..Gear::micro() });
            assert_eq!(all.len(), 6 * (3 + planets));
            assert_eq!(count(&all, ModeKind::RotationalAxial), 12, "{planets} planets");
            assert_eq!(count(&all, ModeKind::TranslationalTilting), 24, "{planets} planets");
            assert_eq!(count(&all, ModeKind::Planet), 6 * (planets - 3), "{planets} planets");
        }
    }

    #[test]
    fn frequencies_come_in_the_multiplicities_of_their_kind() {
        let all = modes(&Gear { planets: 5, ..Gear::micro() });
        for kind in [ModeKind::TranslationalTilting, ModeKind::Planet] {
            let own: Vec<f64> =
                all.iter().filter(|mode| mode.kind == kind).map(|mode| mode.frequency_hz).collect();
            for pair in own.chunks(2) {
                assert!((pair[0] - pair[1]).abs() < 1e-6 * pair[1], "{kind:?}: {own:?}");
            }
        }
    }

    #[test]
    fn only_turning_through_in_the_gear_s_ratio_is_free() {
        let gear = Gear::micro();
        let all = modes(&gear);
        assert!(all[0].frequency_hz < 1e-3 * all[1].frequency_hz, "{:?}", &all[..2]);
        let (_, shape) = &eigen(gear.inertia().as_slice(), &gear.stiffness())[0];
        let turned = |body: usize, spin: f64| shape[PER_BODY * body + SPIN] / spin.sqrt();
        let ratio = turned(0, gear.sun.spin_kg_m2) / turned(CARRIER, gear.carrier.spin_kg_m2);
        assert!((ratio - gear.ratio()).abs() < 1e-3 * gear.ratio(), "{ratio}");
    }
}
