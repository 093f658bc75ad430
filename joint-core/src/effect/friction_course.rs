//! Friction's course along the travel, of each direction its own: a screw that is worn where it works
//! most, a guide that is tight at one end.
//!
//! The LuGre level becomes `g(v) (1 + s c(q))` with c a table of up to 16 knots in each direction and
//! straight lines between them, over a span of the mass's own angle, beyond whose ends it holds on, or
//! periodic; s is `scale`. The sign of the speed chooses the table. At standstill the level may jump, the
//! friction does not: the bristle moves on from where it is. A level stays above a twentieth. Source: the
//! friction maps of robot joints, Bittencourt and Gunnarsson, "Static friction in a robot joint" (2012);
//! Popović and Goldenberg, "Modeling of friction using spectral analysis" (1998), maps by direction.

use super::hooks::{Effects, Rubbing};
use super::table::{Course, Knots, TableSpec, Tables, table};
use super::{ParameterSpec, Place, Spec};
use crate::batch::batch;
use crate::params::{Check, Location, ParameterError, Reason};
use crate::scalar::Scalar;

const SCALE: usize = 0;
const START: usize = 1;
const SPAN: usize = 2;
const PERIOD: usize = 3;

/// What is left of a level at least, of one.
const LEAST: f64 = 0.05;

/// Name, places and parameters. Just one of span and period is above zero.
pub const SPEC: Spec = Spec {
    kind: "friction-course",
    locations: &[Location::Motor, Location::Stage(0), Location::Output],
    parameters: &[
        ParameterSpec { key: "scale", default: Some(1.0), low: -10.0, high: 10.0 },
        // Angle of the first knot.
        ParameterSpec { key: "start_rad", default: Some(0.0), low: -1e6, high: 1e6 },
        // From the first knot to the last.
        ParameterSpec { key: "span_rad", default: Some(0.0), low: 0.0, high: 1e6 },
        // From the first knot to where it comes again.
        ParameterSpec { key: "period_rad", default: Some(0.0), low: 0.0, high: 1e4 },
    ],
    example: (Location::Output, &[("period_rad", 0.2)]),
    table: Some(TableSpec {
        forward: "relative",
        backward: "backward_relative",
        most: 16,
        low: -0.95,
        high: 20.0,
        example: [&[0.5, -0.3, 0.8, 0.0], &[-0.2, 0.9, 0.1, 0.3]],
    }),
    remembers: false,
};

fn over(values: &[f64]) -> Option<(bool, f64)> {
    let length = |k: usize| values.get(k).copied().unwrap_or(0.0);
    match [length(SPAN) > 0.0, length(PERIOD) > 0.0] {
        [true, false] => Some((false, length(SPAN))),
        [false, true] => Some((true, length(PERIOD))),
        _ => None,
    }
}

/// Checks what one value alone does not say.
pub(super) fn validate(values: &[f64], knots: &Knots, check: &Check) -> Result<(), ParameterError> {
    if over(values).is_none() {
        return Err(check.fail("period_rad", 0.0, Reason::NotOneOf));
    }
    let scale = values.get(SCALE).copied().unwrap_or(0.0);
    let lowest = knots.all().map(|knot| scale * knot).fold(0.0, f64::min);
    if lowest < LEAST - 1.0 {
        let reason = Reason::OutOfRange { low: (LEAST - 1.0) / lowest, high: 1.0 };
        return Err(check.fail("scale", scale, reason));
    }
    Ok(())
}

/// Whether the curve ends where it begins.
pub(super) fn is_periodic(values: &[f64]) -> bool {
    over(values).is_some_and(|(periodic, _)| periodic)
}

/// The law for one mass.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct FrictionCourse<S: Scalar> {
    mass: u8,
    /// Number of its table.
    table: u8,
    /// Whether the mass turns against the motor.
    reversed: bool,
    course: Course<S>,
    scale: S::Gain,
}

batch!(FrictionCourse<Scalar>: course, scale; mass, table, reversed);

