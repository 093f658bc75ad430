//! The law of every effect in other units, held against the same in SI. The units are powers of two.

use joint_core::angle::Angle;
use joint_core::effect::{
    EffectParameters, EffectSet, Effects, Flow, Kind, MEMORIES, Motion, Relaxations, Rubbing,
    Winding,
};
use joint_core::params::{Friction, Load, Location, Motor, Stage};
use joint_core::per_unit::Bases;

/// An effect's example at each of its places, behind the second stage where it is of one.
fn everywhere(kind: Kind) -> impl Iterator<Item = EffectParameters> {
    kind.spec().locations.iter().map(move |place| {
        let location = match *place {
            Location::Stage(_) => Location::Stage(2),
            other => other,
        };
        EffectParameters { location, ..EffectParameters::example(kind) }
    })
}

/// All that a set of effects answers in SI, asked in units of torque, speed, angle, current and time, and in
/// that of what it remembers.
fn answers(set: &EffectSet<f64>, units: [f64; 5], remembered: f64) -> Vec<f64> {
    let [torque, speed, angle, current, time] = units;
    let memory = [0.3 / remembered; MEMORIES];
    let at = Angle::from_turns(0.37);
    let mut all = Vec::new();
    for way in [1.0, -1.0] {
        let moving = 12.0 * way / speed;
        let (amperes, bent) = (0.04 * way / current, 0.02 * way / angle);
        let rubbing = Rubbing {
            speed: moving,
            transmitted: 2e-4 / torque,
            passed_on: -3e-4 / torque,
            angle: at,
        };
        for mass in 0..3 {
            let own = set.torque(mass, Motion { angle: at, speed: moving }, &memory);
            all.extend([own.value * torque, own.slope * torque / angle]);
            all.push(set.inverse_level(mass, rubbing));
            all.push(set.creep(mass).map_or(0.0, |creep| creep.rate(moving).0 * speed));
            all.push(set.viscous(mass, moving, &memory));
            all.push(set.drag(mass, moving) * torque / speed);
        }
        for stage in 0..2 {
            let felt = set.stage(stage, bent, at);
            all.extend([felt.deflection * angle, felt.contact, felt.leverage]);
            let own = set.stage_torque(stage, bent, &memory);
            all.extend([own.value * torque, own.slope * torque / angle]);
        }
        let winding = Winding { current: amperes, per_drop: 0.3, drive: 3.0 * amperes };
        all.push(set.voltage_drop(winding, &memory) * current);
        let excess = set.excess(5.0 * amperes);
        all.extend([excess.value * current, excess.slope]);
        let constants = set.constants(at, amperes);
        all.extend([constants.torque, constants.back_emf]);
        all.push(set.true_current(amperes) * current);
        all.push(set.measured_current(amperes) * current);
        all.push(set.lagged_current(amperes, &memory) * current);
        all.push(set.encoder_error(false, at, moving, &memory));
        all.push(set.encoder_error(true, at, moving, &memory));
        let speeds = [moving, 0.5 * moving, 0.3 * moving];
        let flow = Flow { current: amperes, drive: 3.0 * amperes, speeds: &speeds };
        let mut relaxations: Relaxations<f64> = [None; MEMORIES];
        set.relax(&flow, &mut relaxations);
        let moved = relaxations.iter().flatten();
        all.extend(moved.flat_map(|own| [own.reach / time, own.target * remembered]));
    }
    all
}

#[test]
fn a_law_says_the_same_in_all_units() {
    let friction = Friction { coulomb_nm: 1e-5, ..Friction::default() };
    let motor = Motor { phase_resistance_ohm: 4.0, friction, ..Motor::default() };
    let stage = Stage { reduction: -4.0, friction, ..Stage::default() };
    let stages = [stage, Stage { reduction: 2.0, ..stage }];
    let si = Bases::si(&motor, &stages);
    let mut other = si;
    let units = [0.125, 4.0, 0.5, 0.25, 0.0625];
    [other.torque, other.speed, other.angle, other.current, other.half_step] = units;
    let set = |effects: &[EffectParameters], bases| {
        EffectSet::new(effects, &Load::default(), bases).unwrap()
    };
    let none = answers(&set(&[], &si), [1.0; 5], 1.0);
    for &kind in Kind::ALL {
        for effect in everywhere(kind) {
            let location = effect.location;
            let remembered = match (kind, location) {
                (Kind::InputDelay, _) | (Kind::SensorLag, Location::CurrentSensor) => other.current,
                (Kind::SensorLag, _) => other.speed,
                _ => 1.0,
            };
            let exact = answers(&set(&[effect], &si), [1.0; 5], 1.0);
            let found = answers(&set(&[effect], &other), units, remembered);
            assert_ne!(exact, none, "{kind:?} at {location:?} does nothing");
            for (k, (found, exact)) in found.iter().zip(&exact).enumerate() {
                // A few roundings.
                let near = (found - exact).abs() <= 1e-14 * exact.abs();
                assert!(near, "{kind:?} at {location:?}, answer {k}: {found} for {exact}");
            }
        }
    }
}

