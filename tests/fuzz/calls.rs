//! Calls of the C library and of the FMU's functions, read from bytes: any order, any number.
//!
//! Pointers are sound here; what a wrong one does is the business of `firmware/capi/tests/calls.rs` and
//! `host-harness/fmu/tests`.

#![allow(unsafe_code, reason = "what is called is C's interface")]

#[path = "importer.rs"]
mod importer;
#[path = "one_stage.rs"]
mod one_stage;

use std::ffi::c_uint;
use std::ptr::null_mut;

use joint::{
    Estimate, JOINT_BLOCK_EFFECTS, JOINT_BLOCK_EMPTY, JOINT_NOT_INITIALISED, JOINT_OK, Joint,
    Sample, joint_estimate, joint_init, joint_update,
};
use joint_fmu::{Component, ERROR, Joint as Described, OK, Version};

use super::with_checksum;
use importer::{Importer, VERSIONS};
use one_stage::one_stage;

/// What the calls are read from; zeros where the bytes end.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn byte(&mut self) -> u8 {
        self.many::<1>()[0]
    }

    fn many<const N: usize>(&mut self) -> [u8; N] {
        let (bytes, rest) = self.0.split_at(self.0.len().min(N));
        self.0 = rest;
        std::array::from_fn(|k| bytes.get(k).copied().unwrap_or(0))
    }

    /// One of the values at which arithmetic ends, any value, or a plain one.
    fn number(&mut self) -> f64 {
        match self.byte() {
            0 => f64::NAN,
            1 => f64::INFINITY,
            2 => f64::NEG_INFINITY,
            3 => f64::MAX,
            4 => f64::MIN_POSITIVE,
            5 => -0.0,
            6..32 => f64::from_bits(u64::from_le_bytes(self.many())),
            plain => (f64::from(plain) - 128.0) / 16.0,
        }
    }

    /// The next bytes, their number ahead of them in two.
    fn slice(&mut self) -> &'a [u8] {
        let length = usize::from(u16::from_le_bytes(self.many()));
        let (bytes, rest) = self.0.split_at(self.0.len().min(length));
        self.0 = rest;
        bytes
    }
}

const BLOCK: &[u8] = include_bytes!("../../firmware/src/default.block");
/// Periods and steps of one input.
const MOST_STEPS: u64 = 2000;

/// Two joints under calls in any order: every answer is one of the header's, every estimate is finite, and a
/// joint that is not initialised writes none.
pub(crate) fn capi(bytes: &[u8]) {
    let mut bytes = Bytes(bytes);
    // SAFETY: joints of zeros are ones that are not initialised.
    let mut joints = [0; 2].map(|_| unsafe { Box::<Joint>::new_zeroed().assume_init() });
    let mut ready = [false; 2];
    let mut updates = 0;
    while !bytes.0.is_empty() && updates < MOST_STEPS {
        let call = bytes.byte();
        let which = usize::from(call & 1);
        let (own, ready) = (&mut joints[which], &mut ready[which]);
        match (call >> 1) & 7 {
            0 => *ready = initialised(own, BLOCK),
            1 => *ready = initialised(own, bytes.slice()),
            2 => *ready = initialised(own, &with_checksum(bytes.slice())),
            // SAFETY: as above.
            3 => unsafe {
                let zeroed = Box::<Joint>::new_zeroed().assume_init();
                **own = *std::mem::replace(own, zeroed);
            },
            _ => {
                let times = u64::from(bytes.byte()) + 1;
                let mut sample = Sample {
                    voltage_v: bytes.number() as f32,
                    current_a: bytes.number() as f32,
                    motor_counts: i32::from_le_bytes(bytes.many()),
                    output_counts: i32::from_le_bytes(bytes.many()),
                    missed: u32::from(bytes.byte() / 128) * u32::from_le_bytes(bytes.many()),
                };
                let moved = i32::from(i16::from_le_bytes(bytes.many()));
                for _ in 0..times {
                    updated(own, &sample, *ready);
                    sample.motor_counts = sample.motor_counts.wrapping_add(moved);
                }
                updates += times;
            }
        }
    }
}

fn initialised(joint: &mut Joint, block: &[u8]) -> bool {
    // SAFETY: both are this function's for the call.
    let answer = unsafe { joint_init(joint, block.as_ptr(), block.len()) };
    assert!((JOINT_OK..=JOINT_BLOCK_EFFECTS).contains(&answer), "{answer}");
    assert!(answer == JOINT_OK || answer >= JOINT_BLOCK_EMPTY);
    answer == JOINT_OK
}

fn updated(joint: &mut Joint, sample: &Sample, ready: bool) {
    let mut estimate = Estimate { output_angle_rad: f32::NAN, ..Estimate::default() };
    // SAFETY: all three are this function's for the call.
    let answers = unsafe { [joint_update(joint, sample), joint_estimate(joint, &mut estimate)] };
    assert_eq!(answers, [if ready { JOINT_OK } else { JOINT_NOT_INITIALISED }; 2]);
    if !ready {
        assert!(estimate.output_angle_rad.is_nan(), "written by {answers:?}");
        return;
    }
    let numbers = [
        estimate.motor_velocity_rad_per_s,
        estimate.total_friction_at_motor_nm,
        estimate.output_angle_rad,
        estimate.output_velocity_rad_per_s,
        estimate.load_torque_nm,
        estimate.motor_velocity_std,
        estimate.total_friction_std,
        estimate.output_angle_std,
        estimate.output_velocity_std,
        estimate.load_torque_std,
    ];
    let all = [&numbers[..], &estimate.windup_rad, &estimate.windup_std].concat();
    assert!(all.iter().all(|number| number.is_finite()), "{estimate:?} of {sample:?}");
}

