//! A torque that follows an angle or a speed, and has no name.
//!
//! What is left of a disturbance when every named law is in, and still repeats: a table `T(x)` of up to
//! 64 knots with straight lines between them. Over an angle x is the mass's own, over a span beyond
//! whose ends they hold on, or periodic; over a speed x is its magnitude, and the torque is odd. Each
//! direction of motion may have a curve of its own: `T = ½(T₊ + T₋) + ½(T₊ − T₋) s`, where
//! `s = v/v_b` within ±1, and the odd map has `T₋ = −T₊`. The blend v_b keeps a torque continuous whose
//! directions differ at standstill. All is times `scale`.
//!
//! It is a stand-in: it says what the torque is, not why, and holds where it was measured. Unlike
//! friction of a course it may give power. Source: lookup tables of disturbance torque, as compensation
//! of cogging has them, for example Piccoli and Yim, "Anticogging: torque ripple suppression, modeling,
//! and parameter selection" (2016).

use super::hooks::{Effects, Memory, Motion, Torque};
use super::table::{Course, Knots, MAX_KNOTS, TableSpec, Tables, table, unit};
use super::{ParameterSpec, Place, Spec};
use crate::batch::batch;
use crate::params::{Check, Location, ParameterError, Reason};
use crate::scalar::Scalar;

const SCALE: usize = 0;
const START: usize = 1;
const SPAN: usize = 2;
const PERIOD: usize = 3;
const SPEED: usize = 4;
const BLEND: usize = 5;

/// Name, places and parameters. Just one of span, period and speed is above zero: that is what the knots
/// are over.
pub const SPEC: Spec = Spec {
    kind: "torque-map",
    locations: &[Location::Motor, Location::Output],
    parameters: &[
        ParameterSpec { key: "scale", default: Some(1.0), low: -1e3, high: 1e3 },
        // Angle of the first knot.
        ParameterSpec { key: "start_rad", default: Some(0.0), low: -1e6, high: 1e6 },
        // From the first knot to the last, of an angle.
        ParameterSpec { key: "span_rad", default: Some(0.0), low: 0.0, high: 1e6 },
        // From the first knot to where it comes again.
        ParameterSpec { key: "period_rad", default: Some(0.0), low: 0.0, high: 1e4 },
        // From standstill, the first knot, to the last one.
        ParameterSpec { key: "speed_rad_per_s", default: Some(0.0), low: 0.0, high: 1e9 },
        // v_b.
        ParameterSpec { key: "blend_rad_per_s", default: Some(0.0), low: 0.0, high: 1e9 },
    ],
    example: (
        Location::Motor,
        &[("period_rad", core::f64::consts::TAU), ("blend_rad_per_s", 60.0)],
    ),
    table: Some(TableSpec {
        forward: "torque_nm",
        backward: "backward_torque_nm",
        most: MAX_KNOTS,
        low: -1e9,
        high: 1e9,
        example: [
            &[0.0, 3e-6, 1e-6, -2e-6, 2e-6, -4e-6, 1e-6, 2e-6],
            &[1e-6, 2e-6, 0.0, -2e-6, 3e-6, -3e-6, -1e-6, 1e-6],
        ],
    }),
    remembers: false,
};

/// What the knots are over, and how far apart the first and the last are; `None` where the values name
/// none, or more than one.
fn over(values: &[f64]) -> Option<(usize, f64)> {
    let mut named = [SPAN, PERIOD, SPEED]
        .into_iter()
        .filter_map(|which| Some((which, *values.get(which)?)))
        .filter(|(_, length)| *length > 0.0);
    named.next().filter(|_| named.next().is_none())
}

/// Checks what one value alone does not say.
pub(super) fn validate(values: &[f64], knots: &Knots, check: &Check) -> Result<(), ParameterError> {
    let Some((which, _)) = over(values) else {
        return Err(check.fail("period_rad", 0.0, Reason::NotOneOf));
    };
    let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
    let first = |curve: &[f64]| curve.first().copied().unwrap_or(0.0);
    let parted = match which {
        SPEED => first(knots.forward()) != 0.0 || first(knots.backward()) != 0.0,
        _ => knots.apart() > 0.0,
    };
    if parted && value(BLEND) <= 0.0 {
        return Err(check.fail("blend_rad_per_s", value(BLEND), Reason::NotPositive));
    }
    Ok(())
}

/// Whether the curve ends where it begins.
pub(super) fn is_periodic(values: &[f64]) -> bool {
    over(values).is_some_and(|(which, _)| which == PERIOD)
}

