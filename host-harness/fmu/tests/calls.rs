//! The FMU as an importing tool calls it, by both versions of the standard: several instances, on threads, every
//! null pointer, and states from bytes that are none.

#![allow(unsafe_code, reason = "what is called is C's interface")]

#[path = "../../../tests/fuzz/importer.rs"]
mod importer;
#[path = "../../../tests/fuzz/one_stage.rs"]
mod one_stage;

use std::ptr::{null, null_mut};

use importer::{Importer, VERSIONS};
use joint_fmu::fmi2::*;
use joint_fmu::{ERROR, Joint, OK, Status, Version};
use one_stage::one_stage;

const PERIOD_S: f64 = 50e-6;
const STEPS: u32 = 2000;
/// Value references: the inputs, then the outputs, then the parameters.
const VOLTAGE: u32 = 0;
const OUTPUTS: std::ops::Range<u32> = 2..17;

fn joint() -> Joint {
    one_stage(PERIOD_S)
}

/// An instance of it.
struct Fmu(Importer);

impl std::ops::Deref for Fmu {
    type Target = Importer;

    fn deref(&self) -> &Importer {
        &self.0
    }
}

impl Fmu {
    fn new(version: Version) -> Self {
        Self(Importer::new(version, &joint().text()).unwrap())
    }

    fn started(version: Version) -> Self {
        let own = Self::new(version);
        assert_eq!(own.start(), OK);
        own
    }

    /// Starts anew, which FMI 3.0 lets none do that runs.
    fn restart(&mut self) -> Status {
        if self.version == Version::Fmi3 {
            assert_eq!([self.start(), self.0.reset()], [ERROR, OK]);
        }
        self.start()
    }

    /// Steps one by one, from a step on, and the outputs' bits behind them.
    fn run(&self, from: u32) -> Vec<u64> {
        for k in from..from + STEPS {
            assert_eq!(self.step(f64::from(k) * PERIOD_S, PERIOD_S), OK);
        }
        self.outputs()
    }

    fn outputs(&self) -> Vec<u64> {
        self.bits(OUTPUTS)
    }

    /// The state as bytes.
    fn kept(&self) -> Vec<u8> {
        let mut state = null_mut();
        assert_eq!(self.copy(&mut state), OK);
        let bytes = self.bytes(state).unwrap();
        self.free(&mut state);
        bytes
    }

    /// To the state of these bytes; nothing changes where they are refused.
    fn restore(&self, bytes: &[u8]) -> Status {
        let mut state = null_mut();
        let answer = self.made(bytes, &mut state);
        if answer == OK {
            assert_eq!(self.go_back(state), OK);
            self.free(&mut state);
        }
        answer
    }
}

#[test]
fn instances_on_threads_know_nothing_of_each_other_and_both_versions_give_the_same_bits() {
    let alone = |version, voltage_v: f64| {
        let own = Fmu::started(version);
        assert_eq!(own.set(VOLTAGE, voltage_v), OK);
        own.run(0)
    };
    let [second, third] =
        VERSIONS.map(|version| [1.0, -2.0, 3.0].map(|volts| alone(version, volts)));
    let together = std::thread::scope(|scope| {
        VERSIONS.map(|version| {
            [1.0, -2.0, 3.0]
                .map(|volts| scope.spawn(move || alone(version, volts)))
                .map(|it| it.join().unwrap())
        })
    });
    assert_eq!(together, [second.clone(), third.clone()]);
    assert_eq!(second, third);
    assert_ne!(second[0], second[1]);
}

#[test]
fn a_state_goes_on_to_the_bit_in_another_instance_and_through_bytes() {
    for version in VERSIONS {
        let (own, other) = (Fmu::started(version), Fmu::new(version));
        own.set(VOLTAGE, 2.0);
        own.run(0);
        let kept = own.kept();
        let expected = own.run(STEPS);
        assert_eq!(other.restore(&kept), OK);
        assert_eq!(other.run(STEPS), expected);
        assert_eq!(own.restore(&kept), OK);
        assert_eq!(own.run(STEPS), expected);
    }
}

#[test]
fn a_start_before_zero_that_was_set_goes_through_bytes() {
    let (mut own, other) = (Fmu::new(Version::Fmi2), Fmu::new(Version::Fmi2));
    assert_eq!(own.0.start_at(-5.0), OK);
    assert_eq!(other.restore(&own.kept()), OK);
}