impl<S: Scalar> FrictionCourse<S> {
    /// The law of an effect at its place.
    pub(super) fn at(place: &Place<'_>) -> Option<Self> {
        let value = |k: usize| place.values.get(k).copied().unwrap_or(0.0);
        let (periodic, length) = over(place.values)?;
        Some(Self {
            mass: place.mass,
            table: place.table,
            reversed: place.shaft < 0.0,
            course: Course::new(value(START), length, periodic, place.shaft),
            scale: S::gain(value(SCALE) * place.knots.largest()),
        })
    }
}

impl<S: Scalar> Effects<S> for FrictionCourse<S> {
    fn has_levels(&self) -> bool {
        true
    }

    fn has_level(&self, mass: usize) -> bool {
        mass == usize::from(self.mass)
    }

    fn has_angled_levels(&self) -> bool {
        true
    }

    #[inline(always)]
    fn inverse_level_from(&self, tables: &Tables<S>, mass: usize, at: Rubbing<S>) -> S {
        let Some(table) = table(tables, self.table) else { return S::ONE };
        if mass != usize::from(self.mass) {
            return S::ONE;
        }
        let [[mut forward, _], [mut backward, _]] = table.at(self.course.part(at.angle));
        if self.reversed {
            (forward, backward) = (backward, forward);
        }
        let relative = S::choose(at.speed.below(S::ZERO), backward, forward);
        let level = S::ONE + relative.times(self.scale);
        let least = S::from_f64(LEAST);
        // A twentieth is well within what fixed point divides by.
        S::ONE.over(S::choose(least.below(level), level, least))
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::Table;
    use super::super::{EffectParameters, Kind};
    use super::*;
    use crate::angle::Angle;
    use crate::params::{Motor, Stage};
    use crate::per_unit::Bases;
    use core::f64::consts::TAU;

    #[test]
    fn the_level_follows_the_angle_by_the_table_of_its_direction() {
        for ratio in [5.0, -5.0] {
            let course = EffectParameters::new(Kind::FrictionCourse, Location::Stage(1))
                .with_table(&[0.0, 1.0, -0.5], &[2.0, 0.0, 0.0])
                .unwrap()
                .with("start_rad", -1.0)
                .with("span_rad", 8.0)
                .with("scale", 0.5);
            assert_eq!(course.validate(1), Ok(()));
            let stages = [Stage { reduction: ratio, ..Stage::default() }];
            let motor = Motor { torque_constant_nm_per_a: 1.0, ..Motor::default() };
            let bases = Bases::si(&motor, &stages);
            let place = Place::of(&course, &bases, [0, 0]).unwrap();
            let law = FrictionCourse::<f64>::at(&place).unwrap();
            let mut tables = Tables::new();
            assert!(tables.push(Table::new(&course.table, false)).is_ok());
            let level = |angle: f64, speed: f64| {
                let angle = Angle::from_turns(angle * ratio / TAU);
                let at = Rubbing { speed: speed * ratio, transmitted: 0.0, passed_on: 0.0, angle };
                assert_eq!(law.inverse_level_from(&tables, 0, at), 1.0);
                1.0 / law.inverse_level_from(&tables, 1, at)
            };
            for (angle, forward, backward) in
                [(-30.0, 1.0, 2.0), (-1.0, 1.0, 2.0), (1.0, 1.25, 1.5), (5.0, 1.125, 1.0)]
            {
                assert!((level(angle, 0.3) - forward).abs() < 1e-9, "{ratio} {angle} forward");
                assert!((level(angle, -0.3) - backward).abs() < 1e-9, "{ratio} {angle} backward");
            }
        }
    }

    #[test]
    fn a_level_that_would_vanish_is_refused_and_more_than_sixteen_knots() {
        let course = |knots: &[f64]| {
            EffectParameters::new(Kind::FrictionCourse, Location::Motor)
                .with_table(knots, &[])
                .unwrap()
                .with("period_rad", 1.0)
        };
        let key = |course: EffectParameters| course.validate(1).map_err(|error| error.key);
        assert_eq!(key(course(&[-0.5, 0.5])), Ok(()));
        assert_eq!(key(course(&[-0.5, 0.5]).with("scale", -2.0)), Err("scale"));
        assert_eq!(key(course(&[-0.96, 0.5])), Err("relative"));
        assert_eq!(key(course(&[0.1; 17])), Err("relative"));
        assert_eq!(key(course(&[0.1; 16]).with("period_rad", 0.0)), Err("period_rad"));
    }
}
