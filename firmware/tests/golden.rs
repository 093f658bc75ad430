//! Parameter blocks of versions that drives in the field hold are read for good.
//!
//! The file is not made by the code under test. Where this fails since the payload's layout has
//! changed, a new version is due that migrates this one; until a first release, whose blocks are the
//! first to be held to, the file may be written anew instead.

use firmware::block::PAGE_BYTES;
use firmware::parameters::Sensing;
use firmware::session::Session;
use joint_core::telemetry::Mode;

const VERSION_1: &[u8] = include_bytes!("data/version1.block");

#[test]
fn a_block_of_version_1_is_migrated_with_the_default_sensors() {
    let mut page = VERSION_1.to_vec();
    page.resize(PAGE_BYTES, 0xff);
    let mut session = Session::new();
    assert_eq!(session.start(&page), Ok(None));
    let hello = *session.hello();
    assert_eq!((hello.mode, hello.block_version), (Mode::Parameters, 1));
    assert_eq!(session.sensing(), Sensing::default());
}

#[test]
fn a_damaged_block_of_version_1_is_refused() {
    for at in 0..VERSION_1.len() {
        let mut damaged = VERSION_1.to_vec();
        damaged[at] ^= 0x10;
        assert!(Session::new().start(&damaged).unwrap().is_some(), "byte {at}");
    }
}
