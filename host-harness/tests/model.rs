//! Reading and writing models.

use std::path::Path;

use host_harness::model::{Model, Sensor};
use joint_core::effect::{EffectParameters, Kind, MAX_TABLES};
use joint_core::params::{Friction, Load, Location, Motor, Stage};
use proptest::prelude::*;

const ARM: &str = r#"name = "arm"
[motor]
torque_constant_nm_per_a = 0.07
rotor_inertia_kg_m2 = 3.2e-05
[motor.friction]
sigma0_nm_per_rad = 12
coulomb_nm = 0.012
[[stage]]
reduction = 16
stiffness_nm_per_rad = 350
[[effect]]
kind = "cogging"
location = "motor"
order = 6
amplitude_nm = 1e-3
"#;

fn parse(text: &str) -> Result<Model, String> {
    Model::parse(text, Path::new("arm.toml")).map_err(|error| error.to_string())
}

/// The error that follows from one change to a good file.
fn error(from: &str, to: &str) -> String {
    assert!(ARM.contains(from));
    parse(&ARM.replacen(from, to, 1)).expect_err("a malformed model was taken")
}

#[test]
fn whole_numbers_are_numbers_and_what_is_left_out_takes_its_default() {
    let model = parse(ARM).unwrap();
    assert_eq!(model.name, "arm");
    assert_eq!(model.motor.friction.sigma0_nm_per_rad, 12.0);
    assert_eq!(model.motor.back_emf_constant(), 0.035);
    assert_eq!(model.stages[0].reduction, 16.0);
    assert_eq!(model.stages[0].friction, Friction::default());
    assert_eq!(model.load, Load::default());
    assert_eq!(model.sensor, Sensor::default());
    let effect = EffectParameters::new(Kind::Cogging, Location::Motor);
    assert_eq!(model.effects, [effect.with("order", 6.0).with("amplitude_nm", 1e-3)]);
}

#[test]
fn a_model_without_a_name_is_called_after_its_file() {
    assert_eq!(parse(ARM.split_once('\n').unwrap().1).unwrap().name, "arm");
}

#[test]
fn inline_tables_say_the_same() {
    let text = "stage = [{ reduction = 2, stiffness_nm_per_rad = 3 }]\n\
                motor.torque_constant_nm_per_a = 1\nmotor.rotor_inertia_kg_m2 = 1\n";
    let model = parse(text).unwrap();
    assert_eq!((model.stages[0].reduction, model.motor.rotor_inertia_kg_m2), (2.0, 1.0));
    assert_eq!(
        parse(&text.replace("= 3", "= -3")).unwrap_err(),
        "arm.toml:1:50: [[stage]] number 1 stiffness_nm_per_rad = -3: must be more than zero
   |
 1 | stage = [{ reduction = 2, stiffness_nm_per_rad = -3 }]
   |                                                  ^^"
    );
}

#[test]
fn an_unknown_key_is_shown_with_those_that_are_known() {
    assert_eq!(
        error("coulomb_nm", "coulomb"),
        "arm.toml:7:1: unknown key `coulomb` in [motor.friction]
   |
 7 | coulomb = 0.012
   | ^^^^^^^
  help: its keys are: sigma0_nm_per_rad, sigma1_nm_s_per_rad, sigma2_nm_s_per_rad, coulomb_nm, \
         stribeck_nm, stribeck_velocity_rad_per_s"
    );
    assert_eq!(
        error("[[stage]]", "[[gear]]"),
        "arm.toml:8:3: unknown key `gear`
   |
 8 | [[gear]]
   |   ^^^^
  help: a model has: name, motor, stage, load, sensor, effect"
    );
    assert!(
        error("amplitude_nm", "amplitude").contains(":15:1: unknown key `amplitude` in effect")
    );
}

#[test]
fn a_wrong_type_is_shown_at_its_value() {
    assert_eq!(
        error("= 16", "= \"16:1\""),
        "arm.toml:9:13: [[stage]] number 1 reduction: wrong type: string \"16:1\", expected a number
   |
 9 | reduction = \"16:1\"
   |             ^^^^^^"
    );
    assert!(error("= 6", "= [6]").contains("wrong type: `order` must be a number"));
    assert!(error("\"arm\"", "3").contains("arm.toml:1:8: wrong type: `name`"));
    assert!(error("[[stage]]", "[stage]").contains("help: write [[stage]], once for each"));
    assert!(error("= 12", "=").starts_with("arm.toml:6:"));
}