#[test]
fn bytes_that_are_no_state_are_refused_and_nothing_changes() {
    for version in VERSIONS {
        let own = Fmu::started(version);
        own.set(VOLTAGE, 2.0);
        let outputs = own.run(0);
        let kept = own.kept();
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
}

#[test]
fn a_communication_step_without_end_is_refused_at_once() {
    for version in VERSIONS {
        let (own, other) = (Fmu::started(version), Fmu::started(version));
        for step_s in [1e6, 1e300, f64::MAX] {
            assert_eq!(own.step(0.0, step_s), ERROR, "{step_s}");
        }
        assert_eq!(own.run(0), other.run(0));
    }
}

#[test]
fn a_time_that_jumps_is_refused_and_nothing_changes() {
    for version in VERSIONS {
        let own = Fmu::started(version);
        own.set(VOLTAGE, 2.0);
        let (outputs, now_s) = (own.run(0), f64::from(STEPS) * PERIOD_S);
        for (from_s, step_s) in [(0.0, PERIOD_S), (2.0 * now_s, PERIOD_S), (now_s, -PERIOD_S)] {
            assert_eq!(own.step(from_s, step_s), ERROR, "{from_s} {step_s}");
        }
        assert_eq!(own.outputs(), outputs);
        own.run(STEPS);
    }
}

/// A drive that no number can follow: what comes after the step that fails fails too, and the outputs stay
/// those before it.
#[test]
fn an_instance_whose_state_is_no_number_goes_on_saying_so() {
    for version in VERSIONS {
        let mut own = Fmu::started(version);
        let outputs = own.outputs();
        assert_eq!([own.set(VOLTAGE, 1e200), own.step(0.0, PERIOD_S)], [OK, ERROR]);
        assert_eq!(own.set(VOLTAGE, 0.0), OK);
        for step_s in [0.0, 0.5 * PERIOD_S, PERIOD_S, 2.0 * PERIOD_S] {
            assert_eq!(own.step(0.0, step_s), ERROR, "{step_s}");
        }
        assert_eq!(own.outputs(), outputs);
        assert_eq!(own.restart(), OK);
        assert_eq!(own.step(0.0, PERIOD_S), OK);
    }
}

/// Seconds since 1970 are a start, at which a double tells a quarter of a microsecond.
#[test]
fn an_instance_that_starts_late_makes_the_steps_it_is_asked_for() {
    let start_s = 1.7e9;
    for version in VERSIONS {
        let (mut own, other) = (Fmu::new(version), Fmu::started(version));
        // FMI 2.0 refuses it as it is set, FMI 3.0 as the initialisation is entered with it.
        assert!([own.0.start_at(f64::NAN), own.start()].contains(&ERROR));
        assert_eq!(own.0.reset(), OK);
        assert_eq!((own.0.start_at(f64::MAX), own.start()), (OK, ERROR));
        assert_eq!((own.0.start_at(start_s), own.start()), (OK, OK));
        let late = [own.0.start_at(0.0), own.start()];
        assert!(late.contains(&ERROR), "it runs: steps would be made for the time between");
        for k in 0..STEPS {
            let volts = if k < 10 { 3.0 } else { -1.0 };
            assert_eq!([own.set(VOLTAGE, volts), other.set(VOLTAGE, volts)], [OK; 2]);
            let from_s = f64::from(k) * PERIOD_S;
            let answers = [own.step(start_s + from_s, PERIOD_S), other.step(from_s, PERIOD_S)];
            assert_eq!(answers, [OK; 2]);
            assert_eq!(own.outputs(), other.outputs(), "step {k}");
        }
        assert_eq!(own.restore(&own.kept()), OK);
    }
}

#[test]
fn a_start_without_finite_outputs_is_refused() {
    for version in VERSIONS {
        let own = Fmu::new(version);
        let last = joint().variables().len() as u32 - 1;
        assert_eq!(joint().variables().last().unwrap().name, "initial.motor_speed_rad_per_s");
        for speed in [f64::NAN, f64::MAX] {
            assert_eq!(own.set(last, speed), OK);
            assert_eq!(own.start(), ERROR, "{speed}");
            assert_eq!(own.step(0.0, PERIOD_S), ERROR);
        }
        assert_eq!(own.set(last, 100.0), OK);
        assert_eq!(own.start(), OK);
        assert_eq!(own.set(last, 0.0), ERROR, "a parameter is fixed once initialised");
    }
}

#[test]
fn a_pointer_that_leads_nowhere_is_refused() {
    let own = Fmu::started(Version::Fmi2);
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
            fmi2GetReal(own.own, null(), 1, place),
            fmi2GetReal(own.own, &VOLTAGE, 1, null_mut()),
            fmi2SetReal(own.own, null(), 1, place),
            fmi2SetReal(own.own, &VOLTAGE, 1, null()),
            fmi2GetFMUstate(none, &mut state),
            fmi2GetFMUstate(own.own, null_mut()),
            fmi2SetFMUstate(own.own, null_mut()),
            fmi2SerializedFMUstateSize(own.own, null_mut(), &mut size),
            fmi2SerializeFMUstate(own.own, null_mut(), null_mut(), 0),
            fmi2DeSerializeFMUstate(own.own, null(), 8, &mut state),
            fmi2GetString(none, null(), 0, null_mut()),
        ]
    };
    assert_eq!(answers, [ERROR; 18]);
    // SAFETY: as above.
    unsafe {
        assert!(fmi2Instantiate(null(), 1, null(), null(), null(), 0, 0).is_null());
        fmi2FreeInstance(none);
        assert_eq!(fmi2FreeFMUstate(own.own, null_mut()), OK);
    }
}
