//! What the variables are, in words, and within which limits parameters may be set.

use joint_core::effect::Kind;

use crate::effect::EffectDescription;

/// Smallest and largest value.
pub(crate) type Limits = [Option<f64>; 2];

const ANY: Limits = [None, None];
const NOT_NEGATIVE: Limits = [Some(0.0), None];

/// Inputs and outputs; those of a stage follow behind its name.
const SIGNALS: [(&str, &str); 17] = [
    ("voltage_v", "Voltage on the two conducting phases, held over a communication step"),
    ("command_current_a", "Motor current, held over a communication step"),
    ("load_torque_nm", "Load at the output, positive against positive motion"),
    ("current_a", "Current in the winding"),
    ("measured_current_a", "Current as its sensor shows it"),
    ("motor_angle_rad", "Angle of the rotor"),
    ("motor_speed_rad_per_s", "Speed of the rotor"),
    ("motor_bristle", "Bristle torque of the rotor's friction over its Coulomb level"),
    ("output_angle_rad", "Angle behind the last stage"),
    ("output_speed_rad_per_s", "Speed behind the last stage"),
    ("motor_torque_nm", "Torque of the motor on its rotor"),
    ("motor_friction_nm", "Friction on the rotor, positive against positive motion"),
    ("_angle_rad", "angle of the mass behind it"),
    ("_speed_rad_per_s", "speed of the mass behind it"),
    ("_windup_rad", "input angle over the reduction less output angle"),
    ("_bristle", "bristle torque of its friction over its Coulomb level"),
    ("_torque_nm", "torque of its spring and damper on the mass behind it"),
];
const STAGE_FRICTION: &str = "friction on the mass behind it, positive against positive motion";

/// Parameters by key.
const PARAMETERS: [(&str, &str, Limits); 23] = [
    ("phase_resistance_ohm", "Resistance of one phase", NOT_NEGATIVE),
    ("phase_inductance_h", "Inductance of one phase", NOT_NEGATIVE),
    ("torque_constant_nm_per_a", "Torque per current, two phases conducting", NOT_NEGATIVE),
    ("phase_back_emf_constant_v_s_per_rad", "Back-EMF constant of one phase", NOT_NEGATIVE),
    ("pole_pairs", "Pole pairs", [Some(1.0), None]),
    ("rotor_inertia_kg_m2", "Inertia of the rotor", NOT_NEGATIVE),
    ("sigma0_nm_per_rad", "Stiffness of the friction's bristles", NOT_NEGATIVE),
    ("sigma1_nm_s_per_rad", "Damping of the friction's bristles", NOT_NEGATIVE),
    ("sigma2_nm_s_per_rad", "Viscous friction", NOT_NEGATIVE),
    ("coulomb_nm", "Coulomb friction", NOT_NEGATIVE),
    ("stribeck_nm", "Excess of friction at standstill", ANY),
    ("stribeck_velocity_rad_per_s", "Speed at which that excess falls to 1/e", NOT_NEGATIVE),
    ("reduction", "Input turns over output turns, negative where the stage reverses", ANY),
    ("inertia_kg_m2", "Inertia", NOT_NEGATIVE),
    ("stiffness_nm_per_rad", "Linear stiffness, at the stage's output", NOT_NEGATIVE),
    ("cubic_stiffness_nm_per_rad3", "Cubic stiffness, at the stage's output", ANY),
    ("damping_nm_s_per_rad", "Damping of the spring, at the stage's output", NOT_NEGATIVE),
    ("gravity_nm", "Largest torque of gravity on the load", ANY),
    ("gravity_phase_rad", "Angle of the load from where gravity is without torque", ANY),
    ("initial.motor_angle_rad", "Angle of the rotor at the start, every spring relaxed", ANY),
    (
        "initial.motor_speed_rad_per_s",
        "Speed of the rotor at the start, of all masses with it",
        ANY,
    ),
    ("worm_lead_angle_rad", "Lead angle of the worm, zero where there is none", ANY),
    ("worm_friction_coefficient", "Friction coefficient of the worm's mesh", NOT_NEGATIVE),
];

/// What a variable of a joint with these effects is, and its limits.
pub(crate) fn of(effects: &[EffectDescription], name: &str) -> (String, Limits) {
    if let Some((_, text)) = SIGNALS.iter().find(|(own, _)| *own == name) {
        return ((*text).to_owned(), ANY);
    }
    if let Some((table, key)) = name.split_once('.') {
        return of_parameter(effects, name, table, key);
    }
    let Some((stage, quantity)) = name.split_once('_') else { return (name.to_owned(), ANY) };
    let quantity = format!("_{quantity}");
    let text = SIGNALS.iter().find(|(own, _)| *own == quantity).map_or(STAGE_FRICTION, |own| own.1);
    (format!("Stage {}: {text}", stage.trim_start_matches("stage")), ANY)
}

fn of_parameter(
    effects: &[EffectDescription],
    name: &str,
    table: &str,
    key: &str,
) -> (String, Limits) {
    if let Some(number) = table.strip_prefix("effect") {
        let place = number.parse::<usize>().ok().and_then(|number| number.checked_sub(1));
        if let Some(effect) = place.and_then(|place| effects.get(place)) {
            let spec = Kind::from_name(&effect.kind).map(Kind::spec);
            let own = spec.and_then(|spec| spec.parameters.iter().find(|own| own.key == key));
            let limits = own.map_or(ANY, |own| [own.low, own.high].map(Some));
            let text = format!("{} at {}: {key}", effect.kind, effect.location);
            return (text, limits.map(|limit| limit.filter(|limit| limit.is_finite())));
        }
    }
    let last = key.rsplit('.').next().unwrap_or(key);
    let own = PARAMETERS.iter().find(|(own, ..)| *own == name || *own == last);
    let (text, limits) = own.map_or((key, ANY), |(_, text, limits)| (*text, *limits));
    let text = match (table.strip_prefix("stage"), table) {
        (Some(number), _) => format!("Stage {number}: {text}"),
        (_, "load") => format!("Load: {text}"),
        (_, "motor") => format!("Motor: {text}"),
        _ => text.to_owned(),
    };
    (text, limits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::{Input, Joint};
    use joint_core::params::{Load, Motor, Stage};

    #[test]
    fn every_variable_is_described_in_words_of_its_own() {
        let effect = EffectDescription {
            kind: "cogging".to_owned(),
            location: "motor".to_owned(),
            parameters: serde_json::from_str("{\"order\": 6, \"amplitude_nm\": 1e-5}").unwrap(),
        };
        let motor = Motor { phase_back_emf_constant_v_s_per_rad: Some(0.1), ..Motor::default() };
        for input in [Input::Voltage, Input::Current] {
            let joint = Joint {
                name: "j".to_owned(),
                input,
                period_s: 5e-5,
                motor,
                stage: vec![Stage::default(); 2],
                load: Load::default(),
                effect: vec![effect.clone()],
            };
            let variables = joint.variables();
            for variable in &variables {
                let key = variable.name.rsplit('.').next().unwrap();
                let is_effect = variable.name.starts_with("effect");
                assert!(is_effect || !variable.description.contains(key), "{variable:?}");
                assert!(variable.description.contains(' '), "{variable:?}");
                let twice = |own: &&crate::joint::Variable| own.description == variable.description;
                let friction = variable.name.contains("friction.");
                assert!(friction || variables.iter().filter(twice).count() == 1, "{variable:?}");
            }
            let order = variables.iter().find(|own| own.name == "effect1.order").unwrap();
            assert!(order.limits[0].is_some(), "{order:?}");
        }
    }
}
