//! A parameter block carries the tables of its laws.

use firmware::block::{self, Block, BlockError};
use firmware::replay::ReplayedJoint;
use joint_core::effect::{EffectParameters, Kind};
use joint_core::joint::{Drive, Settings};
use joint_core::params::{Friction, Load, Motor, Stage};

fn joint(kinds: &[Kind]) -> ReplayedJoint<2> {
    let friction = Friction {
        sigma0_nm_per_rad: 10.0,
        sigma1_nm_s_per_rad: 0.01,
        coulomb_nm: 0.01,
        ..Friction::default()
    };
    let motor = Motor {
        phase_resistance_ohm: 0.5,
        torque_constant_nm_per_a: 0.1,
        rotor_inertia_kg_m2: 1e-4,
        friction,
        ..Motor::default()
    };
    let stage = Stage {
        reduction: 10.0,
        inertia_kg_m2: 1e-3,
        stiffness_nm_per_rad: 300.0,
        friction,
        ..Stage::default()
    };
    let effects: Vec<_> = kinds.iter().map(|kind| EffectParameters::example(*kind)).collect();
    let settings = Settings { effects: &effects, ..Settings::new(Drive::Voltage, 50e-6) };
    ReplayedJoint::<2>::new(&motor, &[stage; 2], &Load::default(), &settings).unwrap()
}

#[test]
fn a_table_comes_back_with_its_law() {
    use Kind::{Cogging, FrictionCourse, TorqueMap};
    for kinds in
        [&[][..], &[Cogging], &[TorqueMap], &[Cogging, FrictionCourse], &[TorqueMap, Cogging]]
    {
        let joint = joint(kinds);
        let mut bytes = [0; block::PAGE_BYTES];
        let length = block::encode(&joint, 2, &mut bytes).unwrap();
        let read = Block::check(&bytes[..length]).unwrap().decode::<ReplayedJoint<2>>();
        assert_eq!(read.as_ref(), Ok(&joint), "{kinds:?}");
        let mut state = [joint.rest(), read.unwrap().rest()];
        for k in 0..200 {
            let input = joint.input(if k < 100 { 3.0 } else { -3.0 }, 0.0);
            state.iter_mut().for_each(|state| joint.step(state, input));
        }
        assert_eq!(state[0], state[1]);
    }
}

#[test]
fn a_law_whose_table_is_missing_is_no_payload() {
    let joint = joint(&[Kind::TorqueMap]);
    let mut bytes = [0; block::PAGE_BYTES];
    // A table's knots and more are gone.
    let whole = block::encode(&joint, 2, &mut bytes).unwrap();
    let payload = bytes[block::HEADER_BYTES..whole - block::CRC_BYTES].to_vec();
    for gone in [1, 4, 300] {
        let short = &payload[..payload.len() - gone];
        assert_eq!(block::last::<ReplayedJoint<2>>(short).unwrap_err(), BlockError::Payload);
    }
}