#[test]
fn a_value_that_the_equations_cannot_take_is_shown_where_it_stands() {
    assert_eq!(
        error("3.2e-05", "-1e-5"),
        "arm.toml:4:23: [motor] rotor_inertia_kg_m2 = -0.00001: must be more than zero
   |
 4 | rotor_inertia_kg_m2 = -1e-5
   |                       ^^^^^"
    );
    assert!(error("= 350", "= nan").contains("arm.toml:10:24: [[stage]] number 1 stiffness"));
    assert!(error("= 350", "= inf").contains("must be a finite number"));
    assert!(error("= 16", "= 0").contains("must not be zero"));
    assert!(error("1e-3", "nan").contains("arm.toml:15:16: [[effect]] number 1 amplitude_nm"));
    assert!(
        error("[[effect]]", "[sensor]\nsample_time_s = -1\n[[effect]]").contains(
            "arm.toml:12:17: [sensor] sample_time_s = -1: must be a number, zero or more"
        )
    );
}

#[test]
fn a_required_key_left_out_is_named_at_its_table() {
    assert_eq!(
        error("rotor_inertia_kg_m2 = 3.2e-05\n", ""),
        "arm.toml:2:1: key `rotor_inertia_kg_m2` is missing in [motor]: it must be more than zero
   |
 2 | [motor]
   | ^^^^^^^
  help: add rotor_inertia_kg_m2"
    );
    assert_eq!(
        error("amplitude_nm = 1e-3\n", "").lines().next(),
        Some("arm.toml:11:1: key `amplitude_nm` is missing in effect cogging")
    );
    assert_eq!(
        parse("").unwrap_err(),
        "arm.toml: table [motor] is missing\n  \
         help: a model has at least [motor] with its torque constant and inertia"
    );
}

#[test]
fn an_effect_of_unknown_kind_or_in_the_wrong_place_is_shown() {
    let kind = error("cogging", "coging");
    assert!(kind.starts_with("arm.toml:12:8: unknown kind `coging`"), "{kind}");
    assert!(
        kind.contains("help: the kinds are: asymmetric-friction, backlash, coating, cogging"),
        "{kind}"
    );
    let place = error("\"motor\"", "\"rotor\"");
    assert!(place.starts_with("arm.toml:13:12: unknown location `rotor`"), "{place}");
    assert_eq!(
        error("\"motor\"", "\"stage1\""),
        "arm.toml:13:12: cogging cannot sit at `stage1` in this joint
    |
 13 | location = \"stage1\"
    |            ^^^^^^^^
  help: it can sit at: motor; this joint has one stage"
    );
}

fn positive() -> impl Strategy<Value = f64> {
    (1e-12..1e12_f64, -9..9_i32).prop_map(|(value, power)| value * 10_f64.powi(power))
}

fn frictions() -> impl Strategy<Value = Friction> {
    prop::array::uniform6(positive()).prop_map(|[s0, s1, s2, coulomb, stribeck, speed]| Friction {
        sigma0_nm_per_rad: s0,
        sigma1_nm_s_per_rad: s1,
        sigma2_nm_s_per_rad: s2,
        coulomb_nm: coulomb,
        stribeck_nm: stribeck,
        stribeck_velocity_rad_per_s: speed,
    })
}

fn stages() -> impl Strategy<Value = Stage> {
    (prop::array::uniform5(positive()), frictions()).prop_map(|([r, j, k1, k3, c], friction)| {
        Stage {
            reduction: -r,
            inertia_kg_m2: j,
            stiffness_nm_per_rad: k1,
            cubic_stiffness_nm_per_rad3: k3,
            damping_nm_s_per_rad: c,
            worm_lead_angle_rad: 0.25,
            worm_friction_coefficient: 0.1,
            friction,
        }
    })
}

/// An effect of any kind that fits a joint of two stages, its values spread over their ranges.
fn effects() -> impl Strategy<Value = EffectParameters> {
    (0..Kind::ALL.len(), any::<prop::sample::Index>(), prop::array::uniform6(0.0..=1.0)).prop_map(
        |(kind, place, shares)| {
            let kind = Kind::ALL[kind];
            let location = match place.get(kind.spec().locations) {
                Location::Stage(_) => Location::Stage(2),
                place => *place,
            };
            if kind.has_table() {
                // Of what its knots are over just one is told.
                let example = EffectParameters { location, ..EffectParameters::example(kind) };
                return example.with("scale", shares[0]).with("start_rad", 1e3 * shares[1]);
            }
            kind.spec().parameters.iter().zip(shares).fold(
                EffectParameters::new(kind, location),
                |effect, (spec, share)| {
                    effect.with(spec.key, spec.low + share * (spec.high - spec.low))
                },
            )
        },
    )
}

