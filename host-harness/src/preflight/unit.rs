//! Factors by which a column is off when it has another unit or is counted elsewhere.

use std::f64::consts::TAU;

use crate::model::Model;

/// A mistake of unit or place: a factor that a measured constant is off by, and what it looks like.
pub(super) struct Mistake {
    pub(super) factor: f64,
    pub(super) what: String,
}

fn mistake(factor: f64, what: impl Into<String>) -> Mistake {
    Mistake { factor, what: what.into() }
}

/// The mistakes that multiply a rotor angle, by what they multiply it with.
pub(super) fn angle_mistakes(model: &Model) -> Vec<Mistake> {
    let reduction: f64 = model.stages.iter().map(|stage| stage.reduction).product();
    let mut mistakes = vec![
        mistake(360.0 / TAU, "motor_angle_rad is in degrees, not in radians"),
        mistake(1.0 / TAU, "motor_angle_rad is in turns, not in radians"),
    ];
    if model.motor.pole_pairs > 1 {
        let pairs = f64::from(model.motor.pole_pairs);
        mistakes.push(mistake(
            pairs,
            "motor_angle_rad is the electrical angle, not the mechanical one",
        ));
    }
    if reduction.abs() != 1.0 {
        let what = "motor_angle_rad is the angle behind the gear, not the rotor's";
        mistakes.push(mistake(1.0 / reduction.abs(), what));
    }
    mistakes
}

/// The mistake whose factor is nearest to the measured one, in proportion, if any is nearer than one is and
/// within `within` of it.
pub(super) fn nearest(mistakes: &[Mistake], measured: f64, within: f64) -> Option<&Mistake> {
    let off = |mistake: &&Mistake| (measured / mistake.factor).abs().ln().abs();
    let best = mistakes.iter().min_by(|a, b| off(a).total_cmp(&off(b)))?;
    (off(&best) < measured.abs().ln().abs() && off(&best) < (1.0 + within).ln()).then_some(best)
}

/// A number with as many digits as its error allows, at least two.
pub(super) fn figure(value: f64, error: f64) -> String {
    if !(value.is_finite() && value != 0.0) {
        return format!("{value}");
    }
    let digits = match error > 0.0 {
        true => ((value.abs() / error).log10().ceil() + 1.0).clamp(2.0, 7.0),
        false => 4.0,
    };
    let places = digits - 1.0 - value.abs().log10().floor();
    match value.abs() {
        1e-3..1e6 => format!("{value:.*}", places.max(0.0) as usize),
        _ => format!("{value:.*e}", (digits - 1.0) as usize),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::actuator;

    #[test]
    fn a_factor_is_named_only_where_it_is_nearer_than_none() {
        let mistakes = angle_mistakes(&actuator());
        assert!(nearest(&mistakes, 1.1, 0.15).is_none());
        assert!(nearest(&mistakes, 55.0, 0.15).unwrap().what.contains("degrees"));
        assert!(nearest(&mistakes, 30.0, 0.15).is_none());
    }

    #[test]
    fn a_figure_has_the_digits_of_its_error() {
        assert_eq!(figure(16.00234, 0.01), "16.002");
        assert_eq!(figure(267.4, 30.0), "267");
        assert_eq!(figure(-0.012345, 0.002), "-0.012");
        assert_eq!(figure(1234.5, 500.0), "1234");
    }
}