/// An instance of the FMU with a copy of its state, both freed at the end.
struct Fmu {
    own: Importer,
    state: *mut Component,
    /// What the outputs were when the state was copied, and where its last communication step ended, s.
    copied: (Vec<u64>, f64, bool),
    outputs: usize,
    /// Where the last communication step ended, s.
    now_s: f64,
    start_s: f64,
    /// Whether no step has failed since the start: the state behind one that has is no number.
    sound: bool,
}

/// The joint's file before a line of dashes, where the bytes begin with a brace, and calls in any order, by each
/// version of the standard: every call answers, what runs has finite outputs, and a copied state brings them
/// back to the bit.
pub(crate) fn fmu(bytes: &[u8]) {
    let dashes = bytes.windows(5).position(|it| it == b"\n---\n");
    let (file, calls) = match dashes.filter(|_| bytes.starts_with(b"{")) {
        Some(at) => (&bytes[..at], &bytes[at + 5..]),
        None => (&b""[..], bytes),
    };
    let file = match std::str::from_utf8(file) {
        Ok("") => one_stage(50e-6).text(),
        Ok(text) => text.to_owned(),
        Err(_) => return,
    };
    for version in VERSIONS {
        let Some(mut fmu) = Fmu::new(version, &file) else { return };
        let period_s = Described::read(&file).map_or(0.0, |joint| joint.period_s);
        let mut bytes = Bytes(calls);
        let mut steps = 0;
        while !bytes.0.is_empty() && steps < MOST_STEPS {
            steps += fmu.call(&mut bytes, period_s);
        }
    }
}

impl Fmu {
    fn new(version: Version, file: &str) -> Option<Self> {
        let own = Importer::new(version, file);
        let described = Described::read(file);
        assert_eq!(own.is_none(), described.is_err());
        let outputs = described.ok()?.outputs().len();
        let (own, state, copied) = (own?, null_mut(), (Vec::new(), 0.0, true));
        Some(Self { own, state, copied, outputs, now_s: 0.0, start_s: 0.0, sound: true })
    }

    /// One call; how many steps it took at most.
    fn call(&mut self, bytes: &mut Bytes<'_>, period_s: f64) -> u64 {
        match bytes.byte() % 12 {
            0 => {
                if self.own.start() == OK {
                    (self.now_s, self.sound) = (self.start_s, true);
                }
                self.hold();
            }
            1 => {
                assert_eq!(self.own.reset(), OK);
                self.start_s = 0.0;
            }
            2 => {
                let start_s = bytes.number();
                if self.own.start_at(start_s) == OK {
                    self.start_s = start_s;
                }
            }
            3 | 4 => {
                let (reference, value) = (c_uint::from(bytes.byte()), bytes.number());
                self.own.set(reference, value);
            }
            5 if self.own.copy(&mut self.state) == OK => {
                self.copied = (self.outputs(), self.now_s, self.sound);
            }
            6 if self.own.go_back(self.state) == OK => {
                assert_eq!(self.outputs(), self.copied.0);
                (self.now_s, self.sound) = (self.copied.1, self.copied.2);
            }
            7 => self.through_bytes(bytes, period_s),
            8 => self.own.free(&mut self.state),
            9 => assert_eq!([self.own.terminate(), self.own.integer()], [OK, ERROR]),
            _ => return self.step(bytes, period_s),
        }
        1
    }

    /// Whole periods, or any number that is told to be too many.
    fn step(&mut self, bytes: &mut Bytes<'_>, period_s: f64) -> u64 {
        let (times, any) = (bytes.byte(), bytes.number());
        let step_s = if times < 200 { f64::from(times) * period_s } else { any };
        let steps = step_s / period_s;
        if (1000.0..1e10).contains(&steps) {
            return 0;
        }
        if self.own.step(self.now_s, step_s) == OK {
            self.now_s += step_s;
            self.hold();
        } else {
            self.sound = false;
        }
        u64::from(times) + 1
    }

    /// The state as bytes, some of them exchanged, is refused or is a state that steps.
    fn through_bytes(&mut self, from: &mut Bytes<'_>, period_s: f64) {
        let Some(mut kept) = self.own.bytes(self.state) else { return };
        let (at, bytes) = (usize::from(u16::from_le_bytes(from.many())), from.slice());
        for (place, byte) in kept.iter_mut().skip(at).zip(bytes) {
            *place = *byte;
        }
        let (mut before, mut made) = (null_mut(), null_mut());
        assert_eq!(self.own.copy(&mut before), OK);
        let answer = self.own.made(&kept, &mut made);
        assert!(answer == OK || !bytes.is_empty() || !self.copied.2);
        if answer == OK {
            assert_eq!(self.own.go_back(made), OK);
            self.hold();
            self.own.step(self.copied.1, 10.0 * period_s);
            self.hold();
        }
        assert_eq!(self.own.go_back(before), OK);
        self.own.free(&mut made);
        self.own.free(&mut before);
    }

    /// The outputs' bits.
    fn outputs(&self) -> Vec<u64> {
        self.own.bits(2..2 + self.outputs as c_uint)
    }

    fn hold(&self) {
        for (k, bits) in self.outputs().into_iter().enumerate() {
            assert!(f64::from_bits(bits).is_finite(), "output {k}: {}", f64::from_bits(bits));
        }
    }
}

impl Drop for Fmu {
    fn drop(&mut self) {
        self.own.free(&mut self.state);
    }
}
