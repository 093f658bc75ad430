//! Columns, kinds, places and keys in the words of the field.

use joint_core::effect::Kind;

use crate::discover::candidates::card;
use crate::discover::findings::Named;
use crate::plot::text::unit_of;

/// Columns and what they are; the longer names first.
const COLUMNS: [(&str, &str); 9] = [
    ("output_speed_rad_per_s", "output speed"),
    ("motor_speed_rad_per_s", "motor speed"),
    ("output_windup_rad", "wind-up of the last stage"),
    ("output_angle_rad", "output angle"),
    ("motor_angle_rad", "motor angle"),
    ("temperature_c", "temperature"),
    ("i_a", "current"),
    ("u_v", "voltage"),
    ("t_s", "time"),
];

/// A text with its columns in words.
pub(super) fn words(text: &str) -> String {
    COLUMNS.iter().fold(text.to_owned(), |text, (column, words)| text.replace(column, words))
}

/// With its article, where it takes one.
pub(super) fn the(quantity: &str) -> String {
    if quantity.starts_with("time") { quantity.to_owned() } else { format!("the {quantity}") }
}

/// What a coordinate is, and its unit.
pub(super) fn quantity(coordinate: &str) -> (String, &'static str) {
    let column = coordinate.split(" (").next().unwrap_or_default();
    (words(coordinate), unit_of(column).1)
}

/// A kind in words.
pub(super) fn kind(name: &str) -> String {
    let words = name.replace('-', " ").replace(" dependent", "-dependent");
    match Kind::from_name(name).is_some_and(Kind::is_unnamed) {
        true => format!("unnamed {words}"),
        false => words,
    }
}

/// A place in words, behind a kind.
pub(super) fn place(location: &str) -> String {
    match location {
        "motor" => "in the motor".to_owned(),
        "output" => "at the output".to_owned(),
        "inverter" => "in the inverter".to_owned(),
        "encoder" => "of the motor encoder".to_owned(),
        "output-encoder" => "of the output encoder".to_owned(),
        "current-sensor" => "of the current sensor".to_owned(),
        other => match other.strip_prefix("stage") {
            Some(number) => format!("in gear stage {number}"),
            None => format!("at {other}"),
        },
    }
}

/// An effect and its place.
pub(super) fn effect(kind_name: &str, location: &str) -> String {
    format!("{} {}", kind(kind_name), place(location))
}

/// What a kind is, in half a sentence; nothing for one that is not listed.
pub(super) fn explained(kind_name: &str) -> Option<&'static str> {
    Kind::from_name(kind_name).map(|kind| card(kind).words)
}

/// Effects as a list in a sentence, those of one kind and place once.
pub(super) fn list(effects: &[Named]) -> String {
    let mut told: Vec<(String, usize)> = Vec::new();
    for own in effects {
        let name = effect(&own.kind, &own.location);
        match told.iter_mut().find(|(known, _)| *known == name) {
            Some((_, count)) => *count += 1,
            None => told.push((name, 1)),
        }
    }
    let named = told.into_iter().map(|(name, count)| match count {
        1 => name,
        count => format!("{name} ({count} of them)"),
    });
    joined(&named.collect::<Vec<_>>())
}

/// A sentence's beginning.
pub(super) fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// `a`, `a and b`, `a, b and c`.
pub(super) fn joined(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// A parameter's key in words, and its unit: `motor.friction.coulomb_nm` is Coulomb friction, motor, in Nm.
pub(super) fn parameter(key: &str) -> (String, &'static str) {
    let (name, unit) = unit_of(key);
    let (place, name) = name.split_once('.').unwrap_or(("", name));
    let friction = name.strip_prefix("friction.");
    let name = match friction.unwrap_or(name) {
        "coulomb" => "Coulomb friction".to_owned(),
        "stribeck" => "Stribeck friction".to_owned(),
        "stribeck_velocity" => "Stribeck velocity".to_owned(),
        "sigma0" => "bristle stiffness".to_owned(),
        "sigma1" => "bristle damping".to_owned(),
        "sigma2" => "viscous friction".to_owned(),
        other => other.replace('_', " "),
    };
    let place = match place.strip_prefix("stage") {
        Some(number) => format!("stage {number}"),
        None => place.to_owned(),
    };
    if place.is_empty() { (name, unit) } else { (format!("{name}, {place}"), unit) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_names_become_words_with_a_unit() {
        assert_eq!(
            words("motor_angle_rad (one turn), times i_a"),
            "motor angle (one turn), times current"
        );
        assert_eq!((the("time"), the("current")), ("time".to_owned(), "the current".to_owned()));
        assert_eq!(quantity("t_s"), ("time".to_owned(), "s"));
        assert_eq!(quantity("motor_angle_rad (one turn)").1, "rad");
        assert_eq!(kind("load-dependent-friction"), "load-dependent friction");
        assert_eq!(effect("torque-map", "output"), "unnamed torque map at the output");
        assert_eq!(effect("transmission-error", "stage2"), "transmission error in gear stage 2");
        assert_eq!(
            parameter("stage1.friction.sigma2_nm_s_per_rad"),
            ("viscous friction, stage 1".to_owned(), "Nm s/rad")
        );
        assert_eq!(parameter("motor.phase_resistance_ohm").0, "phase resistance, motor");
        assert_eq!(joined(&["a".into(), "b".into(), "c".into()]), "a, b and c");
    }

    #[test]
    fn every_kind_has_a_place_in_words() {
        for kind in Kind::ALL {
            for location in kind.spec().locations {
                assert!(!place(&location.to_string()).starts_with("at stage"), "{location}");
                assert!(explained(kind.spec().kind).is_some());
            }
        }
    }
}
