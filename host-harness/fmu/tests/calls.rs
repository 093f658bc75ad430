//! The FMU as an importing tool calls it: several instances, on threads, every null pointer, and states from
//! bytes that are none.

#![allow(unsafe_code, reason = "what is called is C's interface")]

#[path = "../../../tests/fuzz/one_stage.rs"]
mod one_stage;

use std::ffi::CString;
use std::fs;
use std::ptr::{null, null_mut};
use std::sync::atomic::{AtomicU32, Ordering};

use joint_fmu::functions::*;
use joint_fmu::{Joint, guid};
use one_stage::one_stage;

const PERIOD_S: f64 = 50e-6;
const STEPS: u32 = 2000;
/// Value references: the inputs, then the outputs, then the parameters.
const VOLTAGE: u32 = 0;
const OUTPUTS: std::ops::Range<u32> = 2..17;

fn joint() -> Joint {
    one_stage(PERIOD_S)
}

/// An instance, freed at its end.
struct Fmu(*mut Instance);

impl Fmu {
    fn new() -> Self {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let folder =
            std::env::temp_dir().join(format!("fmu-calls-{}-{number}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let text = joint().text();
        fs::write(folder.join("joint.json"), &text).unwrap();
        let place = CString::new(folder.to_str().unwrap()).unwrap();
        let wanted = CString::new(guid(&text)).unwrap();
        let name = c"own".as_ptr();
        // SAFETY: the strings end in zero and live over the call.
        let own =
            unsafe { fmi2Instantiate(name, 1, wanted.as_ptr(), place.as_ptr(), null(), 0, 0) };
        fs::remove_dir_all(&folder).unwrap();
        assert!(!own.is_null());
        Self(own)
    }

    fn started() -> Self {
        let own = Self::new();
        assert_eq!(own.start(), OK);
        own
    }

    fn start(&self) -> Status {
        // SAFETY: an instance that was not freed.
        unsafe {
            assert_eq!(fmi2EnterInitializationMode(self.0), OK);
            fmi2ExitInitializationMode(self.0)
        }
    }

    fn set(&self, reference: u32, value: f64) -> Status {
        // SAFETY: as above; one reference, one value.
        unsafe { fmi2SetReal(self.0, &reference, 1, &value) }
    }

    fn step(&self, from_s: f64, step_s: f64) -> Status {
        // SAFETY: as above.
        unsafe { fmi2DoStep(self.0, from_s, step_s, 0) }
    }

    /// Steps one by one, from a step on, and the outputs' bits behind them.
    fn run(&self, from: u32) -> Vec<u64> {
        for k in from..from + STEPS {
            assert_eq!(self.step(f64::from(k) * PERIOD_S, PERIOD_S), OK);
        }
        self.outputs()
    }

    fn outputs(&self) -> Vec<u64> {
        let references: Vec<u32> = OUTPUTS.collect();
        let mut values = vec![f64::NAN; references.len()];
        // SAFETY: as above; as many values as references.
        let answer = unsafe {
            fmi2GetReal(self.0, references.as_ptr(), references.len(), values.as_mut_ptr())
        };
        assert_eq!(answer, OK);
        values.into_iter().map(f64::to_bits).collect()
    }

    /// The state as bytes.
    fn bytes(&self) -> Vec<u8> {
        let (mut state, mut size) = (null_mut(), 0);
        // SAFETY: as above; room for as many bytes as are told.
        unsafe {
            assert_eq!(fmi2GetFMUstate(self.0, &mut state), OK);
            assert_eq!(fmi2SerializedFMUstateSize(self.0, state, &mut size), OK);
            let mut bytes = vec![0; size];
            let short = fmi2SerializeFMUstate(self.0, state, bytes.as_mut_ptr(), size - 1);
            assert_eq!(short, ERROR);
            assert_eq!(fmi2SerializeFMUstate(self.0, state, bytes.as_mut_ptr(), size), OK);
            assert_eq!(fmi2FreeFMUstate(self.0, &mut state), OK);
            assert!(state.is_null());
            bytes
        }
    }

    /// To the state of these bytes; nothing changes where they are refused.
    fn restore(&self, bytes: &[u8]) -> Status {
        let mut state = null_mut();
        // SAFETY: as above.
        unsafe {
            let answer = fmi2DeSerializeFMUstate(self.0, bytes.as_ptr(), bytes.len(), &mut state);
            assert_eq!(answer == OK, !state.is_null());
            if answer == OK {
                assert_eq!(fmi2SetFMUstate(self.0, state), OK);
                assert_eq!(fmi2FreeFMUstate(self.0, &mut state), OK);
            }
            answer
        }
    }
}

impl Drop for Fmu {
    fn drop(&mut self) {
        // SAFETY: freed once.
        unsafe { fmi2FreeInstance(self.0) }
    }
}

#[test]
fn instances_on_threads_know_nothing_of_each_other() {
    let alone = |voltage_v: f64| {
        let own = Fmu::started();
        assert_eq!(own.set(VOLTAGE, voltage_v), OK);
        own.run(0)
    };
    let one_by_one = [1.0, -2.0, 3.0].map(alone);
    let together = std::thread::scope(|scope| {
        [1.0, -2.0, 3.0].map(|volts| scope.spawn(move || alone(volts))).map(|it| it.join().unwrap())
    });
    assert_eq!(together, one_by_one);
    assert_ne!(one_by_one[0], one_by_one[1]);
}

#[test]
fn a_state_goes_on_to_the_bit_in_another_instance_and_through_bytes() {
    let (own, other) = (Fmu::started(), Fmu::new());
    own.set(VOLTAGE, 2.0);
    own.run(0);
    let kept = own.bytes();
    let expected = own.run(STEPS);
    assert_eq!(other.restore(&kept), OK);
    assert_eq!(other.run(STEPS), expected);
    assert_eq!(own.restore(&kept), OK);
    assert_eq!(own.run(STEPS), expected);
}

#[test]
fn a_start_before_zero_that_was_set_goes_through_bytes() {
    let (own, other) = (Fmu::new(), Fmu::new());
    // SAFETY: as in `step`.
    assert_eq!(unsafe { fmi2SetupExperiment(own.0, 0, 0.0, -5.0, 0, 0.0) }, OK);
    assert_eq!(other.restore(&own.bytes()), OK);
}

#[test]
fn bytes_that_are_no_state_are_refused_and_nothing_changes() {
    let own = Fmu::started();
    own.set(VOLTAGE, 2.0);
    let outputs = own.run(0);
    let kept = own.bytes();
    for end in 0..kept.len() {
        assert_eq!(own.restore(&kept[..end]), ERROR, "{end} of {} bytes", kept.len());
    }
    let parameters = joint().variables().len() - OUTPUTS.end as usize;
    assert!(parameters < 128, "their number is one byte");
    let start_s = 1 + 8 * (parameters + 2);
    let with = |at: usize, value: f64| {
        let mut bytes = kept.clone();
        bytes[at..at + 8].copy_from_slice(&value.to_le_bytes());
        bytes
    };
    // A start that is no number, a time that is none, and a time without its steps.
    for (at, value) in [(0, f64::NAN), (8, f64::INFINITY), (8, 0.0), (8, 1e6)] {
        assert_eq!(own.restore(&with(start_s + at, value)), ERROR, "{at} {value}");
    }
    // No number anywhere in the state: refused, or a place that the outputs do not hang on.
    let state = start_s + 16;
    let places = state..kept.len() - 8;
    let answers: Vec<_> = places.map(|at| own.restore(&with(at, f64::NAN))).collect();
    assert!(answers.contains(&ERROR));
    assert_eq!(own.restore(&kept), OK);
    assert_eq!(own.outputs(), outputs);
}

#[test]
fn a_communication_step_without_end_is_refused_at_once() {
    let (own, other) = (Fmu::started(), Fmu::started());
    for step_s in [1e6, 1e300, f64::MAX] {
        assert_eq!(own.step(0.0, step_s), ERROR, "{step_s}");
    }
    assert_eq!(own.run(0), other.run(0));
}

/// A drive that no number can follow: what comes after the step that fails fails too, and the outputs stay
/// those before it.
#[test]
fn an_instance_whose_state_is_no_number_goes_on_saying_so() {
    let own = Fmu::started();
    let outputs = own.outputs();
    assert_eq!([own.set(VOLTAGE, 1e200), own.step(0.0, PERIOD_S)], [OK, ERROR]);
    assert_eq!(own.set(VOLTAGE, 0.0), OK);
    for step_s in [0.0, 0.5 * PERIOD_S, PERIOD_S, 2.0 * PERIOD_S] {
        assert_eq!(own.step(0.0, step_s), ERROR, "{step_s}");
    }
    assert_eq!(own.outputs(), outputs);
    assert_eq!(own.start(), OK);
    assert_eq!(own.step(0.0, PERIOD_S), OK);
}

/// Seconds since 1970 are a start, at which a double tells a quarter of a microsecond.
#[test]
fn an_instance_that_starts_late_makes_the_steps_it_is_asked_for() {
    let (own, other) = (Fmu::new(), Fmu::started());
    let start_s = 1.7e9;
    // SAFETY: an instance that was not freed.
    let setup = |start_s: f64| unsafe { fmi2SetupExperiment(own.0, 0, 0.0, start_s, 0, 0.0) };
    assert_eq!((setup(f64::MAX), own.start()), (OK, ERROR));
    assert_eq!((setup(f64::NAN), setup(start_s), own.start()), (ERROR, OK, OK));
    assert_eq!(setup(0.0), ERROR, "it runs: steps would be made for the time between");
    for k in 0..STEPS {
        let volts = if k < 10 { 3.0 } else { -1.0 };
        assert_eq!([own.set(VOLTAGE, volts), other.set(VOLTAGE, volts)], [OK; 2]);
        let from_s = f64::from(k) * PERIOD_S;
        assert_eq!([own.step(start_s + from_s, PERIOD_S), other.step(from_s, PERIOD_S)], [OK; 2]);
        assert_eq!(own.outputs(), other.outputs(), "step {k}");
    }
    assert_eq!(own.restore(&own.bytes()), OK);
}

#[test]
fn a_start_without_finite_outputs_is_refused() {
    let own = Fmu::new();
    let last = joint().variables().len() as u32 - 1;
    assert_eq!(joint().variables().last().unwrap().name, "initial.motor_speed_rad_per_s");
    for speed in [f64::NAN, f64::MAX] {
        assert_eq!(own.set(last, speed), OK);
        assert_eq!(own.start(), ERROR, "{speed}");
        assert_eq!(own.step(0.0, PERIOD_S), ERROR);
    }
    assert_eq!(own.set(last, 100.0), OK);
    assert_eq!(own.start(), OK);
}

#[test]
fn a_pointer_that_leads_nowhere_is_told() {
    let own = Fmu::started();
    let (none, mut value, mut state, mut size) = (null_mut(), 0.0, null_mut(), 0);
    let place = &raw mut value;
    // SAFETY: nothing is read behind a pointer that is null.
    let answers = unsafe {
        [
            fmi2SetupExperiment(none, 0, 0.0, 0.0, 0, 0.0),
            fmi2EnterInitializationMode(none),
            fmi2ExitInitializationMode(none),
            fmi2Terminate(none),
            fmi2Reset(none),
            fmi2DoStep(none, 0.0, PERIOD_S, 0),
            fmi2GetReal(none, &VOLTAGE, 1, place),
            fmi2GetReal(own.0, null(), 1, place),
            fmi2GetReal(own.0, &VOLTAGE, 1, null_mut()),
            fmi2SetReal(own.0, null(), 1, place),
            fmi2SetReal(own.0, &VOLTAGE, 1, null()),
            fmi2GetFMUstate(none, &mut state),
            fmi2GetFMUstate(own.0, null_mut()),
            fmi2SetFMUstate(own.0, null_mut()),
            fmi2SerializedFMUstateSize(own.0, null_mut(), &mut size),
            fmi2SerializeFMUstate(own.0, null_mut(), null_mut(), 0),
            fmi2DeSerializeFMUstate(own.0, null(), 8, &mut state),
            fmi2GetString(none, null(), 0, null_mut()),
        ]
    };
    assert_eq!(answers, [ERROR; 18]);
    // SAFETY: as above.
    unsafe {
        assert!(fmi2Instantiate(null(), 1, null(), null(), null(), 0, 0).is_null());
        fmi2FreeInstance(none);
        assert_eq!(fmi2FreeFMUstate(own.0, null_mut()), OK);
    }
}