/// Steepest change of the torque with the mass's angle, Nm/rad, and with its speed, Nm s/rad.
pub(crate) fn slopes(values: &[f64], knots: &Knots) -> [f64; 2] {
    let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
    let Some((which, length)) = over(values) else { return [0.0; 2] };
    let intervals = knots.forward().len() as f64 - f64::from(u8::from(which != PERIOD));
    let along = libm::fabs(value(SCALE)) * knots.steepest(which == PERIOD) * intervals / length;
    let apart = match (which, knots.backward()) {
        (SPEED, []) => 2.0 * knots.forward().first().map_or(0.0, |first| libm::fabs(*first)),
        _ => knots.apart(),
    };
    // Without a blend the directions meet at standstill.
    let blended = match value(BLEND) {
        blend if blend > 0.0 => 0.5 * libm::fabs(value(SCALE)) * apart / blend,
        _ => 0.0,
    };
    if which == SPEED { [0.0, along + blended] } else { [along, blended] }
}

/// The law for one mass.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct TorqueMap<S: Scalar> {
    mass: u8,
    /// Number of its table.
    table: u8,
    /// Whether it is over the speed, and whether both directions share a curve there with the sign
    /// turned.
    of_speed: bool,
    odd: bool,
    course: Course<S>,
    per_speed: S::Gain,
    per_blend: S::Gain,
    torque: S::Gain,
    slope: S::Gain,
}

batch!(TorqueMap<Scalar>: course, per_speed, per_blend, torque, slope; mass, table, of_speed, odd);

impl<S: Scalar> TorqueMap<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        let value = |k: usize| place.values.get(k).copied().unwrap_or(0.0);
        let (which, length) = over(place.values)?;
        let periodic = which == PERIOD;
        let knots = place.knots.forward().len() as f64;
        let intervals = if periodic { knots } else { knots - 1.0 };
        let torque = value(SCALE) * place.knots.largest() / place.torque;
        // Without a blend the sign of all that moves.
        let per_blend = place.speed / value(BLEND).max(1e-6);
        let slope = if which == SPEED { 0.0 } else { torque * intervals * place.angle / length };
        Some(Self {
            mass: place.mass,
            table: place.table,
            of_speed: which == SPEED,
            odd: which == SPEED && place.knots.backward().is_empty(),
            course: Course::new(value(START), length, periodic, place.shaft),
            per_speed: S::gain(if which == SPEED { place.speed / length } else { 0.0 }),
            per_blend: S::gain(per_blend),
            torque: S::gain(torque),
            slope: S::gain(slope),
        })
    }
}

impl<S: Scalar> Effects<S> for TorqueMap<S> {
    fn has_torque(&self, mass: usize) -> bool {
        mass == usize::from(self.mass)
    }