/// At most as many with a table as a joint takes.
fn some_effects() -> impl Strategy<Value = Vec<EffectParameters>> {
    prop::collection::vec(effects(), 0..4).prop_map(|mut all| {
        let mut tables = 0;
        all.retain(|effect| {
            tables += usize::from(effect.kind.has_table());
            !effect.kind.has_table() || tables <= MAX_TABLES
        });
        all
    })
}

prop_compose! {
    fn models()(
        name in any::<String>(),
        motor in prop::array::uniform4(positive()),
        poles in 1..100_u32,
        back_emf in any::<bool>(),
        friction in frictions(),
        stages in prop::collection::vec(stages(), 2),
        load in prop::array::uniform3(positive()),
        sensor in prop::array::uniform4(positive()),
        effects in some_effects(),
    ) -> Model {
        let [resistance, inductance, torque, inertia] = motor;
        Model {
            name,
            motor: Motor {
                phase_resistance_ohm: resistance,
                phase_inductance_h: inductance,
                torque_constant_nm_per_a: torque,
                phase_back_emf_constant_v_s_per_rad: back_emf.then_some(torque / 2.0),
                pole_pairs: poles,
                rotor_inertia_kg_m2: inertia,
                friction,
            },
            stages,
            load: Load { inertia_kg_m2: load[0], gravity_nm: -load[1], gravity_phase_rad: load[2] },
            sensor: Sensor {
                sample_time_s: sensor[0],
                motor_encoder_counts_per_rev: sensor[1],
                output_encoder_counts_per_rev: sensor[2],
                current_noise_a: sensor[3],
                ..Sensor::default()
            },
            effects,
            friction_levels: Vec::new(),
        }
    }
}

proptest! {
    #[test]
    fn reading_what_was_written_gives_the_same_model(model in models()) {
        let text = model.to_toml();
        let back = parse(&text).map_err(TestCaseError::fail)?;
        prop_assert_eq!(&back, &model);
        prop_assert_eq!(back.to_toml(), text);
    }

    #[test]
    fn no_change_of_one_character_makes_the_reader_panic(at in 0..ARM.len(), with in any::<char>()) {
        let mut text = ARM.to_owned();
        text.replace_range(at..=at, with.encode_utf8(&mut [0; 4]));
        let _ = parse(&text);
    }
}

const MAP: &str = "
[[effect]]
kind = \"torque-map\"
location = \"output\"
span_rad = 2
blend_rad_per_s = 0.1
torque_nm = [0, 1e-3, -2e-3]
backward_torque_nm = [1e-3, 0.5e-3, 0]
";

#[test]
fn a_table_is_read_and_written_and_what_has_no_name_is_marked() {
    let read = |text: &str| parse(&format!("{ARM}{text}"));
    let model = read(MAP).unwrap();
    let map = model.effects.last().unwrap();
    assert_eq!(map.table.forward(), [0.0, 1e-3, -2e-3]);
    assert_eq!(map.table.backward(), [1e-3, 0.5e-3, 0.0]);
    let text = model.to_toml();
    assert!(text.contains("\nunnamed = true\n"), "{text}");
    assert_eq!(parse(&text).unwrap(), model);
    for (from, to, wanted) in [
        ("[0, 1e-3, -2e-3]", "[0, 1e-3]", "`torque_nm` has 2 knots, `backward_torque_nm` 3"),
        ("[0, 1e-3, -2e-3]", "[0, \"a\", 1]", "`torque_nm` must be a list of numbers"),
        ("[0, 1e-3, -2e-3]", "7", "`torque_nm` must be a list of numbers"),
        ("torque_nm = [0, 1e-3, -2e-3]\nbackward_", "", "backward_torque_nm"),
        ("span_rad = 2", "unnamed = false\nspan_rad = 2", "`unnamed` of torque-map is true"),
        ("span_rad = 2", "period_rad = 2\nspan_rad = 2", "just one of the span"),
        (
            "blend_rad_per_s = 0.1",
            "",
            "key `blend_rad_per_s` is missing in [[effect]] number 2: it must be more",
        ),
        ("1e-3, -2e-3]", "inf, -2e-3]", "must be a finite number"),
    ] {
        let broken = MAP.replacen(from, to, 1);
        assert_ne!(broken, MAP, "{from}");
        match read(&broken) {
            // One curve is that of both directions.
            Ok(model) => assert!(wanted == "backward_torque_nm" && model.effects.len() == 2),
            Err(error) => assert!(error.contains(wanted), "{wanted}: {error}"),
        }
    }
    let named = ARM.replace("order = 6", "order = 6\nunnamed = true");
    assert!(parse(&named).unwrap_err().contains("unknown key `unnamed` in effect cogging"));
}
