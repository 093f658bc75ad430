//! The C library as C calls it: several joints, moved and on threads, and every wrong pointer.
//!
//! It runs under Miri as well: `cargo +nightly miri test -p joint-capi`.

#![allow(unsafe_code, reason = "what is called is C's interface")]

use joint::{
    Estimate, JOINT_NOT_INITIALISED, JOINT_OK, JOINT_POINTER, Joint, Sample, joint_estimate,
    joint_init, joint_update,
};

const BLOCK: &[u8] = include_bytes!("../../src/default.block");
/// Periods of a run; Miri takes some milliseconds for each.
const PERIODS: i32 = if cfg!(miri) { 20 } else { 2000 };

fn zeroed() -> Box<Joint> {
    // SAFETY: a joint of zeros is one that is not initialised.
    unsafe { Box::<Joint>::new_zeroed().assume_init() }
}

fn init(joint: &mut Joint, block: &[u8]) -> i32 {
    // SAFETY: both are this function's for the call.
    unsafe { joint_init(joint, block.as_ptr(), block.len()) }
}

/// Counts of a rotor that turns by so many in a period.
fn run(joint: &mut Joint, counts: i32, from: i32) -> Estimate {
    let mut estimate = Estimate::default();
    for k in from..from + PERIODS {
        let sample = Sample { voltage_v: 1.0, motor_counts: counts * k, ..Sample::default() };
        // SAFETY: all three are this function's for the call.
        unsafe {
            assert_eq!(joint_update(joint, &raw const sample), JOINT_OK);
            assert_eq!(joint_estimate(joint, &raw mut estimate), JOINT_OK);
        }
    }
    estimate
}

#[test]
fn joints_on_threads_and_a_joint_that_was_moved_know_nothing_of_each_other() {
    let alone = |counts: i32| {
        let mut joint = zeroed();
        assert_eq!(init(&mut joint, BLOCK), JOINT_OK);
        run(&mut joint, counts, 0);
        let mut moved = Box::new(*joint);
        run(&mut moved, counts, PERIODS).motor_velocity_rad_per_s.to_bits()
    };
    let one_by_one = [1, -2, 3].map(alone);
    let together = std::thread::scope(|scope| {
        [1, -2, 3].map(|counts| scope.spawn(move || alone(counts))).map(|own| own.join().unwrap())
    });
    assert_eq!(together, one_by_one);
    assert_ne!(one_by_one[0], one_by_one[1]);
}

#[test]
fn what_is_not_initialised_is_told_and_nothing_is_written() {
    let mut joint = zeroed();
    let (sample, mut estimate) = (Sample::default(), Estimate { tick: 7, ..Estimate::default() });
    let damaged: Vec<u8> = BLOCK.iter().map(|byte| byte ^ 1).collect();
    for block in [&damaged[..], &[], &BLOCK[..40], &[0xff; 64]] {
        assert_ne!(init(&mut joint, block), JOINT_OK);
        // SAFETY: all are this function's for the call.
        let answers = unsafe {
            [
                joint_update(&mut *joint, &raw const sample),
                joint_estimate(&*joint, &raw mut estimate),
            ]
        };
        assert_eq!(answers, [JOINT_NOT_INITIALISED; 2]);
        assert_eq!(estimate.tick, 7);
    }
}

#[test]
fn a_pointer_that_leads_nowhere_is_told() {
    let mut joint = zeroed();
    assert_eq!(init(&mut joint, BLOCK), JOINT_OK);
    let (null, null_sample) = (std::ptr::null_mut::<Joint>(), std::ptr::null::<Sample>());
    let mut estimate = Estimate::default();
    let crooked = (&raw mut *joint).cast::<u8>().wrapping_add(1).cast::<Joint>();
    // SAFETY: nothing is read behind a pointer that is null or not aligned.
    let answers = unsafe {
        [
            joint_init(null, BLOCK.as_ptr(), BLOCK.len()),
            joint_init(&mut *joint, std::ptr::null(), 12),
            joint_init(crooked, BLOCK.as_ptr(), BLOCK.len()),
            joint_update(null, null_sample),
            joint_update(&mut *joint, null_sample),
            joint_update(crooked, null_sample),
            joint_estimate(null, &raw mut estimate),
            joint_estimate(&*joint, std::ptr::null_mut()),
        ]
    };
    assert_eq!(answers, [JOINT_POINTER; 8]);
}