/// What a hook answers is asked of the masses and stages alone that the set names, and of each of them.
#[test]
fn what_acts_is_asked_and_nothing_else() {
    let friction = Friction { coulomb_nm: 1e-5, ..Friction::default() };
    let motor = Motor { phase_resistance_ohm: 4.0, friction, ..Motor::default() };
    let stages = [Stage { reduction: 4.0, friction, ..Stage::default() }; 2];
    let bases = Bases::si(&motor, &stages);
    let (memory, at) = ([0.3; MEMORIES], Angle::from_turns(0.37));
    for &kind in Kind::ALL {
        for effect in everywhere(kind) {
            let location = effect.location;
            let set = EffectSet::<f64>::new(&[effect], &Load::default(), &bases).unwrap();
            let rubbing = Rubbing { speed: 12.0, transmitted: 2e-4, passed_on: 3e-4, angle: at };
            let mut found = Vec::new();
            for mass in 0..3 {
                let torque = set.torque(mass, Motion { angle: at, speed: 12.0 }, &memory);
                let damped = set.viscous(mass, 12.0, &memory) != 1.0 || set.drag(mass, 12.0) != 0.0;
                found.push((set.has_torque(mass), torque.value != 0.0));
                let level = set.inverse_level(mass, rubbing) != 1.0 || set.creep(mass).is_some();
                found.push((set.has_level(mass), level));
                found.push((set.has_damping(mass), damped));
            }
            for stage in 0..2 {
                let felt = set.stage(stage, 0.02, at);
                let beside = set.stage_torque(stage, 0.02, &memory);
                let acts = felt.deflection != 0.02 || beside.value != 0.0;
                found.push((set.has_stage(stage), acts));
            }
            let winding = Winding { current: 0.04, per_drop: 0.0, drive: 0.12 };
            found.push((set.has_drops(), set.voltage_drop(winding, &memory) != 0.0));
            found.push((set.has_limit(), set.excess(9.0).value != 0.0));
            let constants = set.constants(at, 0.04);
            found.push((set.has_constants(), constants.torque != 0.0));
            let mut moved: Relaxations<f64> = [None; MEMORIES];
            set.relax(&Flow { current: 0.04, drive: 0.12, speeds: &[12.0, 3.0, 1.0] }, &mut moved);
            found.push((set.has_memory(), moved.iter().any(Option::is_some)));
            let sums = [
                (set.has_levels(), (0..3).any(|mass| set.has_level(mass))),
                (set.has_stages(), (0..2).any(|stage| set.has_stage(stage))),
                (!set.is_empty(), true),
            ];
            for (k, (asked, acts)) in found.into_iter().chain(sums).enumerate() {
                assert_eq!(asked, acts, "{kind:?} at {location:?}, {k}");
            }
        }
    }
}

/// A gear that reverses turns its mass the other way: an asymmetry is that of the mass's own direction.
#[test]
fn an_asymmetry_is_that_of_its_own_shaft_s_direction() {
    let friction = Friction { coulomb_nm: 1e-5, ..Friction::default() };
    let asymmetric = EffectParameters::new(Kind::AsymmetricFriction, Location::Stage(1))
        .with("asymmetry", 0.25)
        .with("viscous_asymmetry", 0.5);
    let felt = |reduction: f64, speed: f64| {
        let stages = [Stage { reduction, friction, ..Stage::default() }];
        let motor = Motor::default();
        let bases = Bases::si(&motor, &stages);
        let set = EffectSet::<f64>::new(&[asymmetric], &Load::default(), &bases).unwrap();
        let rubbing = Rubbing { speed, transmitted: 0.0, passed_on: 0.0, angle: Angle::default() };
        let level = 1.0 / set.inverse_level(1, rubbing);
        [level, set.viscous(1, speed, &[0.0; MEMORIES])]
    };
    for (reduction, speed, stated) in [
        (4.0, 1.0, [1.25, 1.5]),
        (4.0, -1.0, [0.75, 0.5]),
        (-4.0, 1.0, [0.75, 0.5]),
        (-4.0, -1.0, [1.25, 1.5]),
    ] {
        assert_eq!(felt(reduction, speed), stated, "{reduction} {speed}");
    }
}