    #[inline(always)]
    fn torque_from(
        &self,
        tables: &Tables<S>,
        mass: usize,
        at: Motion<S>,
        _memory: &Memory<S>,
    ) -> Torque<S> {
        let Some(table) = table(tables, self.table) else { return Torque::NONE };
        if mass != usize::from(self.mass) {
            return Torque::NONE;
        }
        let part = if self.of_speed {
            unit(at.speed.times(self.per_speed).abs())
        } else {
            self.course.part(at.angle)
        };
        let [forward, mut backward] = table.at(part);
        if self.odd {
            backward = backward.map(|value| -value);
        }
        // From −1 to 1 as from 0 to 1.
        let ahead = unit((at.speed.times(self.per_blend) + S::ONE) * S::HALF);
        let [value, slope] = [0, 1].map(|k: usize| {
            let of = |curve: &[S; 2]| curve.get(k).copied().unwrap_or_default();
            let (there, back) = (of(&forward), of(&backward));
            back + (there - back) * ahead
        });
        Torque { value: value.times(self.torque), slope: slope.times(self.slope) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::hooks::MEMORIES;
    use super::super::table::Table;
    use super::super::{EffectParameters, Kind};
    use super::*;
    use crate::angle::Angle;
    use crate::params::{Motor, Stage};
    use crate::per_unit::Bases;
    use core::f64::consts::TAU;

    const RATIO: f64 = -5.0;

    /// Torque of a map on the output at its own angle and speed, Nm, with its slope.
    fn torque(effect: &EffectParameters) -> impl Fn(f64, f64) -> Torque<f64> + use<> {
        assert_eq!(effect.validate(1), Ok(()));
        let stages = [Stage { reduction: RATIO, ..Stage::default() }];
        let motor = Motor { torque_constant_nm_per_a: 1.0, ..Motor::default() };
        let bases = Bases::si(&motor, &stages);
        let place = Place::of(effect, &bases, [0, 0]).unwrap();
        let law = TorqueMap::<f64>::at(&place).unwrap();
        let periodic = is_periodic(&effect.values);
        let mut tables = Tables::new();
        assert!(tables.push(Table::new(&effect.table, periodic)).is_ok());
        move |angle, speed| {
            let at = Motion { angle: Angle::from_turns(angle * RATIO / TAU), speed: speed * RATIO };
            let reflected = law.torque_from(&tables, 1, at, &[0.0; MEMORIES]);
            Torque { value: reflected.value * RATIO, slope: reflected.slope * RATIO * RATIO }
        }
    }

    fn map(forward: &[f64], backward: &[f64]) -> EffectParameters {
        let map = EffectParameters::new(Kind::TorqueMap, Location::Output);
        map.with_table(forward, backward).unwrap()
    }

    #[test]
    fn over_an_angle_the_torque_is_the_line_between_its_knots_behind_a_gear_that_reverses() {
        let map = map(&[1.0, 3.0, -1.0], &[]).with("start_rad", 10.0).with("span_rad", 4.0);
        let torque = torque(&map.with("scale", 0.5));
        for (angle, value, slope) in
            [(10.0, 0.5, 0.5), (11.0, 1.0, 0.5), (13.0, 0.5, -1.0), (14.0, -0.5, -1.0)]
        {
            for speed in [-3.0, 0.0, 2.0] {
                let found = torque(angle, speed);
                assert!((found.value - value).abs() < 1e-9, "{angle}: {found:?}");
                let steeper = (found.slope - slope).abs() < 1e-9;
                assert!(steeper || angle == 10.0, "{angle}: {found:?}");
            }
        }
        assert!((torque(300.0, 0.0).value + 0.5).abs() < 1e-9);
    }

    #[test]
    fn each_direction_has_its_curve_and_between_them_nothing_jumps() {
        let map = map(&[1.0, 2.0], &[-1.0, 0.0]).with("period_rad", 1.0);
        assert!(map.validate(1).is_err(), "a jump at standstill");
        let torque = torque(&map.with("blend_rad_per_s", 0.2));
        for (speed, value) in [(5.0, 1.5), (0.2, 1.5), (0.1, 1.0), (0.0, 0.5), (-0.2, -0.5)] {
            assert!((torque(0.25, speed).value - value).abs() < 1e-9, "{speed}");
            assert!((torque(7.75, speed).value - value).abs() < 1e-9, "{speed}");
        }
    }

    #[test]
    fn over_the_speed_it_is_odd_unless_each_direction_has_its_own() {
        let odd = torque(&map(&[0.0, -2.0, -1.0], &[]).with("speed_rad_per_s", 10.0));
        for (speed, value) in [(0.0, 0.0), (2.5, -1.0), (5.0, -2.0), (7.5, -1.5), (40.0, -1.0)] {
            assert!((odd(1.0, speed).value - value).abs() < 1e-5, "{speed}");
            assert!((odd(1.0, -speed).value + value).abs() < 1e-5, "{speed}");
        }
        let own = map(&[0.0, -2.0], &[0.0, 1.0]).with("speed_rad_per_s", 10.0);
        let own = torque(&own);
        let found = [own(0.0, 5.0), own(0.0, -5.0)].map(|torque| torque.value);
        assert!((found[0] + 1.0).abs() < 1e-9 && (found[1] - 0.5).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn what_the_knots_are_over_is_asked_for_once() {
        let map = map(&[0.0, 1.0], &[]);
        let key = |map: EffectParameters| map.validate(1).map_err(|error| error.key);
        assert_eq!(key(map), Err("period_rad"));
        assert_eq!(key(map.with("span_rad", 1.0).with("period_rad", 1.0)), Err("period_rad"));
        assert_eq!(key(map.with("span_rad", 1.0)), Ok(()));
        let jump = map.with_table(&[0.5, 1.0], &[]).unwrap().with("speed_rad_per_s", 1.0);
        assert_eq!(key(jump), Err("blend_rad_per_s"));
        let none = EffectParameters::new(Kind::TorqueMap, Location::Motor).with("span_rad", 1.0);
        assert_eq!(key(none), Err("torque_nm"));
    }
}
